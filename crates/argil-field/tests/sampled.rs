//! Tests sampled shapes: blocks of points in the finest level, which SIMD interpolates, against points one by one.

use argil_field::{Evaluator, Program, SampleLattice, bake_history};
use argil_math::Control;
use argil_scene::{Brush, Scene, Shape};

/// Points that are evaluated at once.
const BLOCK: usize = 16;

/// The edge of a voxel.
const VOXEL: f32 = 0.031;

/// The place of a sample.
const ORIGIN: [f32; 3] = [0.0137, -0.2, 0.31];

/// Returns a number from -1 to 1 that looks random.
fn random(n: u32) -> f32 {
    let hash = n.wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    (hash >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn sampled_scene() -> Scene {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([0.9, 0.4, 0.7])).expect("a box");
    for n in 0..12 {
        let place = [0, 1, 2].map(|axis| 0.8 * random(3 * n + axis));
        let ball = Brush::new(Shape::sphere(0.2)).smooth(0.05);
        scene.push(ball.at(place).subtract()).expect("a ball");
    }
    let samples = SampleLattice {
        origin: ORIGIN.into(),
        voxel_size: VOXEL,
    };
    let bake = bake_history(&scene, 13, samples, &Control::default()).expect("a bake");
    scene.fold_history(&bake).expect("a fold");
    scene
}

/// Returns the bits of the distance and of the gradient at each point of a block.
fn of_block(evaluator: &mut Evaluator<'_>, [x, y, z]: &[[f32; BLOCK]; 3]) -> [[u32; 4]; BLOCK] {
    let (mut d, mut same, mut slopes) = ([0.0; BLOCK], [0.0; BLOCK], [[0.0; BLOCK]; 3]);
    evaluator.distances(x, y, z, &mut d);
    let [dx, dy, dz] = &mut slopes;
    evaluator.gradients(x, y, z, &mut same, [dx, dy, dz]);
    assert_eq!(d.map(f32::to_bits), same.map(f32::to_bits));
    std::array::from_fn(|n| [d[n], slopes[0][n], slopes[1][n], slopes[2][n]].map(f32::to_bits))
}

#[test]
fn blocks_have_the_distances_of_their_points() {
    let program = Program::lower(&sampled_scene()).expect("a program");
    let mut evaluator = Evaluator::new(&program);
    let mut near = 0;
    for block in 0..400 {
        // Small and large blocks, of which the latter reach beyond the finest level, and such between samples.
        let size = [0.05, 0.3, 1.0, 6.0][block as usize % 4];
        let step = if block % 3 == 0 { VOXEL } else { 1e-6 };
        let points: [[f32; BLOCK]; 3] = std::array::from_fn(|axis| {
            let seed = 100 * block + axis as u32;
            let center = 0.8 * random(7919 * seed);
            let place = |n: usize| center + size * random(seed * 31 + 3 * n as u32);
            let origin = ORIGIN[axis];
            // In some blocks, half of the points are between samples.
            let step = |n: usize| match block % 5 {
                0 if n.is_multiple_of(2) => 1e-6,
                _ => step,
            };
            std::array::from_fn(|n| origin + ((place(n) - origin) / step(n)).round() * step(n))
        });
        let together = of_block(&mut evaluator, &points);
        for n in 0..BLOCK {
            for far in [50.0, f32::NAN] {
                // A block with a point elsewhere goes point by point.
                let alone = of_block(
                    &mut evaluator,
                    &points.map(|along| {
                        let mut others = [far; BLOCK];
                        others[0] = along[n];
                        others
                    }),
                );
                assert_eq!(alone[0], together[n], "{block}, {n}");
            }
            near += usize::from(f32::from_bits(together[n][0]).abs() < 0.05);
        }
    }
    assert!(near > 500, "{near} points near the surface");
}

/// On the side of a level, and a few rounding errors around it, distances are those of the finest level there.
#[test]
fn distances_are_continuous_across_levels() {
    let scene = sampled_scene();
    let first = scene.node(Scene::ROOT).children()[0];
    let (.., grid) = scene.node(first).desc().kind.file().expect("samples");
    let grid = grid.0.as_ref().expect("samples");
    let program = Program::lower(&scene).expect("a program");
    let words = grid.words();
    let mut compared = 0;
    for head in words.chunks(8).take(words[7] as usize) {
        let corner = [head[0], head[1], head[2]];
        let size = [head[4], head[5], head[6]].map(|cells| cells / head[3]);
        for side in 0..6u32 {
            let axis = side as usize % 3;
            for n in 0..200 {
                let mut p: [f32; 3] = std::array::from_fn(|axis| {
                    let share = 0.5 + 0.5 * random(97 * n + 3 * side + axis as u32);
                    corner[axis] + share * size[axis]
                });
                p[axis] = corner[axis] + if side < 3 { 0.0 } else { size[axis] };
                let away = program.distance(p.into());
                for ulps in -20..=20i32 {
                    let mut beside = p;
                    let bits = p[axis].to_bits().wrapping_add_signed(ulps);
                    beside[axis] = f32::from_bits(bits);
                    let error = (program.distance(beside.into()) - away).abs();
                    assert!(error < 1e-4, "{beside:?}: off by {error}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 50_000);
}
