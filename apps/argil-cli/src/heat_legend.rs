//! The legend of an image of steps: its colors, and the steps where each begins.

use argil::RenderedImage;

/// Digits from 0 to 9, three pixels wide and five high: a row in three bits each, from the top.
const DIGITS: [u16; 10] = [
    0b111_101_101_101_111,
    0b010_110_010_010_111,
    0b111_001_111_100_111,
    0b111_001_111_001_111,
    0b101_101_111_001_001,
    0b111_100_111_001_111,
    0b111_100_111_101_111,
    0b111_001_010_010_010,
    0b111_101_111_101_111,
    0b111_101_111_001_111,
];
const WHITE: [u8; 3] = [255; 3];
/// Colors of no steps, a third, two thirds and all.
const COLORS: [[u8; 3]; 4] = [[0, 0, 255], [0, 255, 0], [255, 255, 0], [255, 0, 0]];

/// Draws the legend into the lower left corner, if the image shows steps and is large enough.
pub(crate) fn draw(image: &mut RenderedImage) {
    let Some(most) = image.heat_steps else { return };
    let scale = (image.size[1] / 240).max(1);
    let (unit, bar) = (4 * scale, 96 * scale);
    let high = 13 * scale;
    if image.size[0] < bar + 6 * unit || image.size[1] < 2 * high {
        return;
    }
    let top = image.size[1] - high - unit;
    for x in 0..bar {
        let color = color_at(x as f32 / bar as f32);
        fill(image, [unit + x, top], [1, 6 * scale], color);
    }
    for third in 0..=3 {
        let x = unit + bar * third / 3;
        fill(image, [x, top], [scale, 7 * scale], WHITE);
        let number = (most * third / 3).to_string();
        for (index, digit) in (0..).zip(number.bytes()) {
            let left = x + index * unit;
            draw_digit(image, [left, top + 8 * scale], scale, digit - b'0');
        }
    }
}

fn draw_digit(image: &mut RenderedImage, [left, top]: [u32; 2], scale: u32, digit: u8) {
    let rows = DIGITS[usize::from(digit)];
    for bit in 0..15 {
        if rows >> (14 - bit) & 1 == 1 {
            let at = [left + scale * (bit % 3), top + scale * (bit / 3)];
            fill(image, at, [scale; 2], WHITE);
        }
    }
}

fn color_at(share: f32) -> [u8; 3] {
    let third = (3.0 * share).clamp(0.0, 2.999);
    let (from, to) = (COLORS[third as usize], COLORS[third as usize + 1]);
    let between = |k: usize| {
        let (a, b) = (f32::from(from[k]), f32::from(to[k]));
        (a + (b - a) * third.fract()) as u8
    };
    [0, 1, 2].map(between)
}

fn fill(image: &mut RenderedImage, [x, y]: [u32; 2], [width, height]: [u32; 2], color: [u8; 3]) {
    let row = image.size[0] as usize;
    for y in y as usize..(y + height) as usize {
        let first = 3 * (y * row + x as usize);
        let pixels = image.rgb.get_mut(first..first + 3 * width as usize);
        for pixel in pixels.into_iter().flat_map(|row| row.chunks_exact_mut(3)) {
            pixel.copy_from_slice(&color);
        }
    }
}
