//! Colors as bytes.

/// Converts a linear color component to an sRGB byte.
pub(crate) fn srgb(linear: f32) -> u8 {
    (255.0 * srgb_fraction(linear) + 0.5) as u8
}

/// Converts a linear color component to sRGB, from 0 to 1.
pub(crate) fn srgb_fraction(linear: f32) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    }
}
