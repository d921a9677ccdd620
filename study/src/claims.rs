//! What the 2023 study supposed and found, held against records.

use crate::record::{Record, quantile};

/// What records say of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All that was measured agrees.
    Confirmed,
    /// All that was measured disagrees.
    Refuted,
    /// Some agrees and some does not, or nothing was measured.
    Undecided,
}

impl Verdict {
    /// In one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Refuted => "refuted",
            Self::Undecided => "undecided",
        }
    }
}

/// A claim, and how it is judged.
pub struct Claim {
    /// Where it stands.
    pub place: &'static str,
    /// What it says.
    pub text: &'static str,
    /// Where records say otherwise, why that is so.
    pub reason: &'static str,
    /// What records say of it.
    pub judge: fn(&[&Record]) -> (Verdict, String),
}

/// In the study's order.
pub const ALL: &[Claim] = &[
    Claim {
        place: "§1.4",
        text: "Building only what holds the surface is faster than building everything.",
        reason: "Where a solid fills its box, few bricks of 32³ are empty: there is little to leave out, and the sparse way costs what the dense one does, and the choice besides.",
        judge: less_is_faster,
    },
    Claim {
        place: "§1.4",
        text: "An octree makes frames slower.",
        reason: "Each step looks its brick up from the root; where rays hit soon, that is little.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "frame_ms",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            told(
                &ratios,
                |r| r > 1.0,
                "of a frame through a dense volume without mips, one through the octree takes",
            )
        },
    },
    Claim {
        place: "§1.4",
        text: "It saves memory, as what it does not refer to need not be stored.",
        reason: "The study's bricks stay where a dense texture has them; a pool, as sparse bricks have, gives memory back. At low resolutions aprons, tables and 16 bits outweigh what is left out.",
        judge: |all| {
            let octree = ratios(
                all,
                "memory",
                "memory_bytes",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let (verdict, why) = told(
                &octree,
                |r| r < 1.0,
                "of a dense volume's bytes, the study's octree, whose bricks lie where a dense volume has them, holds",
            );
            let bricks = ratios(all, "memory", "memory_bytes", is_plain_bricks, |r| {
                r.via == "dense"
            });
            let (_, own) = told(
                &bricks,
                |r| r < 1.0,
                "sparse bricks, with twice the bits and materials, hold",
            );
            (verdict, format!("{why}; {own}"))
        },
    },
    Claim {
        place: "§1.4",
        text: "It reduces the number of steps.",
        reason: "Empty cells are crossed one by one, and nodes and cells are looked at besides samples: only where much is empty are samples saved.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "samples_mean",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let (verdict, why) = told(
                &ratios,
                |r| r < 1.0,
                "of the samples through a dense volume, a ray through the octree takes",
            );
            let all_steps = self::ratios(
                all,
                "frames",
                "steps_mean",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let (_, steps) = told(&all_steps, |r| r < 1.0, "with nodes and cells counted");
            (verdict, format!("{why}; {steps}"))
        },
    },
    Claim {
        place: "§1.4",
        text: "The pictures remain comparable to those of a finely tessellated mesh.",
        reason: "At low resolutions flat triangles and filtered distances err in different places.",
        judge: |all| {
            let ratios = ratios(all, "fidelity", "flip_mean", is_dense8, is_fine_faces);
            told(
                &ratios,
                |r| r < 2.0,
                "comparable is less than twice the FLIP error of triangles of the same resolution with their own normals, of which a dense volume of 8 bits has",
            )
        },
    },
    Claim {
        place: "§5.1.2",
        text: "Building the tree takes the same time whatever the number of bricks; filling grows with it.",
        reason: "The tree takes microseconds; on a CPU it grows with its nodes, on a GPU the passes' launches take most of it.",
        judge: tree_is_constant,
    },
    Claim {
        place: "§5.2",
        text: "Frames through the octree vary more.",
        reason: "Both vary with what is in view; quick records have few frames.",
        judge: |all| {
            let spread = |r: &Record| -> Option<f64> {
                let samples = r.samples.get("frame_ms")?;
                Some(quantile(samples, 1.0)? - quantile(samples, 0.0)?)
            };
            let mut pairs = Vec::new();
            for octree in of(all, "frames").filter(|r| r.via == "octree") {
                let twin = of(all, "frames").find(|r| r.via == "dense" && same_place(r, octree));
                if let Some((a, b)) = twin.and_then(|twin| spread(octree).zip(spread(twin))) {
                    pairs.push((octree.machine.device.clone(), a / b));
                }
            }
            told(
                &pairs,
                |r| r > 1.0,
                "of the milliseconds between the fastest frame and the slowest through a dense volume, through the octree they are",
            )
        },
    },
    Claim {
        place: "§5.2.1",
        text: "No ray takes more than 128 to 134 steps, through either.",
        reason: "Rays along silhouettes creep through a band of ±4 voxels until the limit; the study's views may have had none that long.",
        judge: |all| {
            let most = |via: &str| {
                let own = of(all, "heat").filter(|r| r.via == via);
                own.filter_map(|r| r.value("steps_max"))
                    .fold(f64::NAN, f64::max)
            };
            let (dense, octree) = (most("dense"), most("octree"));
            if dense.is_nan() || octree.is_nan() {
                return nothing();
            }
            let holds = dense <= 134.0 && octree <= 134.0;
            let verdict = if holds {
                Verdict::Confirmed
            } else {
                Verdict::Refuted
            };
            (
                verdict,
                format!(
                    "with 256 allowed, rays took up to {dense:.0} through dense volumes of ±4 voxels and {octree:.0} through octrees, nodes and cells counted"
                ),
            )
        },
    },
    Claim {
        place: "§5.2.1",
        text: "Mips would halve the number of steps.",
        reason: "In a box that is tight around the solid rays have little way through empty space, at these resolutions; mips pay where there is more.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "steps_mean",
                |r| r.via == "dense, mips",
                |r| r.via == "dense",
            );
            told(
                &ratios,
                |r| r <= 0.6,
                "of a ray's steps without mips, with them it takes",
            )
        },
    },
    Claim {
        place: "§5.3",
        text: "Triangles are nearer to the field than the marched volume, by pixels whose Laplacians are equal.",
        reason: "Here volumes are tight around the solid and normals are differences over a voxel's width; the study's were over another, which it names as the cause.",
        judge: |all| {
            let ratios = ratios(
                all,
                "fidelity",
                "laplacian_equal_pixels",
                is_coarse_faces,
                is_dense8,
            );
            told(
                &ratios,
                |r| r > 1.0,
                "of the dense volume's equal pixels, triangles at 100 voxels (48 in software) with their own normals have",
            )
        },
    },
    Claim {
        place: "§5.4",
        text: "The normal decides the result: another bias alone changes the picture.",
        reason: "The exact surface is smooth where the bias is small, and blurred where it is large.",
        judge: biases_matter,
    },
    Claim {
        place: "§5.5",
        text: "A sparse structure is either easily edited or fast to march.",
        reason: "An edit makes the touched bricks alone again, and cells without a brick know how far the surface is, so that rays need no tree.",
        judge: both_at_once,
    },
    Claim {
        place: "§6",
        text: "Bricks need not be larger than 8³.",
        reason: "Larger bricks are filtered over longer ways; smaller ones skip more.",
        judge: |all| {
            let ratios = ratios(
                all,
                "sweep",
                "frame_ms",
                |r| r.via == "bricks" && r.parameter("brick") == Some(8.0),
                |r| r.via == "bricks" && r.parameter("brick") == Some(16.0),
            );
            told(
                &ratios,
                |r| r < 1.1,
                "of a frame through sparse bricks of 16³, one through 8³ takes",
            )
        },
    },
];

