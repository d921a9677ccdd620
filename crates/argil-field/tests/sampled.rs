//! Tests sampled shapes: blocks of points in the finest level, which SIMD interpolates, against points one by one.

use argil_field::{Evaluator, Program, bake_history};
use argil_math::Control;
use argil_scene::{Brush, Scene, Shape};

/// Points that are evaluated at once.
const BLOCK: usize = 16;

/// Returns a number from -1 to 1 that looks random.
fn random(n: u32) -> f32 {
    let hash = n.wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    (hash >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn sampled_program() -> Program {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([0.9, 0.4, 0.7])).expect("a box");
    for n in 0..12 {
        let place = [0, 1, 2].map(|axis| 0.8 * random(3 * n + axis));
        let ball = Brush::new(Shape::sphere(0.2)).smooth(0.05);
        scene.push(ball.at(place).subtract()).expect("a ball");
    }
    let bake = bake_history(&scene, 13, 0.03, &Control::default()).expect("a bake");
    scene.fold_history(&bake).expect("a fold");
    Program::lower(&scene).expect("a program")
}

#[test]
fn blocks_have_the_distances_of_their_points() {
    let program = sampled_program();
    let mut evaluator = Evaluator::new(&program);
    let (mut far, mut near) = ([[0.0; BLOCK]; 3], 0);
    for block in 0..400 {
        // Small and large blocks, of which the latter reach beyond the finest level.
        let size = [0.05, 0.3, 1.0, 6.0][block as usize % 4];
        let points: [[f32; BLOCK]; 3] = std::array::from_fn(|axis| {
            let seed = 100 * block + axis as u32;
            let center = 0.8 * random(7919 * seed);
            std::array::from_fn(|n| center + size * random(seed * 31 + 3 * n as u32))
        });
        let (mut d, mut slopes) = ([0.0; BLOCK], [[0.0; BLOCK]; 3]);
        let [x, y, z] = &points;
        evaluator.distances(x, y, z, &mut d);
        let [dx, dy, dz] = &mut slopes;
        let mut same = [0.0; BLOCK];
        evaluator.gradients(x, y, z, &mut same, [dx, dy, dz]);
        assert_eq!(d, same);
        for n in 0..BLOCK {
            // A block with a point far away goes point by point.
            for axis in 0..3 {
                far[axis] = [50.0; BLOCK];
                far[axis][0] = points[axis][n];
            }
            let (mut alone, mut slope) = ([0.0; BLOCK], [[0.0; BLOCK]; 3]);
            let [x, y, z] = &far;
            let [dx, dy, dz] = &mut slope;
            evaluator.gradients(x, y, z, &mut alone, [dx, dy, dz]);
            assert_eq!(alone[0].to_bits(), d[n].to_bits(), "{block}, {n}");
            assert_eq!(slope.map(|c| c[0]), slopes.map(|c| c[n]), "{block}, {n}");
            near += usize::from(d[n].abs() < 0.05);
        }
    }
    assert!(near > 500, "{near} points near the surface");
}
