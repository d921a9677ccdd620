//! Judges claims from records.

use super::fairness::Ratios;
use super::verdict::Verdict;
use crate::record::Record;

pub(super) const NOT_MEASURED: &str = "not measured";

pub(super) fn nothing() -> (Verdict, String) {
    (Verdict::Undecided, NOT_MEASURED.into())
}

pub(super) fn of<'a>(all: &'a [&Record], experiment: &'a str) -> impl Iterator<Item = &'a Record> {
    let is_done = move |r: &&Record| r.experiment == experiment && r.error.is_none();
    all.iter().copied().filter(is_done)
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

/// Returns true if two records have the same scene, camera, light and device.
pub(super) fn same_place(a: &Record, b: &Record) -> bool {
    a.scene == b.scene
        && a.machine.device == b.machine.device
        && a.machine.processor == b.machine.processor
        && a.parameters.get("eye") == b.parameters.get("eye")
        && a.parameters.get("light") == b.parameters.get("light")
        && a.parameters.get("size") == b.parameters.get("size")
}

/// Returns ratios of a value between matching records. Resolutions must match too, if the value is a time or several records
/// of the divisor match.
pub(super) fn ratios(
    all: &[&Record],
    experiment: &str,
    value: &str,
    above: impl Fn(&Record) -> bool,
    below: impl Fn(&Record) -> bool,
) -> Ratios {
    let mut found = Ratios::default();
    for a in of(all, experiment).filter(|r| above(r)) {
        let twins: Vec<&Record> = of(all, experiment)
            .filter(|r| below(r) && same_place(r, a))
            .collect();
        let alike = |r: &&&Record| r.parameter("resolution") == a.parameter("resolution");
        let twin = twins.iter().find(alike).or(twins.first());
        let is_single = twins.len() == 1 && !value.ends_with("_ms");
        let is_clear = is_single || twins.iter().any(|r| alike(&r));
        if let Some(b) = twin.filter(|_| is_clear) {
            found.add(value, a, b);
        }
    }
    found
}

/// Returns a verdict on ratios, with their range.
pub(super) fn judge(ratios: &Ratios, holds: impl Fn(f64) -> bool, what: &str) -> (Verdict, String) {
    let left_out = ratios.left_out();
    if ratios.values.is_empty() {
        let (verdict, text) = nothing();
        // Pairs that are not compared are named even if none is left.
        let text = if left_out.is_empty() {
            text
        } else {
            format!("{what}: no pair is compared{left_out}")
        };
        return (verdict, text);
    }
    let all: Vec<bool> = ratios.values.iter().map(|r| holds(*r)).collect();
    let range = range(&ratios.values, "");
    let agreeing = all.iter().filter(|h| **h).count();
    let count = all.len();
    (
        verdict(&all),
        format!("{what}: {range} ({agreeing} of {count} agree{left_out})"),
    )
}

/// Adds what else was measured to a verdict.
pub(super) fn with_more(
    (verdict, text): (Verdict, String),
    (_, more): (Verdict, String),
) -> (Verdict, String) {
    if text == NOT_MEASURED || more == NOT_MEASURED {
        return (verdict, text);
    }
    (verdict, format!("{text}; {more}"))
}

/// Returns the verdict of single results.
pub(super) fn verdict(held: &[bool]) -> Verdict {
    if held.is_empty() {
        Verdict::Undecided
    } else if held.iter().all(|h| *h) {
        Verdict::Confirmed
    } else if held.iter().any(|h| *h) {
        Verdict::Undecided
    } else {
        Verdict::Refuted
    }
}

/// Formats the minimum and maximum.
pub(super) fn range(all: &[f64], unit: &str) -> String {
    let (least, most) = all
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(*v), b.max(*v))
        });
    let [least, most] = [least, most].map(crate::formatting::number);
    if least == most {
        format!("{least}{unit}")
    } else {
        format!("{least} to {most}{unit}")
    }
}

/// Returns the octrees of the experiment on build times with the fewest and the most bricks.
fn octree_ends<'a>(all: &[&'a Record]) -> Option<[&'a Record; 2]> {
    let built = all.iter().copied().filter(|r| {
        r.experiment == "construction"
            && r.error.is_none()
            && r.via == "octree"
            && !r.parameters.contains_key("sort")
    });
    let bricks = |r: &&Record| r.value("bricks").unwrap_or(0.0) as u64;
    Some([built.clone().min_by_key(bricks)?, built.max_by_key(bricks)?])
}