/// What is said of a claim: where it does not hold, with the reason.
pub fn with_reason(claim: &Claim, verdict: Verdict, why: String) -> String {
    if verdict == Verdict::Confirmed || why == NOT_MEASURED {
        return why;
    }
    format!("{why}. {}", claim.reason)
}

const NOT_MEASURED: &str = "not measured";

fn nothing() -> (Verdict, String) {
    (Verdict::Undecided, NOT_MEASURED.into())
}

fn of<'a>(all: &'a [&Record], experiment: &'a str) -> impl Iterator<Item = &'a Record> {
    let own = move |r: &&Record| r.experiment == experiment && r.error.is_none();
    all.iter().copied().filter(own)
}

fn is_plain_bricks(r: &Record) -> bool {
    r.via == "bricks" && !r.parameters.contains_key("bits")
}

fn is_dense8(r: &Record) -> bool {
    r.via == "dense" && r.parameter("bits").is_none_or(|bits| bits == 8.0)
}

fn has_faces(r: &Record) -> bool {
    r.via == "mesh" && r.parameters.contains_key("normals")
}

fn is_coarse_faces(r: &Record) -> bool {
    // The study's, and where software takes too long for it, half of that.
    has_faces(r)
        && r.parameter("resolution")
            .is_some_and(|n| n == 100.0 || n == 48.0)
}

