//! The claims and findings of the 2023 study, compared with records.

mod fairness;
mod judged;
mod verdict;

use crate::claims::fairness::Ratios;
use crate::claims::judged::{
    NOT_MEASURED, biases_matter, both_at_once, is_coarse_faces, is_dense8, is_fine_faces,
    is_plain_bricks, judge, less_is_faster, nothing, of, ratios, same_place, tree_is_constant,
    with_more,
};
use crate::record::{Record, quantile};
pub(crate) use verdict::{Claim, DeviceVerdict, Verdict};

/// The claims, in the study's order.
pub(crate) const ALL: &[Claim] = &[
    Claim {
        place: "§1.4",
        text: "Building only the bricks with surface is faster than building a dense volume.",
        reason: "Where a solid fills its box, few bricks of 32³ are empty. Few bricks can be skipped, so a sparse build costs as much as a dense one, plus the selection.",
        judge: less_is_faster,
    },
    Claim {
        place: "§1.4",
        text: "An octree makes frames slower.",
        reason: "Each step looks its brick up from the root. Rays that hit after few steps lose little time by that.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "frame_ms",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            judge(
                &ratios,
                |r| r > 1.0,
                "frame time of the octree relative to a dense volume without mips",
            )
        },
    },
    Claim {
        place: "§1.4",
        text: "An octree saves memory, because empty space is not stored.",
        reason: "The study's octree keeps its bricks in a dense texture. Sparse bricks are in a pool, which saves memory. At low resolutions, shared samples, tables and 16-bit codes cost more than the pool saves.",
        judge: |all| {
            let octree = ratios(
                all,
                "memory",
                "memory_bytes",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let octree = judge(
                &octree,
                |r| r < 1.0,
                "memory of the study's octree relative to a dense volume",
            );
            let bricks = ratios(all, "memory", "memory_bytes", is_plain_bricks, |r| {
                r.via == "dense"
            });
            let bricks = judge(
                &bricks,
                |r| r < 1.0,
                "memory of sparse bricks, with 16-bit codes and materials, relative to a dense volume",
            );
            with_more(octree, bricks)
        },
    },
    Claim {
        place: "§1.4",
        text: "An octree reduces the number of steps.",
        reason: "Rays cross empty cells one by one, and also visit nodes and cells. Only scenes with much empty space save samples.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "samples_mean",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let samples = judge(
                &ratios,
                |r| r < 1.0,
                "samples per ray of the octree relative to a dense volume",
            );
            let all_steps = self::ratios(
                all,
                "frames",
                "steps_mean",
                |r| r.via == "octree",
                |r| r.via == "dense",
            );
            let steps = judge(
                &all_steps,
                |r| r < 1.0,
                "steps with visited nodes and cells",
            );
            with_more(samples, steps)
        },
    },
    Claim {
        place: "§1.4",
        text: "The images remain comparable to those of a finely tessellated mesh.",
        reason: "At low resolutions, flat triangles and filtered distances have errors in different places.",
        judge: |all| {
            let ratios = ratios(all, "fidelity", "flip_mean", is_dense8, is_fine_faces);
            judge(
                &ratios,
                |r| r < 2.0,
                "FLIP error of an 8-bit dense volume relative to triangles of the same resolution with face normals, where less than 2 counts as comparable",
            )
        },
    },
    Claim {
        place: "§5.1.2",
        text: "The time to build the tree does not depend on the number of bricks. The time to fill them does.",
        reason: "The tree takes microseconds. On a CPU its time grows with its nodes. On a GPU, launching the passes takes most of the time.",
        judge: tree_is_constant,
    },
    Claim {
        place: "§5.2",
        text: "Frame times of the octree vary more.",
        reason: "Both vary with the view, and quick records have few frames.",
        judge: |all| {
            let spread = |r: &Record| -> Option<f64> {
                let samples = r.samples.get("frame_ms")?;
                Some(quantile(samples, 1.0)? - quantile(samples, 0.0)?)
            };
            let mut pairs = Ratios::default();
            for octree in of(all, "frames").filter(|r| r.via == "octree") {
                let twin = of(all, "frames").find(|r| r.via == "dense" && same_place(r, octree));
                if let Some((twin, (a, b))) =
                    twin.and_then(|twin| Some((twin, spread(octree).zip(spread(twin))?)))
                {
                    pairs.add_ratio("frame_ms", (octree, a), (twin, b));
                }
            }
            judge(
                &pairs,
                |r| r > 1.0,
                "range of frame times of the octree, from fastest to slowest, relative to a dense volume",
            )
        },
    },
    Claim {
        place: "§5.2.1",
        text: "No ray takes more than 128 to 134 steps, through the octree or the dense volume.",
        reason: "Rays along silhouettes take many short steps in a band of ±4 voxels, up to the limit. The study's views may have had no such rays.",
        judge: |all| {
            let most = |via: &str| {
                let measured = of(all, "heat").filter(|r| r.via == via);
                measured
                    .filter_map(|r| r.value("steps_max"))
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
                    "with a limit of 256 steps, rays took up to {dense:.0} steps through dense volumes with bands of ±4 voxels, and {octree:.0} through octrees, including nodes and cells"
                ),
            )
        },
    },
    Claim {
        place: "§5.2.1",
        text: "Mips would halve the number of steps.",
        reason: "The box is tight around the solid, so rays cross little empty space at these resolutions. Mips save steps where there is more.",
        judge: |all| {
            let ratios = ratios(
                all,
                "frames",
                "steps_mean",
                |r| r.via == "dense, mips",
                |r| r.via == "dense",
            );
            judge(
                &ratios,
                |r| r <= 0.6,
                "steps per ray with mips relative to steps without",
            )
        },
    },
    Claim {
        place: "§5.3",
        text: "Triangles are nearer to the field than the marched volume, by the number of pixels with equal Laplacians.",
        reason: "Here volumes are tight around the solid, and normals are differences over one voxel. The study used another step, and names it as the cause.",
        judge: |all| {
            let ratios = ratios(
                all,
                "fidelity",
                "laplacian_equal_pixels",
                is_coarse_faces,
                is_dense8,
            );
            judge(
                &ratios,
                |r| r > 1.0,
                "equal pixels of triangles with face normals at 100 voxels (48 on a software GPU), relative to a dense volume",
            )
        },
    },
    Claim {
        place: "§5.4",
        text: "The normal determines the result: another bias alone changes the image.",
        reason: "A small bias gives the exact surface, and a large one blurs it.",
        judge: biases_matter,
    },
    Claim {
        place: "§5.5",
        text: "A sparse structure is either easy to edit or fast to march.",
        reason: "An edit rebuilds only the bricks that it touches. Empty cells store a distance to the surface, so rays need no tree.",
        judge: both_at_once,
    },
    Claim {
        place: "§6",
        text: "Bricks need not be larger than 8³.",
        reason: "Rays take more samples in larger bricks, and skip more space between smaller ones.",
        judge: |all| {
            let ratios = ratios(
                all,
                "sweep",
                "frame_ms",
                |r| r.via == "bricks" && r.parameter("brick") == Some(8.0),
                |r| r.via == "bricks" && r.parameter("brick") == Some(16.0),
            );
            judge(
                &ratios,
                |r| r < 1.1,
                "frame time of sparse bricks of 8³ relative to 16³",
            )
        },
    },
];

