//! csg20 at 256³ without pruning: a dense bake against the field's batch evaluation of the same points, in turns.
//! Both must find 1,259,486 points inside. Then octrees of the same volume.

use argil_field::Program;
use argil_math::Aabb;
use argil_scene::Scene;
use argil_volume::{Dense, Encoding, Octree, OctreeLayout, OctreeSettings, VoxelGrid};
use glam::Vec3;
use std::time::Instant;

const EXPECTED_INSIDE: usize = 1_259_486;
const ROUNDS: usize = 15;

fn median(samples: &mut [f64]) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn ms(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json");
    let scene = Scene::open(path).expect("the scene ships with the project");
    let program = Program::lower(&scene).expect("the scene can be lowered");
    let voxel_grid = VoxelGrid::covering(Aabb::centered(Vec3::ONE), 256).expect("a voxel grid");
    let grid = voxel_grid.grid(0);
    let mut field = vec![0.0f32; 256 * 256 * 256];
    let encoding = Encoding::default();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let [mut of_field, mut of_dense, mut of_mips, mut of_pruned] = [const { Vec::new() }; 4];
        for _ in 0..ROUNDS {
            of_field.push(ms(|| pool.install(|| program.distances(&grid, &mut field))));
            let bake =
                |mips| pool.install(|| Dense::bake_unpruned(&program, voxel_grid, encoding, mips));
            let mut dense = None;
            of_dense.push(ms(|| dense = Some(bake(false))));
            of_mips.push(ms(|| drop(bake(true))));
            let bake = || pool.install(|| Dense::bake(&program, voxel_grid, encoding, false));
            let mut pruned = None;
            of_pruned.push(ms(|| pruned = Some(bake())));
            assert!(pruned == dense, "pruning changes no texel");
            let inside = field.iter().filter(|&&d| d < 0.0).count();
            assert_eq!(inside, EXPECTED_INSIDE);
            // Stored distances round to 0 next to the surface: as many as the field puts below half a step.
            let step = encoding.band_width(&voxel_grid, 0) / 127.0;
            let below = field.iter().filter(|&&d| d < -0.5 * step).count();
            let texels = dense.expect("it was baked");
            let texels = texels.levels()[0].bytes();
            let stored = texels.iter().filter(|&&t| (t as i8) < 0).count();
            assert_eq!(stored, below);
        }
        let (field, dense, mips) = (
            median(&mut of_field),
            median(&mut of_dense),
            median(&mut of_mips),
        );
        println!(
            "{threads} threads: field {field:.1} ms, dense {dense:.1} ms ({:.2} times), with mips {mips:.1} ms; pruned {:.1} ms",
            dense / field,
            median(&mut of_pruned)
        );
    }
    for brick in [8, 16, 32] {
        let settings = OctreeSettings {
            brick_size_voxels: brick,
            ..OctreeSettings::default()
        };
        let layout = OctreeLayout::new(voxel_grid, &settings).expect("a layout");
        let mut times: Vec<f64> = (0..ROUNDS)
            .map(|_| ms(|| drop(Octree::bake(&program, layout, settings.brick_test))))
            .collect();
        let (octree, stages) = Octree::bake(&program, layout, settings.brick_test);
        println!(
            "octree, bricks of {brick}: {:.1} ms, {} bricks (select {:.2}, fill {:.2}, tree {:.3})",
            median(&mut times),
            octree.tree().codes().len(),
            stages.select,
            stages.fill,
            stages.tree
        );
    }
}
