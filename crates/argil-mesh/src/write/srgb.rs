//! Colors as bytes.

/// Converts a linear color component to an sRGB byte.
pub(crate) fn srgb(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let c = if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * c + 0.5) as u8
}