/// Judges a claim from the records of each device, in the order of the records. Leaves out devices on which it was not
/// measured.
pub(crate) fn verdicts(claim: &Claim, records: &[&Record]) -> Vec<DeviceVerdict> {
    let mut devices: Vec<&str> = Vec::new();
    for record in records {
        if !devices.contains(&record.machine.device.as_str()) {
            devices.push(&record.machine.device);
        }
    }
    let judged = |device: &str| {
        let of_device = records.iter().copied();
        let of_device: Vec<&Record> = of_device.filter(|r| r.machine.device == device).collect();
        let (verdict, reason) = (claim.judge)(&of_device);
        (reason != NOT_MEASURED).then(|| DeviceVerdict {
            device: device.to_owned(),
            verdict,
            reason,
        })
    };
    devices.into_iter().filter_map(judged).collect()
}

/// Returns the text of a claim, with the reason why some records disagree, if some do.
pub(crate) fn with_reason(claim: &Claim, verdicts: &[DeviceVerdict]) -> String {
    if verdicts
        .iter()
        .all(|device| device.verdict == Verdict::Confirmed)
    {
        return claim.text.into();
    }
    format!("{} Why not: {}", claim.text, claim.reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(device: &str, via: &str, ms: f64) -> Record {
        let mut record = Record {
            experiment: "frames".into(),
            scene: "teapot".into(),
            via: via.into(),
            ..Record::default()
        };
        record.machine.device = device.into();
        record.values.insert("frame_ms".into(), ms);
        record
    }

    #[test]
    fn a_claim_is_judged_for_each_device() {
        let records = [
            frame("cpu (a)", "octree", 2.0),
            frame("cpu (a)", "dense", 1.0),
            frame("cpu (b)", "octree", 1.0),
            frame("cpu (b)", "dense", 2.0),
            frame("cpu (c)", "dense", 2.0),
        ];
        let borrowed: Vec<&Record> = records.iter().collect();
        let claim = ALL
            .iter()
            .find(|claim| claim.text == "An octree makes frames slower.")
            .expect("a claim");
        let found: Vec<(String, Verdict)> = verdicts(claim, &borrowed)
            .into_iter()
            .map(|verdict| (verdict.device, verdict.verdict))
            .collect();
        let expected = [
            ("cpu (a)".to_owned(), Verdict::Confirmed),
            ("cpu (b)".to_owned(), Verdict::Refuted),
        ];
        assert_eq!(found, expected);
        assert!(verdicts(claim, &[]).is_empty());
        // A device on which nothing of a claim was measured is left out, whatever its parts.
        for claim in ALL {
            assert!(verdicts(claim, &borrowed[4..]).is_empty(), "{}", claim.text);
        }
    }
}
