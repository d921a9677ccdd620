use argil_abi::Hit;

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

/// Linear colours from 0 to 1 with coverage as 8-bit sRGB and coverage.
pub fn encode_srgb(colors: &[[f32; 4]]) -> (Vec<u8>, Vec<f32>) {
    let encode = |c: f32| {
        let c = c.clamp(0.0, 1.0);
        let v = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (v * 255.0 + 0.5) as u8
    };
    let rgb = colors.iter().flat_map(|c| [encode(c[0]), encode(c[1]), encode(c[2])]).collect();
    (rgb, colors.iter().map(|c| c[3]).collect())
}
