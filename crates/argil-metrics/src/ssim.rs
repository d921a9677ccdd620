//! Structural similarity.

use crate::Rgb8Image;
use crate::separable_filter::FilterPlane;
use crate::{SizeMismatch, check_sizes};

/// Pixels from the center of the window to its border.
const REACH: usize = 5;
/// The window's standard deviation in pixels.
const SIGMA: f32 = 1.5;

/// Returns the mean structural similarity index (Wang, Bovik, Sheikh, Simoncelli 2004), 1 for equal images. It is
/// the mean over the channels of 8-bit sRGB, with a Gaussian window of 11×11 pixels and a standard deviation of
/// 1.5, K₁ = 0.01, and K₂ = 0.03. Windows that extend beyond the border are omitted. For an image smaller than a
/// window, all windows count, and its border pixels repeat.
///
/// ```
/// use argil_metrics::{Rgb8Image, ssim};
/// let gray = Rgb8Image::new([16, 16], vec![128; 16 * 16 * 3]).expect("three bytes per pixel");
/// assert_eq!(ssim(&gray, &gray)?, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the sizes differ.
pub fn ssim(a: &Rgb8Image, b: &Rgb8Image) -> Result<f64, SizeMismatch> {
    check_sizes(a, b)?;
    let channels = (0..3).map(|channel| of_channel(a, b, channel));
    Ok(channels.sum::<f64>() / 3.0)
}

fn of_channel(a: &Rgb8Image, b: &Rgb8Image, channel: usize) -> f64 {
    let [width, height] = a.size().map(|n| n as usize);
    let mut weights: Vec<f32> = (0..=2 * REACH)
        .map(|i| (-0.5 * ((i as f32 - REACH as f32) / SIGMA).powi(2)).exp())
        .collect();
    let sum: f32 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    // Around the middle of the range, so that variances do not vanish in rounding.
    let value = |picture: &Rgb8Image, i: usize| f32::from(picture.rgb()[3 * i + channel]) - 128.0;
    let mean = |of: &(dyn Fn(f32, f32) -> f32 + Sync + Send)| {
        FilterPlane::from_fn(width, height, |i| of(value(a, i), value(b, i)))
            .filtered(&weights, &weights)
            .values
    };
    let (mean_a, mean_b) = (mean(&|a, _| a), mean(&|_, b| b));
    let (square_a, square_b) = (mean(&|a, _| a * a), mean(&|_, b| b * b));
    let product = mean(&|a, b| a * b);
    let (c1, c2) = ((0.01f64 * 255.0).powi(2), (0.03f64 * 255.0).powi(2));
    let mut sum = 0.0;
    let mut count = 0;
    let within = |length: usize| {
        if length > 2 * REACH {
            REACH..length - REACH
        } else {
            0..length
        }
    };
    for y in within(height) {
        for x in within(width) {
            let i = y * width + x;
            let [ma, mb, aa, bb, ab] =
                [mean_a[i], mean_b[i], square_a[i], square_b[i], product[i]].map(f64::from);
            let (var_a, var_b, covariance) = (aa - ma * ma, bb - mb * mb, ab - ma * mb);
            let (ma, mb) = (ma + 128.0, mb + 128.0);
            let above = (2.0 * ma * mb + c1) * (2.0 * covariance + c2);
            sum += above / ((ma * ma + mb * mb + c1) * (var_a + var_b + c2));
            count += 1;
        }
    }
    // An image without pixels.
    if count == 0 {
        1.0
    } else {
        sum / f64::from(count)
    }
}
