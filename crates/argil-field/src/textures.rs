//! Patterns and images on surfaces. `textures.wgsl` is the twin.
//!
//! *Theory.* Solid patterns are functions of the point: checkers, stripes, noise, and wood and marble made of noise (Perlin
//! 1985). Flat ones are projected along the axes that the surface faces, and mixed by how much it does: along two with
//! the weights of Quilez ("Biplanar mapping", 2020), or along three with the fourth powers of the normal (Golus,
//! "Normal mapping for a triplanar shader", 2017).
//!
//! *Practice.* The words of a texture are: kind, size, space, a parameter; low, the first entry of its texels; high, the
//! image's width; its height, and three unused ones.

use crate::noise::value_noise;
use argil_scene::{Mapping, Pattern, TextureSpace, Textures, ValueTexture};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::{PI, TAU};

/// Base color, roughness, metalness and height.
pub(crate) const CHANNELS: usize = 4;

const KIND_CHECKER: f32 = 0.0;
const KIND_STRIPES: f32 = 1.0;
const KIND_NOISE: f32 = 2.0;
const KIND_WOOD: f32 = 3.0;
const KIND_MARBLE: f32 = 4.0;
const KIND_BRICK: f32 = 5.0;
pub(crate) const KIND_IMAGE: f32 = 6.0;

/// Normals are differences over this part of a pattern's length.
pub(crate) const NORMAL_STEP: f32 = argil_abi::TEXTURE_NORMAL_STEP;

/// Words of an entry of the table.
const ENTRY: usize = 8;

/// Returns the words of a material's nth texture, and its pattern.
pub(crate) fn texture_words(textures: &Textures, channel: usize) -> Option<([f32; 16], &Pattern)> {
    let of_values = |own: &ValueTexture| (own.size, own.space, [own.low; 3], [own.high; 3]);
    let (pattern, (size, space, low, high)) = match channel {
        0 => {
            let own = textures.base_color.as_ref()?;
            (&own.pattern, (own.size, own.space, own.low, own.high))
        }
        1 => textures
            .roughness
            .as_ref()
            .map(|own| (&own.pattern, of_values(own)))?,
        2 => textures
            .metallic
            .as_ref()
            .map(|own| (&own.pattern, of_values(own)))?,
        _ => textures
            .bump
            .as_ref()
            .map(|own| (&own.pattern, of_values(own)))?,
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
        let own = &words[begin..begin + 16];
        let share = value(words, own, at);
        let low = Vec3::new(own[4], own[5], own[6]);
        let high = Vec3::new(own[8], own[9], own[10]);
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
fn value(words: &[f32], own: &[f32], at: &TexturedPoint) -> Vec3 {
    let space = usize::from(own[2] != 0.0);
    let p = at.points[space] / own[1];
    let kind = own[0];
    if kind < KIND_BRICK {
        return Vec3::splat(solid(kind, own[3], p));
    }
    let flat = |uv: Vec2| {
        if kind == KIND_BRICK {
            Vec3::splat(brick(uv))
        } else {
            image(words, own, uv)
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
    let weights = if own[3] != 0.0 {
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

/// Returns a solid pattern, whose length is 1.
fn solid(kind: f32, parameter: f32, p: Vec3) -> f32 {
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
fn brick(uv: Vec2) -> f32 {
    let row = (2.0 * uv.y).floor();
    let odd = row - 2.0 * (0.5 * row).floor();
    let u = uv.x + 0.5 * odd;
    let inner = vec2(u - u.floor(), 0.5 * (2.0 * uv.y - row));
    let side = inner.min(vec2(1.0, 0.5) - inner);
    smoothstep(0.02, 0.035, side.min_element())
}

/// Returns an image's color, which repeats, mixed between texels.
fn image(words: &[f32], own: &[f32], uv: Vec2) -> Vec3 {
    let (first, width, height) = (own[7] as usize * ENTRY, own[11], own[12]);
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
    let own = x - length * (x / length).floor();
    own.clamp(0.0, length - 1e-3 * length.min(1.0))
}
