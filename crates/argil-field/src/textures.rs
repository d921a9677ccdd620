//! Patterns and images on surfaces. `textures.wgsl` is the twin.
//!
//! *Theory.* Solid patterns are functions of the point: checkers, stripes, noise, and wood and marble made of noise (Perlin
//! 1985). Flat ones are projected along the axes that the surface faces, and mixed by how much it does: along two with
//! the weights of Quilez ("Biplanar mapping", 2020), or along three with the fourth powers of the normal (Golus,
//! "Normal mapping for a triplanar shader", 2017).
//!
//! *Practice.* The words of a texture are: kind, size, space, a parameter; low, the first entry of its texels; high, the
//! image's width; its height, and three unused ones.

use crate::texture_patterns::*;
use argil_scene::{Mapping, Pattern, TextureSpace, Textures, ValueTexture};
use glam::{Vec2, Vec3, vec2};

/// Base color, roughness, metalness and height.
pub(crate) const CHANNELS: usize = 4;

/// Normals are differences over this part of a pattern's length.
pub(crate) const NORMAL_STEP: f32 = argil_abi::TEXTURE_NORMAL_STEP;

/// Returns the words of one of a material's textures, and its pattern.
pub(crate) fn texture_words(textures: &Textures, channel: usize) -> Option<([f32; 16], &Pattern)> {
    let of_values = |texture: &ValueTexture| {
        (
            texture.size,
            texture.space,
            [texture.low; 3],
            [texture.high; 3],
        )
    };
    let (pattern, (size, space, low, high)) = match channel {
        0 => {
            let texture = textures.base_color.as_ref()?;
            (
                &texture.pattern,
                (texture.size, texture.space, texture.low, texture.high),
            )
        }
        1 => textures
            .roughness
            .as_ref()
            .map(|texture| (&texture.pattern, of_values(texture)))?,
        2 => textures
            .metallic
            .as_ref()
            .map(|texture| (&texture.pattern, of_values(texture)))?,
        _ => textures
            .bump
            .as_ref()
            .map(|texture| (&texture.pattern, of_values(texture)))?,
    };
    let (kind, parameter) = match pattern {
        Pattern::Checker => (KIND_CHECKER, 0.0),
        Pattern::Stripes => (KIND_STRIPES, 0.0),
        Pattern::Noise { octaves } => (KIND_NOISE, *octaves as f32),
        Pattern::Wood => (KIND_WOOD, 0.0),
        Pattern::Marble => (KIND_MARBLE, 0.0),
        Pattern::Brick => (KIND_BRICK, 0.0),
        Pattern::Image { mapping, .. } => (
            KIND_IMAGE,
            if *mapping == Mapping::Triplanar {
                1.0
            } else {
                0.0
            },
        ),
    };
    let space = if space == TextureSpace::World {
        1.0
    } else {
        0.0
    };
    let [lr, lg, lb] = low;
    let [hr, hg, hb] = high;
    let words = [
        kind, size, space, parameter, lr, lg, lb, 0.0, hr, hg, hb, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
    Some((words, pattern))
}

/// Packs a linear color into a whole number below 2²⁴: the square roots of its components in 8 bits each.
pub(crate) fn packed_texel(color: &[f32; 3]) -> f32 {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u32);
    (r | g << 8 | b << 16) as f32
}

/// A point on a brush that has textures.
pub(crate) struct TexturedPoint {
    /// In the brush's space, and in the scene's.
    pub points: [Vec3; 2],
    /// Normals in both, of any length.
    pub normals: [Vec3; 2],
}

/// Whether a record needs normals, and the smallest size of such a texture.
pub(crate) fn needs_normal(words: &[f32], record: usize) -> Option<f32> {
    let flat = (0..CHANNELS).filter_map(|channel| {
        let at = words[ENTRY * record + channel] as usize * ENTRY;
        (at != 0 && words[at] >= KIND_BRICK).then(|| words[at + 1])
    });
    flat.reduce(f32::min)
}

/// Replaces what a record's textures give: of base color, roughness, emission, metalness and four others, the last of
/// which is a height. `words` are those of the table.
pub(crate) fn apply(words: &[f32], record: usize, at: &TexturedPoint, out: &mut [f32; 12]) {
    for channel in 0..CHANNELS {
        let begin = words[ENTRY * record + channel] as usize * ENTRY;
        if begin == 0 {
            continue;
        }
        let texture = &words[begin..begin + 16];
        let share = value(words, texture, at);
        let low = Vec3::new(texture[4], texture[5], texture[6]);
        let high = Vec3::new(texture[8], texture[9], texture[10]);
        let color = low + (high - low) * share;
        let gray = low.x + (high.x - low.x) * luminance(share);
        match channel {
            0 => out[..3].copy_from_slice(&color.to_array()),
            1 => out[3] = gray,
            2 => out[7] = gray,
            _ => out[11] = gray,
        }
    }
}

fn luminance(color: Vec3) -> f32 {
    0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z
}

/// Returns a texture's pattern at a point.
fn value(words: &[f32], record: &[f32], at: &TexturedPoint) -> Vec3 {
    let space = usize::from(record[2] != 0.0);
    let p = at.points[space] / record[1];
    let kind = record[0];
    if kind < KIND_BRICK {
        return Vec3::splat(solid(kind, record[3], p));
    }
    let flat = |uv: Vec2| {
        if kind == KIND_BRICK {
            Vec3::splat(brick(uv))
        } else {
            image(words, record, uv)
        }
    };
    let normal = at.normals[space];
    let facing = normal.abs();
    // Images stand upright, and are not mirrored, whichever way a surface faces.
    let side = Vec3::from(normal.to_array().map(|c| if c < 0.0 { -1.0 } else { 1.0 }));
    let sides = [
        vec2(-side.x * p.z, -p.y),
        vec2(p.x, side.y * p.z),
        vec2(side.z * p.x, -p.y),
    ];
    let weights = if record[3] != 0.0 {
        let squares = facing * facing;
        squares * squares
    } else {
        two_weights(facing)
    };
    let sum = weights.element_sum();
    if sum <= 0.0 {
        return flat(sides[1]);
    }
    let mut total = Vec3::ZERO;
    for (side, weight) in sides.into_iter().zip(weights.to_array()) {
        if weight > 0.0 {
            total += flat(side) * (weight / sum);
        }
    }
    total
}

/// Returns weights of the two axes that a normal is nearest to.
fn two_weights(facing: Vec3) -> Vec3 {
    let length = facing.length();
    if length <= 0.0 {
        return Vec3::ZERO;
    }
    let facing = facing / length;
    let least = facing.min_element();
    // 1/√3: where all axes are as near.
    let mut weights = ((facing - 0.577_35) / (1.0 - 0.577_35)).clamp(Vec3::splat(1e-4), Vec3::ONE);
    if facing.z == least {
        weights.z = 0.0;
    } else if facing.y == least {
        weights.y = 0.0;
    } else {
        weights.x = 0.0;
    }
    weights
}
