//! Linear light as bytes, by the sRGB transfer function (IEC 61966-2-1). `resolve_samples.wgsl` is the twin.
//!
//! *Theory.* Between two bytes, the darker or the brighter is taken, by a threshold that differs from pixel to pixel (ordered
//! dithering). So slow gradients have no bands. Light that a byte gives exactly is kept. The thresholds are the gradient noise of
//! Jimenez, "Next generation post processing in Call of Duty: Advanced Warfare", 2014.

use multiversion::multiversion;
use std::sync::LazyLock;

/// Steps of the square root, for which the table gives the smallest byte.
const STEPS: usize = 2048;

/// Colors that are converted together.
const LANES: usize = 64;

/// Converts linear light to 8-bit sRGB, as the function itself does, without its power.
#[derive(Debug)]
pub(crate) struct SrgbTable {
    /// The byte at the beginning of each step, or one less.
    first: [u32; STEPS + 1],
    /// The light of each byte, and the reciprocal of how much more the next one has.
    light: [f32; 257],
    gain: [f32; 257],
}

/// Where bytes are in an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub first_x: u32,
    pub first_row: u32,
    pub width: u32,
}

pub(crate) static SRGB: LazyLock<SrgbTable> = LazyLock::new(SrgbTable::new);

impl SrgbTable {
    fn new() -> Self {
        let mut light = [f32::INFINITY; 257];
        for (byte, light) in light[..256].iter_mut().enumerate() {
            *light = linear(byte as f32 / 255.0);
        }
        let mut gain = [0.0; 257];
        for (byte, gain) in gain[..255].iter_mut().enumerate() {
            *gain = 1.0 / (light[byte + 1] - light[byte]);
        }
        let mut first = [0u32; STEPS + 1];
        for (step, first) in first.iter_mut().enumerate() {
            let root = step as f32 / STEPS as f32;
            // A little less, because rounding may put light into the next step.
            let least = root * root * 0.999_99;
            *first = light[1..256]
                .iter()
                .filter(|level| **level <= least)
                .count() as u32;
        }
        Self { first, light, gain }
    }

    /// Returns the byte of linear light, or the next one if what remains is above a threshold. NaN is dark.
    #[inline(always)]
    fn byte(&self, c: f32, threshold: f32) -> u32 {
        let c = if c > 0.0 { c } else { 0.0 };
        let c = if c < 1.0 { c } else { 1.0 };
        let step = (c.sqrt() * STEPS as f32) as i32 as usize;
        let byte = self.first[step.min(STEPS)];
        let byte = byte + u32::from(c >= self.light[(byte as usize + 1).min(256)]);
        let at = (byte as usize).min(256);
        byte + u32::from((c - self.light[at]) * self.gain[at] > threshold)
    }

    /// Converts the colors of a part of an image, of which the fourth value is left out.
    pub(crate) fn show(&self, place: Place, colors: &[[f32; 4]], rgb: &mut [u8]) {
        let width = place.width.max(1) as usize;
        let rows = rgb.chunks_mut(3 * width).zip(colors.chunks(width));
        for (y, (rgb, colors)) in (place.first_row..).zip(rows) {
            show(self, [place.first_x, y], colors, rgb);
        }
    }
}

/// Converts a row.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn show(table: &SrgbTable, [first_x, y]: [u32; 2], colors: &[[f32; 4]], rgb: &mut [u8]) {
    let row = 0.005_837_15 * y as f32;
    let parts = rgb.chunks_mut(3 * LANES).zip(colors.chunks(LANES));
    for (x, (rgb, colors)) in (first_x..).step_by(LANES).zip(parts) {
        let mut thresholds = [0.0; LANES];
        for (index, threshold) in thresholds.iter_mut().enumerate() {
            let along = 0.067_110_56 * (x + index as u32) as f32 + row;
            let noise = 52.982_918 * (along - along.floor());
            *threshold = noise - noise.floor();
        }
        let mut bytes = [[0; LANES]; 3];
        for (channel, bytes) in bytes.iter_mut().enumerate() {
            let lanes = bytes.iter_mut().zip(thresholds);
            for ((byte, threshold), color) in lanes.zip(colors) {
                *byte = table.byte(color[channel], threshold);
            }
        }
        let [r, g, b] = &bytes;
        let pixels = rgb.as_chunks_mut::<3>().0.iter_mut();
        for (rgb, ((r, g), b)) in pixels.zip(r.iter().zip(g).zip(b)) {
            *rgb = [*r as u8, *g as u8, *b as u8];
        }
    }
}

fn linear(shown: f32) -> f32 {
    if shown <= 0.040_45 {
        shown / 12.92
    } else {
        ((shown + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(c: f32) -> f32 {
        let shown = if c <= 0.003_130_8 {
            c * 12.92
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        shown.clamp(0.0, 1.0) * 255.0
    }

    /// The mean over all thresholds is the function, and light that a byte gives exactly is that byte.
    #[test]
    fn the_table_agrees_with_the_function() {
        let thresholds: Vec<f32> = (0..64).map(|index| (index as f32 + 0.5) / 64.0).collect();
        for c in (0..1 << 12).map(|i| i as f32 / 4095.0) {
            let bytes = thresholds.iter().map(|&dither| SRGB.byte(c, dither) as f32);
            let mean = bytes.sum::<f32>() / 64.0;
            assert!((mean - exact(c)).abs() < 0.03, "{c}: {mean} {}", exact(c));
        }
        for byte in 0..=255 {
            let light = SRGB.light[byte as usize];
            for threshold in [0.0, 0.5, 0.99] {
                assert_eq!(SRGB.byte(light, threshold), byte);
            }
        }
        assert_eq!(
            [-1.0, f32::NAN, 2.0].map(|c| SRGB.byte(c, 0.0)),
            [0, 0, 255]
        );
    }

    /// A slow gradient has its own mean in each part of a row, and no part has one byte alone.
    #[test]
    fn slow_gradients_have_no_bands() {
        let place = Place {
            first_x: 0,
            first_row: 3,
            width: 1024,
        };
        let light = |x: usize| 0.2 + 0.004 * x as f32 / 1024.0;
        let colors: Vec<[f32; 4]> = (0..1024).map(|x| [light(x); 4]).collect();
        let mut rgb = vec![0; 3 * 1024];
        SRGB.show(place, &colors, &mut rgb);
        for part in 0..16 {
            let bytes = (64 * part..64 * part + 64).map(|x| f32::from(rgb[3 * x]));
            let mean = bytes.sum::<f32>() / 64.0;
            let expected = exact(light(64 * part + 32));
            assert!((mean - expected).abs() < 0.1, "{part}: {mean} {expected}");
        }
    }
}
