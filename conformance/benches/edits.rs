//! Durations of edits in place, compared within one run:
//!
//! * the same small edit among 1,000, 10,000 and 100,000 brushes of the same density;
//! * a small edit of the trees at 1024³ against the bake;
//! * the median and the 99th of a hundred over a session of a thousand edits, and the memory after all are undone.

use argil_conformance::{CaseRng, EditRig, shipped};
use argil_scene::{Brush, Edit, Modifier, NodeId, Scene, Shape};
use argil_volume::BrickSettings;
use std::time::Instant;

/// Returns brushes about as large as the gaps between them, in a box of proportional volume. They are in shells
/// around the center, so that a larger scene contains a smaller one, and the same edit works in both.
fn crowd(brushes: usize) -> (Scene, f32) {
    let mut numbers = CaseRng::new(1);
    let mut scene = Scene::new();
    let half = 0.5 * (brushes as f32).cbrt();
    scene.view.bounds = Some([[-half; 3], [half; 3]]);
    for i in 0..brushes {
        let size = numbers.between(0.2, 0.4);
        let shape = match i % 3 {
            0 => Shape::rounded_box([size, 0.7 * size, 0.5 * size], 0.1 * size),
            1 => Shape::torus(size, 0.4 * size),
            _ => Shape::sphere(size),
        };
        let mut brush = Brush::new(shape)
            .rotated([0.3, 1.0, 0.2], numbers.between(0.0, 360.0))
            .at(on_shell(&mut numbers, 0.5 * (i as f32 + 0.5).cbrt()))
            .smooth(0.05);
        if i % 5 == 4 {
            brush = brush.subtract();
        }
        scene.push(brush).expect("a valid brush");
    }
    (scene, 2.0 * half)
}

/// Returns a point on a face of a cube, given half of its side.
fn on_shell(numbers: &mut CaseRng, half: f32) -> [f32; 3] {
    let mut point = numbers.point(half).to_array();
    let face = (numbers.between(0.0, 6.0) as usize).min(5);
    point[face / 2] = if face.is_multiple_of(2) { half } else { -half };
    point
}

/// Moves a brush back and forth. Returns the milliseconds of each edit, and the part of the scene.
fn nudge(scene: &mut Scene, clay: &mut EditRig, node: NodeId, by: f32, times: usize) -> Vec<f64> {
    let mut all = Vec::new();
    for index in 0..times {
        let step = if index % 2 == 0 { by } else { -by };
        let by = Modifier::Translate {
            by: [step, 0.0, 0.5 * step],
        };
        let start = Instant::now();
        scene
            .apply(Edit::Transform { node, by })
            .expect("a valid edit");
        clay.follow(scene);
        all.push(start.elapsed().as_secs_f64() * 1e3);
    }
    all.sort_by(f64::total_cmp);
    all
}

fn median(sorted: &[f64]) -> f64 {
    sorted[sorted.len() / 2]
}

fn crowds() {
    let mut least = 0.0;
    for brushes in [1000, 10_000, 100_000] {
        let (mut scene, side) = crowd(brushes);
        let resolution = (16.0 * side) as u32;
        let mut clay = EditRig::of(&mut scene, resolution, &BrickSettings::default());
        // The brushes in the middle.
        let mut near: Vec<(f32, NodeId)> = scene
            .iter()
            .filter_map(|node| {
                let entry = scene.node(node).desc();
                entry.modifiers.iter().find_map(|m| match m {
                    Modifier::Translate { by } => {
                        Some((glam::Vec3::from(*by).length_squared(), node))
                    }
                    _ => None,
                })
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut all = Vec::new();
        let filled = clay.done.filled;
        for &(_, node) in near.iter().take(24) {
            all.extend(nudge(&mut scene, &mut clay, node, 0.1, 20));
        }
        all.sort_by(f64::total_cmp);
        assert_eq!(clay.rebakes, 0);
        if least == 0.0 {
            least = median(&all);
        }
        println!(
            "{brushes} brushes at {resolution}³, {} bricks: an edit {:.3} ms, {:.1} bricks sampled, {:.2} times the first",
            clay.bricks().len(),
            median(&all),
            (clay.done.filled - filled) as f64 / all.len() as f64,
            median(&all) / least
        );
    }
}

fn trees() {
    let case = shipped().into_iter().find(|case| case.name == "trees");
    let mut scene = case.expect("a scene that ships").scene;
    let start = Instant::now();
    let mut clay = EditRig::of(&mut scene, 1024, &BrickSettings::default());
    println!(
        "trees at 1024³: first bake {:.1} ms",
        start.elapsed().as_secs_f64() * 1e3
    );
    let start = Instant::now();
    let program = argil_field::Program::lower(&scene).expect("a program");
    let bake = || argil_volume::Bricks::bake(&program, clay.layout, None).expect("bricks");
    let count = bake().0.len();
    let mut bakes = vec![start.elapsed().as_secs_f64() * 1e3];
    for _ in 0..4 {
        let start = Instant::now();
        assert_eq!(bake().0.len(), count);
        bakes.push(start.elapsed().as_secs_f64() * 1e3);
    }
    bakes.sort_by(f64::total_cmp);
    let leaf = Brush::new(Shape::sphere(0.02))
        .at([0.0, 0.3, 0.0])
        .smooth(0.005);
    let node = scene.push(leaf).expect("a valid brush").node;
    clay.follow(&mut scene);
    let before = clay.done.filled;
    let all = nudge(&mut scene, &mut clay, node, 0.004, 200);
    println!(
        "trees at 1024³, {count} bricks: bake {:.1} ms, an edit {:.3} ms, {} bricks sampled, 1/{:.0} of the bake",
        median(&bakes),
        median(&all),
        (clay.done.filled - before) / 200,
        median(&bakes) / median(&all)
    );
}

fn session() {
    let case = shipped().into_iter().find(|case| case.name == "csg20");
    let mut scene = case.expect("a scene that ships").scene;
    let mut clay = EditRig::of(&mut scene, 256, &BrickSettings::default());
    let mut numbers = CaseRng::new(8);
    let at_first = clay.memory_bytes();
    let mut all = Vec::new();
    for index in 0..1000 {
        let size = numbers.between(0.05, 0.08);
        let mut brush = Brush::new(Shape::sphere(size))
            .at(numbers.point(0.6).to_array())
            .smooth(0.02);
        if index % 2 == 1 {
            brush = brush.subtract();
        }
        let start = Instant::now();
        scene.push(brush).expect("a valid brush");
        clay.follow(&mut scene);
        all.push(start.elapsed().as_secs_f64() * 1e3);
    }
    all.sort_by(f64::total_cmp);
    let grown = clay.memory_bytes();
    while scene.undo_depth() > 0 && scene.brush_count() > 20 {
        scene.undo();
        clay.follow(&mut scene);
    }
    assert_eq!(clay.differing(&scene), 0);
    println!(
        "a thousand edits of csg20 at 256³: median {:.3} ms, 99th of a hundred {:.3} ({:.2} times), max {:.3}; {at_first} bytes, {grown} then, {} after their undos",
        median(&all),
        all[989],
        all[989] / median(&all),
        all[999],
        clay.memory_bytes()
    );
}

fn main() {
    session();
    trees();
    crowds();
}