/// Compares the build times of octrees with those of dense volumes.
pub(super) fn less_is_faster(all: &[&Record]) -> (Verdict, String) {
    let number = crate::formatting::number;
    let mut parts = Vec::new();
    let mut holds = Vec::new();
    let dense = of(all, "construction").find(|r| r.via == "dense");
    if let Some((dense, [few, many])) = dense.zip(octree_ends(all)) {
        let mut ratios = Ratios::default();
        ratios.add("build_ms", few, dense);
        ratios.add("build_ms", many, dense);
        let left_out = ratios.left_out();
        if let [least, most] = ratios.values[..] {
            let bricks = [few, many].map(|r| number(r.value("bricks").unwrap_or(0.0)));
            parts.push(format!(
                "the octree with the fewest bricks ({}) takes {} times as long to build as the dense volume, and the one with the most ({}) {} times{left_out}",
                bricks[0],
                number(least),
                bricks[1],
                number(most)
            ));
            holds.push(least < 1.0);
        } else if !left_out.is_empty() {
            parts.push(format!("the octree and the dense volume{left_out}"));
        }
    }
    let of_scenes = ratios(
        all,
        "dense-fill",
        "build_ms",
        |r| r.via == "octree",
        |r| r.via == "dense" && !r.parameters.contains_key("fill"),
    );
    let left_out = of_scenes.left_out();
    if !of_scenes.values.is_empty() {
        holds.extend(of_scenes.values.iter().map(|r| *r < 1.0));
        parts.push(format!(
            "for the brick and the teapot, whose boxes are tight, this ratio is {}{left_out}",
            range(&of_scenes.values, "")
        ));
    } else if !left_out.is_empty() {
        parts.push(format!("for the brick and the teapot{left_out}"));
    }
    if parts.is_empty() {
        return nothing();
    }
    (verdict(&holds), parts.join("; "))
}

/// Compares the times of the stages of the octrees with the fewest and the most bricks.
pub(super) fn tree_is_constant(all: &[&Record]) -> (Verdict, String) {
    let Some([few, many]) = octree_ends(all) else {
        return nothing();
    };
    let stage = |name: &str| {
        let mut ratios = Ratios::default();
        ratios.add(name, many, few);
        ratios
    };
    let stages = ["tree_ms", "fill_ms"].map(stage);
    match (&stages[0].values[..], &stages[1].values[..]) {
        ([tree], [fill]) => (
            verdict(&[*tree < 2.0 && *fill > 2.0]),
            format!(
                "with the most bricks, the tree takes {tree:.1} times as long as with the fewest, and filling takes {fill:.1} times as long"
            ),
        ),
        _ if stages[0].left_out().is_empty() => nothing(),
        _ => (
            Verdict::Undecided,
            format!("the stages of the build{}", stages[0].left_out()),
        ),
    }
}

/// Compares the errors over the biases.
pub(super) fn biases_matter(all: &[&Record]) -> (Verdict, String) {
    let dense = of(all, "normals").filter(|r| r.via == "dense");
    let values: Vec<f64> = dense
        .filter_map(|r| r.value("laplacian_mean_abs"))
        .collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A single bias shows nothing.
    if most <= least {
        return nothing();
    }
    (
        verdict(&[most > 1.5 * least]),
        format!(
            "the mean difference of Laplacians is {least:.2} to {most:.2} of 255, depending on the bias"
        ),
    )
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
    let edits = of(all, "edits").filter(|r| r.via == "bricks");
    let edits: Vec<f64> = edits.filter_map(|r| r.value("edit_ms")).collect();
    let again = ratios(
        all,
        "edits",
        "edit_ms",
        |r| r.via == "bricks" && r.scene == "csg20",
        |r| r.via == "dense",
    );
    let (_, marched) = judge(
        &frames,
        |r| r <= 1.0,
        "frame time of sparse bricks relative to a dense volume with mips",
    );
    if frames.values.is_empty() || edits.is_empty() || again.values.is_empty() {
        let left_out = format!("{}{}", frames.left_out(), again.left_out());
        if left_out.is_empty() {
            return nothing();
        }
        return (
            Verdict::Undecided,
            format!("frames and edits are not all measured{left_out}"),
        );
    }
    // The claim is refuted where both hold.
    let slow = frames.values.iter().map(|r| *r > 1.0);
    let slow: Vec<bool> = slow.chain(again.values.iter().map(|r| *r > 0.1)).collect();
    let (edits, left_out) = (range(&edits, " ms"), again.left_out());
    let again = range(&again.values, "");
    (
        verdict(&slow),
        format!(
            "{marched}; the median edit takes {edits}, and relative to a rebuild of the dense volume {again}{left_out}"
        ),
    )
}