fn is_fine_faces(r: &Record) -> bool {
    has_faces(r) && !is_coarse_faces(r)
}

/// Of one scene, seen alike, by one device.
fn same_place(a: &Record, b: &Record) -> bool {
    a.scene == b.scene
        && a.machine.device == b.machine.device
        && a.machine.processor == b.machine.processor
        && a.parameters.get("eye") == b.parameters.get("eye")
        && a.parameters.get("size") == b.parameters.get("size")
}

/// Of a device.
type Ratio = (String, f64);

/// A value of some records over that of others of the same place; the resolution is the same where more than one of the
/// latter is of that place.
fn ratios(
    all: &[&Record],
    experiment: &str,
    value: &str,
    above: impl Fn(&Record) -> bool,
    below: impl Fn(&Record) -> bool,
) -> Vec<Ratio> {
    let mut found = Vec::new();
    for a in of(all, experiment).filter(|r| above(r)) {
        let twins: Vec<&Record> = of(all, experiment)
            .filter(|r| below(r) && same_place(r, a))
            .collect();
        let alike = |r: &&&Record| r.parameter("resolution") == a.parameter("resolution");
        let twin = twins.iter().find(alike).or(twins.first());
        let Some(b) = twin.filter(|_| twins.len() == 1 || twins.iter().any(|r| alike(&r))) else {
            continue;
        };
        let device = a.machine.device.clone();
        if let (Some(a), Some(b)) = (a.value(value), b.value(value))
            && b > 0.0
        {
            found.push((device, a / b));
        }
    }
    found
}

/// A verdict on ratios, with their range on each device.
fn told(ratios: &[Ratio], holds: impl Fn(f64) -> bool, what: &str) -> (Verdict, String) {
    if ratios.is_empty() {
        return nothing();
    }
    let all: Vec<bool> = ratios.iter().map(|(_, r)| holds(*r)).collect();
    let range = ranges(ratios, "");
    let held = format!(
        "{} of {} agree",
        all.iter().filter(|h| **h).count(),
        all.len()
    );
    (verdict(&all), format!("{what} {range} ({held})"))
}

/// Of what holds and what does not.
fn verdict(held: &[bool]) -> Verdict {
    if held.iter().all(|h| *h) {
        Verdict::Confirmed
    } else if held.iter().any(|h| *h) {
        Verdict::Undecided
    } else {
        Verdict::Refuted
    }
}

