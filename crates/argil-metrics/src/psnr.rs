use crate::Rgb8Image;
use crate::{SizeMismatch, check_sizes};

/// Returns the peak signal-to-noise ratio in decibels, over all channels of 8-bit sRGB. Infinite for equal images.
///
/// # Errors
/// If the sizes differ.
pub fn psnr(a: &Rgb8Image, b: &Rgb8Image) -> Result<f64, SizeMismatch> {
    check_sizes(a, b)?;
    let squares = a.rgb().iter().zip(b.rgb());
    let sum: f64 = squares
        .map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2))
        .sum();
    let mean = sum / a.rgb().len().max(1) as f64;
    Ok(10.0 * (255.0 * 255.0 / mean).log10())
}

/// Counts the pixels that differ in any channel.
///
/// # Errors
/// If the sizes differ.
pub fn differing_pixels(a: &Rgb8Image, b: &Rgb8Image) -> Result<u64, SizeMismatch> {
    check_sizes(a, b)?;
    Ok(a.pixels()
        .iter()
        .zip(b.pixels())
        .filter(|(a, b)| a != b)
        .count() as u64)
}
