//! Deterministic random scenes of any size.

use crate::CaseRng;
use argil_scene::{Brush, Scene, Shape};
use glam::Vec3;

/// Creates a number of boxes, capsules, tori and balls in a box from −1 to 1: rotated, blended, every fifth
/// subtracted. Their total surface before they are combined does not depend on their number.
pub fn random_scene(brushes: usize, seed: u64) -> Scene {
    let mut numbers = CaseRng::new(seed);
    let mut scene = Scene::new();
    scene.name = format!("{brushes} random brushes");
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let unit = 2.0 / (brushes.max(1) as f32).sqrt();
    for i in 0..brushes {
        let size = [
            unit * numbers.between(0.6, 1.4),
            unit * numbers.between(0.4, 1.0),
            unit * numbers.between(0.3, 0.8),
        ];
        let shape = match i % 4 {
            0 => Shape::rounded_box(size, 0.3 * size[2]),
            1 => Shape::capsule([0.0; 3], [size[0], 0.0, 0.0], size[2]),
            2 => Shape::torus(size[0], 0.4 * size[2]),
            _ => Shape::sphere(size[1]),
        };
        let axis = numbers.point(1.0).normalize_or(Vec3::Y);
        let mut brush = Brush::new(shape)
            .rotated(axis.to_array(), numbers.between(0.0, 360.0))
            .at(numbers.point(0.9).to_array())
            .smooth(0.3 * unit);
        if i % 5 == 4 {
            brush = brush.subtract();
        }
        // Sizes and positions are finite, so no edit fails.
        let _ = scene.push(brush);
    }
    scene
}
