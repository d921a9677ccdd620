//! csg20 at 1024²: length and normal of every primary ray, nothing pruned, on one thread and on two.
//! Every way must hit the same number of pixels, 23.7 % of them.

use argil_abi::{HIT_NONE, Hit};
use argil_field::{Evaluator, Program};
use argil_march::{Camera, Settings, TileScratch, frames, tiles, trace_tile};
use argil_math::Aabb;
use argil_scene::Scene;
use glam::Vec3;
use rayon::prelude::*;
use std::time::Instant;

const EXPECTED_HITS: usize = 248_357;
const SIDE: u32 = 1024;

fn main() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json");
    let scene = Scene::open(path).expect("the scene ships with the project");
    let program = Program::lower(&scene).expect("the scene can be lowered");
    let focus = Aabb::centered(Vec3::ONE);
    let camera = Camera::orbit(focus, [35.0, 35.0, 2.42], 35.0);
    let settings = Settings {
        size: [SIDE, SIDE],
        ..Settings::default()
    };
    let frame = frames(&settings, &camera, &program, None, focus)[0];
    let all: Vec<_> = tiles(SIDE, SIDE).collect();
    let mut hits = vec![Hit::default(); (SIDE * SIDE) as usize];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut times: Vec<f64> = (0..15)
            .map(|_| {
                let start = Instant::now();
                let slices = hits.par_chunks_mut(all[0].area());
                pool.install(|| {
                    all.par_iter().zip(slices).for_each_init(
                        || (Evaluator::new(&program), TileScratch::default()),
                        |(evaluator, scratch), (&tile, hits)| {
                            trace_tile(&frame, tile, evaluator, scratch, hits)
                        },
                    );
                });
                start.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let hit = hits.iter().filter(|h| h.kind != HIT_NONE).count();
        assert_eq!(hit, EXPECTED_HITS);
        let steps: f64 = hits.iter().map(|h| f64::from(h.steps)).sum::<f64>() / hits.len() as f64;
        println!(
            "{threads} threads: median {:.1} ms, min {:.1} ms, {hit} hits, {steps:.2} steps a ray",
            times[7], times[0]
        );
    }
}
