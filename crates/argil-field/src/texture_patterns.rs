//! Patterns of textures. `texture_patterns.wgsl` is the twin.

use crate::noise::value_noise;
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::{PI, TAU};

pub(crate) const KIND_CHECKER: f32 = 0.0;
pub(crate) const KIND_STRIPES: f32 = 1.0;
pub(crate) const KIND_NOISE: f32 = 2.0;
pub(crate) const KIND_WOOD: f32 = 3.0;
pub(crate) const KIND_MARBLE: f32 = 4.0;
pub(crate) const KIND_BRICK: f32 = 5.0;
pub(crate) const KIND_IMAGE: f32 = 6.0;

/// Words of an entry of the table.
pub(crate) const ENTRY: usize = 8;

/// Returns a solid pattern, whose length is 1.
pub(crate) fn solid(kind: f32, parameter: f32, p: Vec3) -> f32 {
    if kind == KIND_CHECKER {
        // A hair off, so that flat surfaces through the origin are not torn.
        let cell = (2.0 * p + 1e-4)
            .floor()
            .clamp(Vec3::splat(-1e9), Vec3::splat(1e9));
        let sum = cell.x as i32 ^ cell.y as i32 ^ cell.z as i32;
        (sum & 1) as f32
    } else if kind == KIND_STRIPES {
        (0.5 + 2.0 * (TAU * p.z.fract()).sin()).clamp(0.0, 1.0)
    } else if kind == KIND_NOISE {
        0.5 + 0.5 * layers(p, parameter as u32)
    } else if kind == KIND_WOOD {
        let bent = (p.x * p.x + p.z * p.z).sqrt() + 0.12 * layers(p * Vec3::new(1.5, 0.3, 1.5), 2);
        let ring = bent - bent.floor();
        let ring = ring * ring * (1.0 - smoothstep(0.85, 1.0, ring));
        let grain = 0.5 + 0.5 * value_noise([24.0 * p.x, 1.5 * p.y, 24.0 * p.z], 7);
        (0.8 * ring + 0.25 * grain).clamp(0.0, 1.0)
    } else {
        let bent = p.x + 1.2 * layers(p, 5);
        (PI * (bent - 2.0 * (0.5 * bent).floor()))
            .sin()
            .abs()
            .sqrt()
    }
}

/// Adds noise of several sizes, from −1 to 1.
fn layers(p: Vec3, octaves: u32) -> f32 {
    let (mut sum, mut all, mut amplitude, mut frequency) = (0.0, 0.0, 1.0, 1.0);
    for octave in 0..octaves {
        sum += amplitude * value_noise((p * frequency).to_array(), octave);
        all += amplitude;
        amplitude *= 0.5;
        frequency *= 2.0;
    }
    sum / all
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns 0 in joints and 1 in bricks, twice as wide as they are high.
pub(crate) fn brick(uv: Vec2) -> f32 {
    let row = (2.0 * uv.y).floor();
    let odd = row - 2.0 * (0.5 * row).floor();
    let u = uv.x + 0.5 * odd;
    let inner = vec2(u - u.floor(), 0.5 * (2.0 * uv.y - row));
    let side = inner.min(vec2(1.0, 0.5) - inner);
    smoothstep(0.02, 0.035, side.min_element())
}

/// Returns an image's color, which repeats, mixed between texels.
pub(crate) fn image(words: &[f32], texture: &[f32], uv: Vec2) -> Vec3 {
    let (first, width, height) = (texture[7] as usize * ENTRY, texture[11], texture[12]);
    // The middle of the image is at the origin.
    let (x, y) = (
        (uv.x + 0.5 - (uv.x + 0.5).floor()) * width - 0.5,
        wrapped(uv.y * width + 0.5 * height, height) - 0.5,
    );
    let (column, row) = (x.floor(), y.floor());
    let texel = |dx: f32, dy: f32| {
        let row = wrapped(row + dy, height) as usize;
        let at = row * width as usize + wrapped(column + dx, width) as usize;
        let word = words.get(first + at).copied().unwrap_or(0.0) as u32;
        let root = |shift: u32| (word >> shift & 255) as f32 / 255.0;
        let roots = Vec3::new(root(0), root(8), root(16));
        roots * roots
    };
    let (u, v) = (x - column, y - row);
    let above = texel(0.0, 0.0).lerp(texel(1.0, 0.0), u);
    let below = texel(0.0, 1.0).lerp(texel(1.0, 1.0), u);
    above.lerp(below, v)
}

/// Returns a coordinate in the first of equal intervals, below its end.
fn wrapped(x: f32, length: f32) -> f32 {
    let remainder = x - length * (x / length).floor();
    remainder.clamp(0.0, length - 1e-3 * length.min(1.0))
}
