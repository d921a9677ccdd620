use crate::{SizesDiffer, check_sizes};
use image::RgbImage;

/// The peak signal-to-noise ratio in decibels, over all channels of 8-bit sRGB as stored; infinite for equal pictures.
///
/// # Errors
/// If the sizes differ.
pub fn psnr(a: &RgbImage, b: &RgbImage) -> Result<f64, SizesDiffer> {
    check_sizes(a, b)?;
    let squares = a.as_raw().iter().zip(b.as_raw());
    let sum: f64 = squares
        .map(|(&a, &b)| f64::from(a.abs_diff(b)).powi(2))
        .sum();
    let mean = sum / a.as_raw().len().max(1) as f64;
    Ok(10.0 * (255.0 * 255.0 / mean).log10())
}

/// Pixels that differ in any channel.
///
/// # Errors
/// If the sizes differ.
pub fn differing_pixels(a: &RgbImage, b: &RgbImage) -> Result<u64, SizesDiffer> {
    check_sizes(a, b)?;
    Ok(a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count() as u64)
}
