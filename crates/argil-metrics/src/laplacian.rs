//! The 2023 study's measure: a 5×5 Laplacian of each image, and their difference.
//!
//! *Theory.* The kernel is 24 in the middle and −1 elsewhere: 0 where an image is even, and large on edges and
//! where normals waver. It is applied to each 8-bit sRGB channel. Pixels at the border repeat beyond it, and the
//! result is clamped to 0 … 255, as in image editors. The study used such an editor and names no kernel; this is
//! the usual one of that size.

use crate::Rgb8Image;
use crate::{SizeMismatch, check_sizes};
use rayon::prelude::*;

/// Pixels to each side.
const REACH: i64 = 2;

/// Computes the Laplacian of an image.
pub fn laplacian(picture: &Rgb8Image) -> Rgb8Image {
    let [width, height] = picture.size();
    let source = picture.pixels();
    let at = |x: i64, y: i64| {
        let x = x.clamp(0, i64::from(width) - 1) as u32;
        let y = y.clamp(0, i64::from(height) - 1) as u32;
        source[y as usize * width as usize + x as usize].map(i32::from)
    };
    let pixels: Vec<[u8; 3]> = (0..i64::from(width) * i64::from(height))
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % i64::from(width), i / i64::from(width));
            let mut sum = at(x, y).map(|c| 25 * c);
            for dy in -REACH..=REACH {
                for dx in -REACH..=REACH {
                    let neighbor = at(x + dx, y + dy);
                    sum = std::array::from_fn(|c| sum[c] - neighbor[c]);
                }
            }
            sum.map(|c| c.clamp(0, 255) as u8)
        })
        .collect();
    of_pixels(width, height, &pixels)
}

/// The difference of two Laplacians.
#[derive(Clone, Debug)]
pub struct LaplacianDifference {
    /// The absolute difference of each channel of each pixel.
    pub picture: Rgb8Image,
    /// Pixels where it is 0 in all channels.
    pub equal_pixels: u64,
    /// Its mean over all pixels and channels, from 0 to 255.
    pub mean_abs: f64,
    /// The number of pixels with each red value, including 0, which the study omits.
    pub histogram: [u64; 256],
}

/// Computes the difference of the Laplacians of two images.
///
/// # Errors
/// If the sizes differ.
pub fn difference(a: &Rgb8Image, b: &Rgb8Image) -> Result<LaplacianDifference, SizeMismatch> {
    check_sizes(a, b)?;
    Ok(between(&laplacian(a), &laplacian(b)))
}

fn between(a: &Rgb8Image, b: &Rgb8Image) -> LaplacianDifference {
    let pixels: Vec<[u8; 3]> = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .map(|(a, b)| std::array::from_fn(|c| a[c].abs_diff(b[c])))
        .collect();
    let mut histogram = [0; 256];
    let (mut equal_pixels, mut sum) = (0, 0u64);
    for pixel in &pixels {
        histogram[usize::from(pixel[0])] += 1;
        equal_pixels += u64::from(*pixel == [0; 3]);
        sum += pixel.iter().map(|&c| u64::from(c)).sum::<u64>();
    }
    let [width, height] = a.size();
    LaplacianDifference {
        picture: of_pixels(width, height, &pixels),
        equal_pixels,
        mean_abs: sum as f64 / (3 * pixels.len()).max(1) as f64,
        histogram,
    }
}

fn of_pixels(width: u32, height: u32, pixels: &[[u8; 3]]) -> Rgb8Image {
    Rgb8Image::of([width, height], |x, y| {
        pixels[y as usize * width as usize + x as usize]
    })
}
