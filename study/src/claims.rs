//! The claims and findings of the 2023 study, compared with records.

mod judged;
mod verdict;

use crate::claims::judged::{
    NOT_MEASURED, biases_matter, both_at_once, is_coarse_faces, is_dense8, is_fine_faces,
    is_plain_bricks, judge, less_is_faster, nothing, of, ratios, same_place, tree_is_constant,
};
use crate::record::{Record, quantile};
pub(crate) use verdict::{Claim, Verdict};

/// The claims, in the study's order.
pub(crate) const ALL: &[Claim] = &[
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
            judge(
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
            let (verdict, why) = judge(
                &octree,
                |r| r < 1.0,
                "of a dense volume's bytes, the study's octree, whose bricks lie where a dense volume has them, holds",
            );
            let bricks = ratios(all, "memory", "memory_bytes", is_plain_bricks, |r| {
                r.via == "dense"
            });
            let (_, own) = judge(
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
            let (verdict, why) = judge(
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
            let (_, steps) = judge(&all_steps, |r| r < 1.0, "with nodes and cells counted");
            (verdict, format!("{why}; {steps}"))
        },
    },
    Claim {
        place: "§1.4",
        text: "The pictures remain comparable to those of a finely tessellated mesh.",
        reason: "At low resolutions flat triangles and filtered distances err in different places.",
        judge: |all| {
            let ratios = ratios(all, "fidelity", "flip_mean", is_dense8, is_fine_faces);
            judge(
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
            judge(
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
            judge(
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
            judge(
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
            judge(
                &ratios,
                |r| r < 1.1,
                "of a frame through sparse bricks of 16³, one through 8³ takes",
            )
        },
    },
];

/// Returns the text about a claim, with the reason if it does not hold.
pub(crate) fn with_reason(claim: &Claim, verdict: Verdict, why: String) -> String {
    if verdict == Verdict::Confirmed || why == NOT_MEASURED {
        return why;
    }
    format!("{why}. {}", claim.reason)
}
