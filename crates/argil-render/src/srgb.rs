//! Linear light as bytes, by the sRGB transfer function (IEC 61966-2-1).

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
    /// The smallest light of each byte. None is that bright beyond the last.
    least: [f32; 257],
}

pub(crate) static SRGB: LazyLock<SrgbTable> = LazyLock::new(SrgbTable::new);

impl SrgbTable {
    fn new() -> Self {
        let mut least = [f32::INFINITY; 257];
        for (byte, least) in (0..=255).zip(&mut least) {
            // Positive numbers are ordered as their bits are.
            let (mut low, mut high) = (0u32, 1f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if exact(f32::from_bits(middle)) < byte {
                    low = middle + 1;
                } else {
                    high = middle;
                }
            }
            *least = f32::from_bits(low);
        }
        let mut first = [0u32; STEPS + 1];
        for (step, first) in first.iter_mut().enumerate() {
            let root = step as f32 / STEPS as f32;
            // A little less, because rounding may put light into the next step.
            *first = u32::from(exact(root * root * 0.999_99));
        }
        Self { first, least }
    }

    /// Returns the byte of linear light. NaN is dark.
    #[inline(always)]
    fn byte(&self, c: f32) -> u32 {
        let c = if c > 0.0 { c } else { 0.0 };
        let c = if c < 1.0 { c } else { 1.0 };
        let step = (c.sqrt() * STEPS as f32) as i32 as usize;
        let byte = self.first[step.min(STEPS)];
        byte + u32::from(c >= self.least[(byte as usize + 1).min(256)])
    }

    /// Converts colors, of which the fourth value is left out.
    pub(crate) fn show(&self, colors: &[[f32; 4]], rgb: &mut [u8]) {
        show(self, colors, rgb);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn show(table: &SrgbTable, colors: &[[f32; 4]], rgb: &mut [u8]) {
    for (rgb, colors) in rgb.chunks_mut(3 * LANES).zip(colors.chunks(LANES)) {
        let mut bytes = [0; 4 * LANES];
        for (byte, &c) in bytes.iter_mut().zip(colors.as_flattened()) {
            *byte = table.byte(c);
        }
        let pixels = rgb.as_chunks_mut::<3>().0.iter_mut();
        for (rgb, [r, g, b, _]) in pixels.zip(bytes.as_chunks::<4>().0) {
            *rgb = [*r as u8, *g as u8, *b as u8];
        }
    }
}

fn exact(c: f32) -> u8 {
    let shown = if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    };
    (shown.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_agrees_with_the_function() {
        let few = (0..1 << 16).map(|i| i as f32 / 65_535.0);
        let ends = SRGB.least[..256]
            .iter()
            .flat_map(|&c| [c.next_down(), c, c.next_up()]);
        for c in few.chain(ends) {
            assert_eq!(SRGB.byte(c), u32::from(exact(c)), "{c}");
        }
        assert_eq!([-1.0, f32::NAN, 2.0].map(|c| SRGB.byte(c)), [0, 0, 255]);
    }
}
