//! csg20 at 1024², images of normals on one thread and on two: through the field without pruning, through the
//! field, and through bricks of 512³.
//!
//! Without pruning 248,357 pixels must hit, which are 23.7 %. The others may differ by a few in a thousand.
//!
//! `cargo bench -p argil-render --bench trace -- [SCENE.json AZIMUTH ELEVATION DISTANCE FIELD_OF_VIEW SIDE]`

use argil_field::Program;
use argil_math::Aabb;
use argil_render::{
    Camera, PrunedField, RenderMode, RenderSettings, RenderSource, UnprunedField, frame_uniforms,
    render,
};
use argil_scene::Scene;
use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
use glam::Vec3;
use std::time::Instant;

const EXPECTED_HITS: usize = 248_357;
const ROUNDS: usize = 15;

fn median(mut work: impl FnMut()) -> (f64, f64) {
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[ROUNDS / 2], times[0])
}

fn main() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json");
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let number = |i: usize, other: f32| given.get(i).and_then(|n| n.parse().ok()).unwrap_or(other);
    let path = given.first().map_or(example, |path| path);
    let scene = Scene::open(path).expect("a scene");
    let program = Program::lower(&scene).expect("the scene can be lowered");
    let focus = Aabb::centered(Vec3::ONE);
    let orbit = [number(1, 35.0), number(2, 35.0), number(3, 2.42)];
    let camera = Camera::orbit(focus, orbit, number(4, 35.0));
    let side = number(5, 1024.0) as u32;
    let settings = RenderSettings {
        size: [side, side],
        mode: RenderMode::Normal,
        max_steps: 4096,
        statistics: true,
        ..RenderSettings::default()
    };
    let of_field = RenderSettings {
        max_steps: 256,
        ..settings
    };
    let frame = frame_uniforms(&of_field, &camera, &program, None, focus);
    let voxel_grid = VoxelGrid::covering(focus, 512).expect("a voxel grid");
    let layout = BrickLayout::new(voxel_grid, &BrickSettings::default()).expect("a layout");
    let (bricks, _) = Bricks::bake(&program, layout, None).expect("bricks");
    let through_bricks = frame_uniforms(&settings, &camera, &program, Some(&voxel_grid), focus);

    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let ways: [(&str, &dyn RenderSource, _); 3] = [
            ("whole field", &UnprunedField, &frame),
            ("field", &PrunedField, &frame),
            ("bricks", &bricks, &through_bricks),
        ];
        for (name, through, frames) in ways {
            if name == "whole field" && program.instructions().len() > 200 {
                continue;
            }
            let mut picture = None;
            let times = median(|| {
                picture = Some(pool.install(|| render(&program, through, frames)));
            });
            let picture = picture.expect("it was drawn");
            if given.is_empty() {
                let off = picture.hit_pixels.abs_diff(EXPECTED_HITS);
                assert!(off < EXPECTED_HITS / 100, "{name}: {}", picture.hit_pixels);
            }
            let statistics = picture.statistics.expect("it was asked for");
            println!(
                "{threads} threads, {name}: median {:.1} ms, min {:.1} ms, {} hits, {:.2} steps per ray",
                times.0, times.1, picture.hit_pixels, statistics.steps.mean
            );
        }
    }
}