/// From the least to the greatest of each device, which is named where there are several.
fn ranges(all: &[Ratio], unit: &str) -> String {
    let mut devices: Vec<(&str, f64, f64)> = Vec::new();
    for (device, value) in all {
        match devices.iter_mut().find(|(known, _, _)| known == device) {
            Some((_, least, most)) => (*least, *most) = (least.min(*value), most.max(*value)),
            None => devices.push((device, *value, *value)),
        }
    }
    let number = crate::shown::number;
    let one = |(device, least, most): &(&str, f64, f64)| {
        let [least, most] = [least, most].map(|v| number(*v));
        let range = if least == most {
            format!("{least}{unit}")
        } else {
            format!("{least} to {most}{unit}")
        };
        if devices.len() == 1 {
            range
        } else {
            format!("{range} on {device}")
        }
    };
    devices.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// With few of its bricks full, and with all.
fn less_is_faster(all: &[&Record]) -> (Verdict, String) {
    let mut told = Vec::new();
    let mut holds = Vec::new();
    for dense in of(all, "construction").filter(|r| r.via == "dense") {
        let device = &dense.machine.device;
        let same = |r: &&Record| r.machine.device == *device && r.via == "octree";
        let mut own: Vec<(f64, f64)> = of(all, "construction")
            .filter(same)
            .filter(|r| !r.parameters.contains_key("sort"))
            .filter_map(|r| Some((r.value("bricks")?, r.value("build_ms")?)))
            .collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (Some(few), Some(many), Some(whole)) =
            (own.first(), own.last(), dense.value("build_ms"))
        else {
            continue;
        };
        let number = crate::shown::number;
        told.push(format!(
            "on {device} an octree of {} bricks takes {} of the time of the whole volume, one of {} bricks {}",
            number(few.0),
            number(few.1 / whole),
            number(many.0),
            number(many.1 / whole)
        ));
        holds.push(few.1 < whole);
    }
    let of_scenes = ratios(
        all,
        "dense-fill",
        "build_ms",
        |r| r.via == "octree",
        |r| r.via == "dense" && !r.parameters.contains_key("fill"),
    );
    if !of_scenes.is_empty() {
        holds.extend(of_scenes.iter().map(|(_, r)| *r < 1.0));
        let range = ranges(&of_scenes, "");
        told.push(format!(
            "of the brick and the teapot, whose boxes are tight, it takes {range}"
        ));
    }
    if told.is_empty() {
        return nothing();
    }
    (verdict(&holds), told.join("; "))
}

fn tree_is_constant(all: &[&Record]) -> (Verdict, String) {
    let own: Vec<&Record> = of(all, "construction")
        .filter(|r| r.via == "octree" && !r.parameters.contains_key("sort"))
        .collect();
    let ends = |device: &str, name: &str| -> Option<f64> {
        let of_device = || own.iter().filter(|r| r.machine.device == device);
        let bricks = |r: &&&Record| r.value("bricks").unwrap_or(0.0) as u64;
        let (few, many) = (
            of_device().min_by_key(bricks)?,
            of_device().max_by_key(bricks)?,
        );
        Some(many.value(name)? / few.value(name)?.max(1e-6))
    };
    let mut devices: Vec<&str> = own.iter().map(|r| r.machine.device.as_str()).collect();
    devices.dedup();
    let mut told = Vec::new();
    let mut holds = Vec::new();
    for device in devices {
        if let Some((tree, fill)) = ends(device, "tree_ms").zip(ends(device, "fill_ms")) {
            told.push(format!(
                "on {device}, from the fewest bricks to the most, the tree takes {tree:.1} times as long and filling {fill:.1} times"
            ));
            holds.push(tree < 2.0 && fill > 2.0);
        }
    }
    if holds.is_empty() {
        return nothing();
    }
    (verdict(&holds), told.join("; "))
}

/// How far the likeness goes over the biases, on each device.
fn biases_matter(all: &[&Record]) -> (Verdict, String) {
    let mut devices: Vec<(&str, f64, f64)> = Vec::new();
    for record in of(all, "normals").filter(|r| r.via == "dense") {
        let Some(value) = record.value("laplacian_mean_abs") else {
            continue;
        };
        let device = record.machine.device.as_str();
        match devices.iter_mut().find(|(known, _, _)| *known == device) {
            Some((_, least, most)) => (*least, *most) = (least.min(value), most.max(value)),
            None => devices.push((device, value, value)),
        }
    }
    // One bias alone tells nothing.
    devices.retain(|(_, least, most)| most > least);
    if devices.is_empty() {
        return nothing();
    }
    let held: Vec<bool> = devices
        .iter()
        .map(|(_, least, most)| *most > 1.5 * least)
        .collect();
    let told = devices.iter().map(|(device, least, most)| {
        format!("on {device}, over the biases that were tried, the mean difference of Laplacians goes from {least:.2} to {most:.2} of 255")
    });
    (verdict(&held), told.collect::<Vec<_>>().join("; "))
}

/// Fast to march: no slower than the dense volume with mips. Easily edited: an edit takes less than a tenth of making the
/// volume again, as the octree and the dense volume are.
fn both_at_once(all: &[&Record]) -> (Verdict, String) {
    let frames = ratios(
        all,
        "frames",
        "frame_ms",
        |r| r.via == "bricks",
        |r| r.via == "dense, mips",
    );
    let edits: Vec<Ratio> = of(all, "edits")
        .filter(|r| r.via == "bricks")
        .filter_map(|r| Some((r.machine.device.clone(), r.value("edit_ms")?)))
        .collect();
    let again = ratios(
        all,
        "edits",
        "edit_ms",
        |r| r.via == "bricks" && r.scene == "csg20",
        |r| r.via == "dense",
    );
    if frames.is_empty() || edits.is_empty() || again.is_empty() {
        return nothing();
    }
    let (_, marched) = told(
        &frames,
        |r| r <= 1.0,
        "of a frame through a dense volume with mips, one through sparse bricks takes",
    );
    // The claim falls where both are had.
    let slow = frames.iter().map(|(_, r)| *r > 1.0);
    let slow: Vec<bool> = slow.chain(again.iter().map(|(_, r)| *r > 0.1)).collect();
    let (edits, again) = (ranges(&edits, " ms"), ranges(&again, ""));
    (
        verdict(&slow),
        format!(
            "{marched}, and an edit of them takes {edits} (medians), of making a dense volume again {again}"
        ),
    )
}
