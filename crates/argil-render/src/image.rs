use crate::ray_stats::RayStatistics;
use crate::srgb::{Place, SRGB};
use crate::tile::Tile;
use argil_abi::{FrameUniform, Hit, MODE_SHADED};

/// A rendered frame.
#[derive(Clone, Debug)]
pub struct RenderOutput {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels as 8-bit sRGB, three bytes each, row by row from the top.
    pub rgb: Vec<u8>,
    /// What the first sample of each pixel hit, with its steps. Empty unless requested.
    pub hits: Vec<Hit>,
    /// Statistics of the first sample of each pixel, if requested.
    pub statistics: Option<RayStatistics>,
    /// Pixels of which at least half of the samples hit a solid.
    pub hit_pixels: usize,
}

impl RenderOutput {
    /// Creates a frame without pixels.
    pub fn empty() -> Self {
        Self {
            size: [0, 0],
            rgb: Vec::new(),
            hits: Vec::new(),
            statistics: None,
            hit_pixels: 0,
        }
    }
}

/// Converts accumulated colors to bytes.
pub(crate) fn show(frame: &FrameUniform, tile: Tile, colors: &[[f32; 4]], rgb: &mut [u8]) {
    if frame.mode == MODE_SHADED {
        let place = Place {
            first_x: tile.first_x,
            first_row: tile.first_row,
            width: tile.width,
        };
        SRGB.show(place, colors, rgb);
        return;
    }
    for (rgb, color) in rgb.chunks_exact_mut(3).zip(colors) {
        if *color == [0.0; 4] {
            rgb.fill(0);
            continue;
        }
        for (byte, &c) in rgb.iter_mut().zip(color) {
            *byte = (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        }
    }
}

/// Counts the pixels of which at least half of the samples hit a solid.
pub(crate) fn covered(colors: &[[f32; 4]]) -> usize {
    colors.iter().filter(|c| c[3] >= 0.499).count()
}
