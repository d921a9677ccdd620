use argil_abi::{Frame, Hit, SHOW_SHADED};
use rayon::prelude::*;

/// A finished frame.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// RGB in sRGB, 8 bits a channel, row by row from the top.
    pub rgb: Vec<u8>,
    /// What the first sample of each pixel hit, with its steps.
    pub hits: Vec<Hit>,
    /// The share of each pixel's samples that hit a solid.
    pub coverage: Vec<f32>,
}

impl Picture {
    /// From a frame's accumulated colours with coverage, and the hits of its first sample.
    pub fn new(frame: &Frame, colors: &[[f32; 4]], hits: Vec<Hit>) -> Self {
        let is_light = frame.show == SHOW_SHADED;
        let mut rgb = vec![0; 3 * colors.len()];
        rgb.par_chunks_mut(3)
            .with_min_len(4096)
            .zip(colors)
            .for_each(|(rgb, color)| {
                for (byte, &c) in rgb.iter_mut().zip(color) {
                    let shown = if is_light { srgb_from_linear(c) } else { c };
                    *byte = (shown.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                }
            });
        let coverage = colors.iter().map(|c| c[3]).collect();
        Self {
            size: [frame.width, frame.height],
            rgb,
            hits,
            coverage,
        }
    }

    /// Without pixels.
    pub fn empty() -> Self {
        Self {
            size: [0, 0],
            rgb: Vec::new(),
            hits: Vec::new(),
            coverage: Vec::new(),
        }
    }
}

/// The sRGB transfer function (IEC 61966-2-1).
fn srgb_from_linear(c: f32) -> f32 {
    if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}
