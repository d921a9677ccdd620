//! Removes noise.
//!
//! *Theory.* Light without the surfaces' colors is smooth, except at edges of surfaces and shadows. Wavelets with holes average it
//! over wider and wider squares, where normals, distances and the light itself are similar (Dammertz et al., "Edge-avoiding
//! à-trous wavelet transform for fast global illumination filtering", 2010). How far light may differ follows from how noisy it is
//! (Schied et al., "Spatiotemporal variance-guided filtering", 2017).

use super::still::{Pixel, Still};
use glam::Vec3;
use rayon::prelude::*;

/// Times that the averaged square doubles.
const ROUNDS: u32 = 5;
/// Weights of neighbors: a cubic spline.
const SPLINE: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];
/// How far light may differ, in standard deviations.
const DEVIATIONS: f32 = 3.0;
/// The power of the cosine between normals.
const NORMAL_POWER: i32 = 64;

#[derive(Clone, Copy, Default)]
struct Light {
    color: Vec3,
    /// Of the luminance.
    variance: f32,
}

#[derive(Clone, Copy)]
struct Guide {
    normal: Vec3,
    distance: f32,
    albedo: Vec3,
}

fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn guide_of(pixel: &Pixel) -> Guide {
    let count = pixel.count.max(1) as f32;
    Guide {
        normal: pixel.normal / count,
        distance: pixel.distance / count,
        albedo: pixel.albedo / count,
    }
}

/// What light is divided by: a surface's color, or 1 for the sky.
fn divisor(guide: &Guide) -> Vec3 {
    if guide.albedo == Vec3::ZERO {
        Vec3::ONE
    } else {
        guide.albedo.max(Vec3::splat(0.02))
    }
}

/// Returns the light of each pixel of a still, with noise removed: see [`Still::radiance`].
pub fn denoised(still: &Still) -> Vec<[f32; 3]> {
    let [width, height] = still.size.map(|side| side as usize);
    let guides: Vec<Guide> = still.pixels.iter().map(guide_of).collect();
    let mut lights: Vec<Light> = still
        .pixels
        .iter()
        .zip(&guides)
        .map(|(pixel, guide)| {
            let by = divisor(guide);
            Light {
                color: pixel.mean() / by,
                variance: luminance(pixel.variance() / (by * by)),
            }
        })
        .collect();
    let mut next = lights.clone();
    for round in 0..ROUNDS {
        let stride = 1isize << round;
        next.par_chunks_mut(width.max(1))
            .enumerate()
            .for_each(|(y, row)| {
                for (x, out) in row.iter_mut().enumerate() {
                    *out = averaged(&lights, &guides, [width, height], [x, y], stride);
                }
            });
        std::mem::swap(&mut lights, &mut next);
    }
    let colors = lights.iter().zip(&guides);
    let colors: Vec<Vec3> = colors
        .map(|(light, guide)| light.color * divisor(guide))
        .collect();
    (0..colors.len())
        .into_par_iter()
        .map(|index| without_dot(still, &colors, index).to_array())
        .collect()
}

/// A pixel is noisy if its standard deviation is more than this part of its light.
const NOISY: f32 = 0.05;

/// Returns a pixel's color, or that of a neighbor if the pixel is noisy, and brighter or darker than seven of its eight
/// neighbors. At the rims of surfaces, no neighbor is like such a pixel, so that averages leave it alone.
fn without_dot(still: &Still, colors: &[Vec3], pixel: usize) -> Vec3 {
    let color = colors[pixel];
    let noise = luminance(still.pixels[pixel].variance()).max(0.0).sqrt();
    let brightness = luminance(color);
    if noise <= NOISY * brightness {
        return color;
    }
    let [width, height] = still.size.map(|side| side as usize);
    let (x, y) = (pixel % width, pixel / width);
    let mut around = [(0.0, Vec3::ZERO); 8];
    let mut count = 0;
    for (dx, dy) in AROUND {
        if let (Some(x), Some(y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy))
            && x < width
            && y < height
        {
            let near = colors[y * width + x];
            around[count] = (luminance(near), near);
            count += 1;
        }
    }
    if count < around.len() {
        return color;
    }
    around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    if brightness < around[1].0 {
        around[1].1
    } else if brightness > around[6].0 {
        around[6].1
    } else {
        color
    }
}

/// The way to each neighbor.
const AROUND: [(isize, isize); 8] = [
    (-1, -1),
    (0, -1),
    (1, -1),
    (-1, 0),
    (1, 0),
    (-1, 1),
    (0, 1),
    (1, 1),
];

/// Averages the light around a pixel.
fn averaged(
    lights: &[Light],
    guides: &[Guide],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    stride: isize,
) -> Light {
    let at = |dx: isize, dy: isize| {
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        (x < width && y < height).then_some(y * width + x)
    };
    let pixel = y * width + x;
    // One pixel's variance is itself noisy.
    let (mut sum, mut weights) = (0.0, 0.0);
    for dy in -1..=1isize {
        for dx in -1..=1isize {
            if let Some(near) = at(dx, dy) {
                let weight = [1.0, 0.5][dx.unsigned_abs()] * [1.0, 0.5][dy.unsigned_abs()];
                sum += weight * lights[near].variance;
                weights += weight;
            }
        }
    }
    let allowed = DEVIATIONS * (sum / weights).max(0.0).sqrt() + 1e-4;
    let (guide, brightness) = (&guides[pixel], luminance(lights[pixel].color));
    // How much the distance changes from pixel to pixel.
    let slope = [(1, 0), (-1, 0), (0, 1), (0, -1)]
        .iter()
        .filter_map(|&(dx, dy)| at(dx, dy))
        .map(|near| (guides[near].distance - guide.distance).abs())
        .fold(f32::INFINITY, f32::min);
    let slope = if slope.is_finite() { slope } else { 0.0 };
    let mut out = Light::default();
    let mut total = 0.0;
    for dy in -2..=2isize {
        for dx in -2..=2isize {
            let Some(near) = at(stride * dx, stride * dy) else {
                continue;
            };
            let other = &guides[near];
            let normal = if guide.normal == Vec3::ZERO && other.normal == Vec3::ZERO {
                1.0
            } else {
                guide
                    .normal
                    .dot(other.normal)
                    .clamp(0.0, 1.0)
                    .powi(NORMAL_POWER)
            };
            let steps = stride as f32 * (dx as f32).hypot(dy as f32);
            let apart = (other.distance - guide.distance).abs()
                / (slope * steps + 1e-3 * guide.distance + 1e-9);
            let unlike = (luminance(lights[near].color) - brightness).abs() / allowed;
            let weight = if near == pixel {
                1.0
            } else {
                normal * (-apart - unlike).exp()
            };
            let weight = weight * SPLINE[dx.unsigned_abs()] * SPLINE[dy.unsigned_abs()];
            out.color += weight * lights[near].color;
            out.variance += weight * weight * lights[near].variance;
            total += weight;
        }
    }
    Light {
        color: out.color / total,
        variance: out.variance / (total * total),
    }
}
