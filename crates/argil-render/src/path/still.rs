//! What paths found, pixel by pixel.

use super::integrator::PathSample;
use argil_abi::PathPixel;
use glam::Vec3;
use std::ops::Range;

/// What the paths of a pixel found: sums.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pixel {
    pub light: Vec3,
    /// Of the light's squares.
    pub squares: Vec3,
    pub albedo: Vec3,
    pub normal: Vec3,
    pub distance: f32,
    pub covered: f32,
    pub opacity: f32,
    pub count: u32,
}

impl Pixel {
    pub(super) fn add(&mut self, found: &PathSample) {
        self.light += found.light;
        self.squares += found.light * found.light;
        self.albedo += found.albedo;
        self.normal += found.normal;
        self.distance += found.distance;
        self.covered += f32::from(u8::from(found.is_covered));
        self.opacity += found.opacity;
        self.count += 1;
    }

    pub(super) fn mean(&self) -> Vec3 {
        self.light / self.count.max(1) as f32
    }

    /// Returns the variance of the mean.
    pub(super) fn variance(&self) -> Vec3 {
        let count = self.count.max(2) as f32;
        let mean = self.light / count;
        ((self.squares / count - mean * mean) / (count - 1.0)).max(Vec3::ZERO)
    }
}

/// A path-traced picture.
#[derive(Clone, Debug)]
pub struct Still {
    pub(super) size: [u32; 2],
    pub(super) pixels: Vec<Pixel>,
}

impl Still {
    /// Creates a still without paths, of a width and a height in pixels.
    pub fn new(size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            pixels: vec![Pixel::default(); count],
        }
    }

    /// Adds what paths of some pixels found, from a first one on.
    pub fn add(&mut self, first: usize, found: &[PathPixel]) {
        for (pixel, found) in self.pixels.iter_mut().skip(first).zip(found) {
            pixel.light += Vec3::from(found.light);
            pixel.squares += Vec3::from(found.squares);
            pixel.albedo += Vec3::from(found.albedo);
            pixel.normal += Vec3::from(found.normal);
            pixel.distance += found.distance;
            pixel.covered += found.covered;
            pixel.opacity += found.opacity;
            pixel.count += found.count;
        }
    }

    /// Returns the mean distance to the first surface of each pixel. Infinite where most paths met none.
    pub fn distances(&self) -> Vec<f32> {
        let distance = |pixel: &Pixel| {
            let is_covered = pixel.count > 0 && 2.0 * pixel.covered >= pixel.count as f32;
            if is_covered {
                pixel.distance / pixel.count as f32
            } else {
                f32::INFINITY
            }
        };
        self.pixels.iter().map(distance).collect()
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the number of paths of that pixel of a range which has the most. Pixels are counted row by row from the top.
    pub fn max_samples(&self, pixels: Range<usize>) -> u32 {
        let pixels = self.pixels.get(pixels).unwrap_or_default();
        pixels.iter().map(|pixel| pixel.count).max().unwrap_or(0)
    }

    /// Returns the number of paths of the pixel that has the fewest.
    pub fn samples(&self) -> u32 {
        let counts = self.pixels.iter().map(|pixel| pixel.count);
        counts.min().unwrap_or(0)
    }

    /// Gives each pixel without a path what its nearest neighbor has, of those in the same 4 × 4 pixels. Returns how many there were.
    ///
    /// A time limit may end the first pass. A still is for looking at then: more paths would repeat those of neighbors.
    pub fn fill_gaps(&mut self) -> usize {
        let [width, height] = self.size.map(|side| side as usize);
        let traced = self.pixels.clone();
        let mut count = 0;
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            if pixel.count > 0 {
                continue;
            }
            let (x, y) = (i % width, i / width);
            let rows = (y & !3)..((y | 3) + 1).min(height);
            let places =
                rows.flat_map(|v| ((x & !3)..((x | 3) + 1).min(width)).map(move |u| (u, v)));
            let known = places.filter(|&(u, v)| traced[v * width + u].count > 0);
            let nearest = known.min_by_key(|&(u, v)| u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2));
            if let Some((u, v)) = nearest {
                *pixel = traced[v * width + u];
                count += 1;
            }
        }
        count
    }

    /// Returns the light of each pixel: linear RGB with the primaries of sRGB, row by row from the top.
    pub fn radiance(&self) -> Vec<[f32; 3]> {
        let means = self.pixels.iter().map(|pixel| pixel.mean().to_array());
        means.collect()
    }

    /// Returns how much of each pixel hides what is behind everything, from 0 to 1. The light is that of what hides it.
    pub fn opacity(&self) -> Vec<f32> {
        let share = |pixel: &Pixel| pixel.opacity / pixel.count.max(1) as f32;
        self.pixels.iter().map(share).collect()
    }

    /// Returns the variance of each pixel's light.
    pub fn variance(&self) -> Vec<[f32; 3]> {
        let variances = self.pixels.iter().map(|pixel| pixel.variance().to_array());
        variances.collect()
    }

    /// Returns the number of pixels that show a solid in at least half of their paths.
    pub fn hit_pixels(&self) -> usize {
        let covered = |pixel: &&Pixel| pixel.count > 0 && 2.0 * pixel.covered >= pixel.count as f32;
        self.pixels.iter().filter(covered).count()
    }
}
