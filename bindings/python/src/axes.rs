//! The axes of Python, where z points up, and those of scenes, where y does.

use argil::glam::Vec3;
use argil::math::Aabb;

/// Returns a vector of Python in a scene.
pub fn scene_from_python([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, -y]
}

/// Returns a vector of a scene in Python.
pub fn python_from_scene([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, -z, y]
}

/// Returns a box of Python in a scene.
pub fn box_from_python([low, high]: [[f32; 3]; 2]) -> Aabb {
    let corners = [low, high].map(|corner| Vec3::from(scene_from_python(corner)));
    Aabb::around(corners)
}

/// Returns a box of a scene in Python.
pub fn box_to_python(bounds: Aabb) -> [[f32; 3]; 2] {
    let (low, high) = (bounds.min, bounds.max);
    [[low.x, -high.z, low.y], [high.x, -low.z, high.y]]
}
