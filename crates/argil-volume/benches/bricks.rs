//! Sparse bricks: duration and memory of a bake, for scenes from the command line, or for csg20, which must have
//! 3,629 bricks at 256³.
//!
//! `cargo bench -p argil-volume --bench bricks -- [SCENE.json …]`

use argil_field::Program;
use argil_math::Aabb;
use argil_scene::Scene;
use argil_volume::{
    BrickLayout, BrickSettings, BrickTimings, Bricks, Dense, SampleFormat, VoxelGrid,
};
use std::time::Instant;

const EXPECTED_BRICKS: usize = 3629;

fn main() {
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json").to_owned();
    let mut paths: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    if paths.is_empty() {
        paths.push(own);
    }
    for path in paths {
        let scene = Scene::open(&path).expect("a scene");
        let program = Program::lower(&scene).expect("the scene can be lowered");
        let frame = scene
            .view
            .bounds
            .map(|[min, max]| Aabb::new(min.into(), max.into()));
        for resolution in [256, 512, 1024] {
            let voxel_grid =
                VoxelGrid::fitting(program.aabb(), frame, resolution).expect("a voxel grid");
            let dense = Dense::bytes_of(&voxel_grid, SampleFormat::Snorm8, false);
            let settings = BrickSettings::default();
            let layout = BrickLayout::new(voxel_grid, &settings).expect("a layout");
            let mut all: Vec<(f64, BrickTimings)> = Vec::new();
            let mut kept = None;
            for _ in 0..7 {
                drop(kept.take());
                let start = Instant::now();
                let (bricks, stages) = Bricks::bake(&program, layout, None).expect("bricks");
                all.push((start.elapsed().as_secs_f64() * 1e3, stages));
                kept = Some(bricks);
            }
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (ms, stages) = all[all.len() / 2];
            let bricks = kept.expect("bricks");
            if path.ends_with("csg20.json") && resolution == 256 {
                assert_eq!(bricks.len(), EXPECTED_BRICKS);
            }
            let bytes = bricks.memory_bytes();
            let narrow = bytes - bricks.pool().bytes().len() as u64 / 2;
            println!(
                "{path} {:?}: {ms:.2} ms ({:.2}, {:.2}, {:.2}), {} bricks, {:.2} MB: 1/{:.1} of dense, with 8 bits 1/{:.1}",
                voxel_grid.size.to_array(),
                stages.prune,
                stages.fill,
                stages.release,
                bricks.len(),
                bytes as f64 / 1e6,
                dense as f64 / bytes as f64,
                dense as f64 / narrow as f64,
            );
        }
    }
}
