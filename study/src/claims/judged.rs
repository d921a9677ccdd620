//! Judges claims from records.

use super::verdict::Verdict;
use crate::record::Record;

pub(super) const NOT_MEASURED: &str = "not measured";

pub(super) fn nothing() -> (Verdict, String) {
    (Verdict::Undecided, NOT_MEASURED.into())
}

pub(super) fn of<'a>(all: &'a [&Record], experiment: &'a str) -> impl Iterator<Item = &'a Record> {
    let own = move |r: &&Record| r.experiment == experiment && r.error.is_none();
    all.iter().copied().filter(own)
}

pub(super) fn is_plain_bricks(r: &Record) -> bool {
    r.via == "bricks" && !r.parameters.contains_key("bits")
}

pub(super) fn is_dense8(r: &Record) -> bool {
    r.via == "dense" && r.parameter("bits").is_none_or(|bits| bits == 8.0)
}

pub(super) fn has_faces(r: &Record) -> bool {
    r.via == "mesh" && r.parameters.contains_key("normals")
}

pub(super) fn is_coarse_faces(r: &Record) -> bool {
    // The study's number of bricks, or half of it where software takes too long.
    has_faces(r)
        && r.parameter("resolution")
            .is_some_and(|n| n == 100.0 || n == 48.0)
}

pub(super) fn is_fine_faces(r: &Record) -> bool {
    has_faces(r) && !is_coarse_faces(r)
}

/// Returns true if two records have the same scene, camera and device.
pub(super) fn same_place(a: &Record, b: &Record) -> bool {
    a.scene == b.scene
        && a.machine.device == b.machine.device
        && a.machine.processor == b.machine.processor
        && a.parameters.get("eye") == b.parameters.get("eye")
        && a.parameters.get("size") == b.parameters.get("size")
}

/// A ratio on a device.
pub(super) type Ratio = (String, f64);

/// Returns ratios of a value between matching records. Resolutions must match too, if several records of the
/// divisor match.
pub(super) fn ratios(
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
        if let (Some(a), Some(b)) = (at_equal_clocks(a, value), at_equal_clocks(b, value))
            && b > 0.0
        {
            found.push((device, a / b));
        }
    }
    found
}

/// Returns a value, and for the time of a frame, that time in clocks of the GPU, if its clock is known. A data center's
/// GPU runs at a fifth of its clock while frames are short.
fn at_equal_clocks(record: &Record, value: &str) -> Option<f64> {
    let is_frame = value == "frame_ms";
    let clock = record.value("gpu_clock_mhz").filter(|_| is_frame);
    Some(record.value(value)? * clock.unwrap_or(1.0))
}

/// Returns a verdict on ratios, with their range on each device.
pub(super) fn judge(
    ratios: &[Ratio],
    holds: impl Fn(f64) -> bool,
    what: &str,
) -> (Verdict, String) {
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
    (verdict(&all), format!("{what}: {range} ({held})"))
}

/// Returns the verdict of single results.
pub(super) fn verdict(held: &[bool]) -> Verdict {
    if held.iter().all(|h| *h) {
        Verdict::Confirmed
    } else if held.iter().any(|h| *h) {
        Verdict::Undecided
    } else {
        Verdict::Refuted
    }
}

/// Formats the minimum and maximum of each device, which is named if there are several.
pub(super) fn ranges(all: &[Ratio], unit: &str) -> String {
    let mut devices: Vec<(&str, f64, f64)> = Vec::new();
    for (device, value) in all {
        match devices.iter_mut().find(|(known, _, _)| known == device) {
            Some((_, least, most)) => (*least, *most) = (least.min(*value), most.max(*value)),
            None => devices.push((device, *value, *value)),
        }
    }
    let number = crate::formatting::number;
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

/// Compares the build times of octrees with those of dense volumes.
pub(super) fn less_is_faster(all: &[&Record]) -> (Verdict, String) {
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
        let number = crate::formatting::number;
        told.push(format!(
            "on {device}, the octree with the fewest bricks ({}) takes {} times as long to build as the dense volume, and the one with the most ({}) {} times",
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
            "for the brick and the teapot, whose boxes are tight, this ratio is {range}"
        ));
    }
    if told.is_empty() {
        return nothing();
    }
    (verdict(&holds), told.join("; "))
}

pub(super) fn tree_is_constant(all: &[&Record]) -> (Verdict, String) {
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
                "on {device}, with the most bricks, the tree takes {tree:.1} times as long as with the fewest, and filling takes {fill:.1} times as long"
            ));
            holds.push(tree < 2.0 && fill > 2.0);
        }
    }
    if holds.is_empty() {
        return nothing();
    }
    (verdict(&holds), told.join("; "))
}

/// Compares the errors over the biases, on each device.
pub(super) fn biases_matter(all: &[&Record]) -> (Verdict, String) {
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
    // A single bias shows nothing.
    devices.retain(|(_, least, most)| most > least);
    if devices.is_empty() {
        return nothing();
    }
    let held: Vec<bool> = devices
        .iter()
        .map(|(_, least, most)| *most > 1.5 * least)
        .collect();
    let told = devices.iter().map(|(device, least, most)| {
        format!("on {device}, the mean difference of Laplacians is {least:.2} to {most:.2} of 255, depending on the bias")
    });
    (verdict(&held), told.collect::<Vec<_>>().join("; "))
}

/// Fast to march: no slower than the dense volume with mips. Easy to edit: an edit takes less than a tenth of a
/// rebuild, which the octree and the dense volume need.
pub(super) fn both_at_once(all: &[&Record]) -> (Verdict, String) {
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
    let (_, marched) = judge(
        &frames,
        |r| r <= 1.0,
        "frame time of sparse bricks relative to a dense volume with mips",
    );
    // The claim is refuted where both hold.
    let slow = frames.iter().map(|(_, r)| *r > 1.0);
    let slow: Vec<bool> = slow.chain(again.iter().map(|(_, r)| *r > 0.1)).collect();
    let (edits, again) = (ranges(&edits, " ms"), ranges(&again, ""));
    (
        verdict(&slow),
        format!(
            "{marched}; the median edit takes {edits}, and relative to a rebuild of the dense volume {again}"
        ),
    )
}
