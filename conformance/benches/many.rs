//! Bakes bricks at 512³ of 100, 1,000 and 10,000 random brushes with the same surface before they are joined, in
//! turns. The duration should follow the surface and not the brushes. The number of bricks must be equal each time.

use argil_conformance::random_scene;
use argil_field::Program;
use argil_math::Aabb;
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::Vec3;
use std::time::Instant;

fn main() {
    let voxel_grid = VoxelGrid::covering(Aabb::centered(Vec3::ONE), 512).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let programs = [100, 1000, 10_000].map(|n| {
        let scene = random_scene(n, 1);
        (n, Program::lower(&scene).expect("a program"))
    });
    let mut times = [const { Vec::new() }; 3];
    let mut counts = [0; 3];
    for round in 0..7 {
        for (k, (_, program)) in programs.iter().enumerate() {
            let start = Instant::now();
            let (bricks, stages) = Bricks::bake(program, layout, None).expect("bricks");
            times[k].push((start.elapsed().as_secs_f64() * 1e3, stages));
            assert!(round == 0 || counts[k] == bricks.len());
            counts[k] = bricks.len();
        }
    }
    let mut least = 0.0;
    for (k, (n, _)) in programs.iter().enumerate() {
        times[k].sort_by(|a, b| a.0.total_cmp(&b.0));
        let (ms, stages) = times[k][times[k].len() / 2];
        if k == 0 {
            least = ms;
        }
        println!(
            "{n} brushes: {ms:.1} ms ({:.1}, {:.1}, {:.1}), {} bricks, {:.2} times the first",
            stages.prune,
            stages.fill,
            stages.release,
            counts[k],
            ms / least
        );
    }
}
