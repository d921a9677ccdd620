//! Images of all directions.
//!
//! *Theory.* Directions are chosen by how bright they are: first a row, then a pixel of it, each by its share of the light
//! (Pharr, Jakob and Humphreys, "Physically Based Rendering", 2023, section 12.5).

use argil_abi::PathUniform;
use argil_scene::SceneImage;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// An image around the scene.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentMap {
    image: Arc<SceneImage>,
    strength: f32,
    turn: f32,
    /// Sums of what pixels send, up to each row, and up to each pixel within its row.
    rows: Vec<f64>,
    columns: Vec<f32>,
    mean: f32,
}

impl EnvironmentMap {
    pub(super) fn new(image: Arc<SceneImage>, turn_degrees: f32, strength: f32) -> Self {
        let [width, height] = image.size.map(|side| side as usize);
        let bright = |pixel: &[f32; 3]| f64::from(pixel[0] + pixel[1] + pixel[2]) / 3.0;
        let mean = image.pixels.iter().map(bright).sum::<f64>() / image.pixels.len() as f64;
        // No direction is left out.
        let least = 0.01 * mean;
        // Across pixels and rows, what interpolation makes of a pixel and its neighbors on average.
        let spread =
            |before: f64, middle: f64, after: f64| 0.75 * middle + 0.125 * (before + after);
        let in_row = |x: usize, y: usize| {
            let at = |x: usize| bright(&image.pixels[y * width + x % width]);
            spread(at(x + width - 1), at(x), at(x + 1))
        };
        let interpolated = |x: usize, y: usize| {
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            spread(in_row(x, above), in_row(x, y), in_row(x, below))
        };
        let (mut rows, mut columns) = (Vec::with_capacity(height), Vec::new());
        let mut all = 0.0;
        for y in 0..height {
            let mut sum = 0.0;
            for x in 0..width {
                sum += interpolated(x, y).max(least);
                columns.push(sum as f32);
            }
            let elevation = PI * ((y as f32 + 0.5) / height as f32 - 0.5);
            all += sum * f64::from(elevation.cos());
            rows.push(all);
        }
        Self {
            image,
            strength,
            turn: turn_degrees.to_radians(),
            rows,
            columns,
            mean: strength * mean as f32,
        }
    }

    /// Describes the image in a uniform, appends the sums of its rows, and returns its pixels: colors, and sums within rows.
    pub(super) fn write(
        &self,
        uniform: &mut PathUniform,
        rows: &mut Vec<[f32; 4]>,
    ) -> Vec<[f32; 4]> {
        [uniform.environment_width, uniform.environment_height] = self.image.size;
        (uniform.environment_strength, uniform.environment_turn) = (self.strength, self.turn);
        let all = *self.rows.last().unwrap_or(&1.0);
        let sums: Vec<f32> = self.rows.iter().map(|&sum| (sum / all) as f32).collect();
        rows.extend(sums.chunks(4).map(|sums_of_row| {
            let mut row = [1.0; 4];
            row[..sums_of_row.len()].copy_from_slice(sums_of_row);
            row
        }));
        let pixels = self.image.pixels.iter().zip(&self.columns);
        pixels
            .map(|(&[r, g, b], &sum)| [r, g, b, (f64::from(sum) / all) as f32])
            .collect()
    }

    /// Returns an estimate of the light that a surface receives.
    pub(super) fn importance(&self) -> f32 {
        3.0 * PI * self.mean
    }

    /// Returns the position of a direction, from 0 to 1 across and downward.
    fn place(&self, direction: Vec3) -> [f32; 2] {
        let azimuth = direction.x.atan2(direction.z) - self.turn;
        let across = azimuth / TAU + 0.5;
        let elevation = direction.y.clamp(-1.0, 1.0).asin();
        [across - across.floor(), 0.5 - elevation * FRAC_1_PI]
    }

    /// Returns the light from a direction, mixed between pixels.
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        let [width, height] = self.image.size;
        let [across, down] = self.place(direction);
        let (x, y) = (across * width as f32 - 0.5, down * height as f32 - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let pixel = |dx: i64, dy: i64| {
            let x = (column as i64 + dx).rem_euclid(i64::from(width)) as usize;
            let y = (row as i64 + dy).clamp(0, i64::from(height) - 1) as usize;
            Vec3::from(self.image.pixels[y * width as usize + x])
        };
        let (u, v) = (x - column, y - row);
        let above = pixel(0, 0).lerp(pixel(1, 0), u);
        let below = pixel(0, 1).lerp(pixel(1, 1), u);
        self.strength * above.lerp(below, v)
    }

    fn row(&self, y: usize) -> &[f32] {
        let width = self.image.size[0] as usize;
        &self.columns[y * width..(y + 1) * width]
    }

    /// Returns the density of a pixel per solid angle.
    fn density_at(&self, x: usize, y: usize) -> f32 {
        let [width, height] = self.image.size.map(|side| side as f32);
        let all = *self.rows.last().unwrap_or(&1.0);
        let row = self.row(y);
        let importance = row[x] - if x > 0 { row[x - 1] } else { 0.0 };
        // A pixel's share of the light, which is already weighted by the cosine of its elevation, over its angle.
        (f64::from(importance) / all) as f32 * (width * height) / (TAU * PI)
    }

    pub(super) fn density(&self, direction: Vec3) -> f32 {
        let [width, height] = self.image.size;
        let [across, down] = self.place(direction);
        let x = ((across * width as f32) as usize).min(width as usize - 1);
        let y = ((down * height as f32) as usize).min(height as usize - 1);
        self.density_at(x, y)
    }

    /// Returns a direction and its density.
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> (Vec3, f32) {
        let [width, height] = self.image.size;
        let all = *self.rows.last().unwrap_or(&1.0);
        let sought = f64::from(v) * all;
        let y = self.rows.partition_point(|&sum| sum <= sought);
        let y = y.min(height as usize - 1);
        let before = if y > 0 { self.rows[y - 1] } else { 0.0 };
        let inner_y = ((sought - before) / (self.rows[y] - before)) as f32;
        let row = self.row(y);
        let sought = u * row[row.len() - 1];
        let x = row.partition_point(|&sum| sum <= sought);
        let x = x.min(width as usize - 1);
        let before = if x > 0 { row[x - 1] } else { 0.0 };
        let inner_x = (sought - before) / (row[x] - before).max(1e-30);
        let across = (x as f32 + inner_x.clamp(0.0, 0.9999)) / width as f32;
        let down = (y as f32 + inner_y.clamp(0.0, 0.9999)) / height as f32;
        let azimuth = (across - 0.5) * TAU + self.turn;
        let elevation = FRAC_PI_2 - down * PI;
        let (sine, cosine) = elevation.sin_cos();
        let direction = Vec3::new(cosine * azimuth.sin(), sine, cosine * azimuth.cos());
        (direction, self.density_at(x, y))
    }
}
