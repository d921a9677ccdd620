//! The colors of modes without light.

use argil_abi::{self as abi, FrameUniform, Hit};
use glam::{Vec3, vec3};

/// Returns the brightness of a depth.
pub(crate) fn depth(frame: &FrameUniform, t: f32) -> f32 {
    let range = (frame.depth_far - frame.depth_near).max(1e-6);
    (1.0 - (t - frame.depth_near) / range).clamp(0.0, 1.0)
}

/// Returns the color of a hit in levels, red where a finer brick is missing.
pub(crate) fn level_color(hit: &Hit) -> Vec3 {
    let [nx, ny, nz, _] = hit.normal_t.map(f32::abs);
    let light = 0.55 * nx + ny + 0.75 * nz;
    if (hit.id - 1) & abi::LEVEL_MISSING != 0 {
        return vec3(1.0, 0.1, 0.05) * light;
    }
    let level = ((hit.id - 1) & (abi::LEVEL_MISSING - 1)) as f32;
    let channel = |shift: f32| 0.3 + 0.6 * (2.0 * (0.381_966 * level + shift).fract() - 1.0).abs();
    vec3(channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0)) * light
}

/// Returns the color of an id, darker on sides that face x and z.
pub(crate) fn id_color(hit: &Hit) -> Vec3 {
    let mixed = hit.id.wrapping_mul(2_654_435_761);
    let channel = |shift: u32| 0.25 + 0.75 * (mixed >> shift & 0xff) as f32 / 255.0;
    let [nx, ny, nz, _] = hit.normal_t;
    let light = 0.55 * nx.abs() + ny.abs() + 0.75 * nz.abs();
    vec3(channel(8), channel(16), channel(24)) * light
}

/// Returns blue, green, yellow, red for no steps up to as many as the frame's far depth is in this mode.
pub(crate) fn heat(frame: &FrameUniform, steps: u32) -> Vec3 {
    let s = (steps as f32 / frame.depth_far).clamp(0.0, 1.0) * 3.0;
    let red = (s - 1.0).clamp(0.0, 1.0);
    let green = s.clamp(0.0, 1.0) - (s - 2.0).clamp(0.0, 1.0);
    let blue = (1.0 - s).clamp(0.0, 1.0);
    vec3(red, green, blue)
}
