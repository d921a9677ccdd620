//! csg20 at 256³ points without pruning, in batches on one thread and on two. Every variant must find 1,244,122
//! points inside.

use argil_field::{Evaluator, Grid, LANES, Program};
use argil_scene::Scene;
use glam::Vec3;
use std::time::Instant;

const EXPECTED_INSIDE: usize = 1_244_122;

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json");
    let scene = Scene::open(path).expect("the scene ships with the project");
    let program = Program::lower(&scene).expect("the scene can be lowered");
    let grid = Grid::spanning(Vec3::NEG_ONE, Vec3::ONE, 256);
    let mut out = vec![0.0f32; 256 * 256 * 256];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut times: Vec<f64> = (0..9)
            .map(|_| {
                let start = Instant::now();
                pool.install(|| program.distances(&grid, &mut out));
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let inside = out.iter().filter(|&&d| d < 0.0).count();
        assert_eq!(inside, EXPECTED_INSIDE);
        println!(
            "batches, {threads} threads: median {:.1} ms, min {:.1} ms, {inside} inside",
            times[4], times[0]
        );
    }
    // Gradients of a sixteenth of the points, for the cost of a dual number against a plain one.
    let mut evaluator = Evaluator::new(&program);
    let (x, y, z) = ([0.1; LANES], [0.2; LANES], [0.3; LANES]);
    let (mut d, mut g) = ([0.0; LANES], [[0.0; LANES]; 3]);
    let start = Instant::now();
    for _ in 0..8192 {
        let [gx, gy, gz] = &mut g;
        evaluator.gradients(&x, &y, &z, &mut d, [gx, gy, gz]);
    }
    println!(
        "gradients, 1 thread, 2^20 points: {:.1} ms",
        start.elapsed().as_secs_f64() * 1e3
    );
}
