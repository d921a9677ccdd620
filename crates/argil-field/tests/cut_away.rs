//! Tests solids of which a modifier leaves nothing: they are empty operands, and not missing ones.

use argil_field::{Program, naive};
use argil_scene::{Brush, Modifier, Scene, Shape};
use glam::Vec3;

/// Returns balls whose section is empty, or lies beyond the axis.
fn cut_away() -> [Brush; 2] {
    let ball = |at: [f32; 3], modifier| {
        Brush::new(Shape::sphere(0.5))
            .at(at)
            .with_modifier(modifier)
    };
    [
        ball([0.0, 0.0, 2.0], Modifier::Extrude { half_depth: 0.5 }),
        ball([-2.0, 0.0, 0.0], Modifier::Revolve { offset: 0.5 }),
    ]
}

fn distances(with: Brush) -> [f32; 3] {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.0; 3])).expect("a box");
    scene.push(with).expect("a ball");
    let program = Program::lower(&scene).expect("a program");
    [[0.1, 0.2, 0.3], [0.9, -0.8, 0.1], [1.5, 0.0, 0.0]].map(|p| {
        let p = Vec3::from(p);
        let d = program.distance(p);
        assert!((f64::from(d) - naive::distance(&scene, p)).abs() < 1e-5);
        d
    })
}

#[test]
fn what_is_cut_away_is_an_empty_operand() {
    let plain = distances(Brush::new(Shape::sphere(0.1)).at([0.5, 0.0, 0.0]));
    for ball in cut_away() {
        assert_eq!(distances(ball.clone()), plain);
        assert_eq!(distances(ball.clone().subtract()), plain);
        let both = distances(ball.clone().intersect());
        assert!(both.iter().all(|&d| d > 0.3), "{both:?}");
        let morphed = distances(ball.morph(0.5));
        assert!(morphed.iter().all(|d| d.is_finite()), "{morphed:?}");
        assert!(morphed[0] > plain[0], "{morphed:?}");
    }
}
