//! The difference that a viewer sees when two images alternate.
//!
//! *Theory.* LDR-FLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020). Images are blurred
//! as the eye blurs them at a viewing distance, and compared in a uniform color space. Differences of edges and
//! points, found in the luminance, amplify color differences. 0 is equal, and 1 is the maximum.
//!
//! *Practice.* Pixels at the border repeat beyond it. Windows are products of rows and columns.

use crate::Rgb8Image;
use crate::separable_filter::FilterPlane;
use crate::{SizeMismatch, check_sizes};
use rayon::prelude::*;
use std::f32::consts::{PI, SQRT_2};

/// Pixels per degree of a screen that is 3840 pixels and 0.7 m wide, seen from 0.7 m: the authors' default.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// The difference of each pixel, row by row.
#[derive(Clone, Debug)]
pub struct FlipMap {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Differences from 0 to 1.
    pub values: Vec<f32>,
}

impl FlipMap {
    /// Returns the mean over all pixels.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().map(|&v| f64::from(v)).sum();
        sum / self.values.len().max(1) as f64
    }
}

/// Computes the map of differences between two images, the first one being the reference, at a number of pixels per
/// degree.
///
/// ```
/// use argil_metrics::{Rgb8Image, flip::flip};
/// let black = Rgb8Image::new([8, 8], vec![0; 8 * 8 * 3]).expect("three bytes per pixel");
/// let white = Rgb8Image::new([8, 8], vec![255; 8 * 8 * 3]).expect("three bytes per pixel");
/// assert_eq!(flip(&black, &black, 67.0)?.mean(), 0.0);
/// assert!(flip(&black, &white, 67.0)?.mean() > 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the sizes differ.
pub fn flip(a: &Rgb8Image, b: &Rgb8Image, pixels_per_degree: f32) -> Result<FlipMap, SizeMismatch> {
    check_sizes(a, b)?;
    let [lab, other] = [a, b].map(opponent);
    let color = color_difference(&lab, &other, pixels_per_degree);
    let feature = feature_difference(&lab[0], &other[0], pixels_per_degree);
    let values = color
        .par_iter()
        .zip(&feature)
        .map(|(c, f)| c.powf(1.0 - f))
        .collect();
    Ok(FlipMap {
        size: a.size(),
        values,
    })
}

// The following is written as in the paper.

/// From linear sRGB to CIE XYZ.
const XYZ: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_33, 0.180_480_78],
    [0.212_639, 0.715_168_65, 0.072_192_32],
    [0.019_330_818, 0.119_194_78, 0.950_532_14],
];

fn linear(c: u8) -> f32 {
    let c = f32::from(c) / 255.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn times(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Returns white in XYZ.
fn white() -> [f32; 3] {
    times(&XYZ, [1.0; 3])
}

fn inverse(m: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let m = glam::DMat3::from_cols_array_2d(&m.map(|row| row.map(f64::from))).inverse();
    m.to_cols_array_2d().map(|row| row.map(|v| v as f32))
}

/// Converts to luminance, red against green, and blue against yellow (YCxCz).
fn opponent(picture: &Rgb8Image) -> [FilterPlane; 3] {
    let (width, height) = (picture.size()[0] as usize, picture.size()[1] as usize);
    let white = white();
    let pixels: Vec<[f32; 3]> = picture
        .pixels()
        .par_iter()
        .map(|rgb| {
            let xyz = times(&XYZ, [linear(rgb[0]), linear(rgb[1]), linear(rgb[2])]);
            let [x, y, z] = [0, 1, 2].map(|k| xyz[k] / white[k]);
            [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
        })
        .collect();
    [0, 1, 2].map(|k| FilterPlane::from_fn(width, height, |i| pixels[i][k]))
}

/// The contrast sensitivity of a channel: up to two Gaussians, each with a weight and a width.
const SENSITIVITY: [[[f32; 2]; 2]; 3] = [
    [[1.0, 0.0047], [0.0, 1e-5]],
    [[1.0, 0.0053], [0.0, 1e-5]],
    [[34.1, 0.04], [13.5, 0.025]],
];

/// Returns a channel as the eye sees it.
fn blurred(plane: &FilterPlane, channel: usize, pixels_per_degree: f32) -> FilterPlane {
    let widest = 0.04f32;
    let reach = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    let gaussians = SENSITIVITY[channel].map(|[a, b]| {
        let line: Vec<f32> = (-reach..=reach)
            .map(|i| (-PI * PI * (i as f32 / pixels_per_degree).powi(2) / b).exp())
            .collect();
        let sum: f32 = line.iter().sum();
        // The sum of the Gaussian's own window over both axes.
        let weight = a * (PI / b).sqrt() * sum * sum;
        let line: Vec<f32> = line.iter().map(|v| v / sum).collect();
        (weight, line)
    });
    let total: f32 = gaussians.iter().map(|(weight, _)| weight).sum();
    let mut out = FilterPlane::from_fn(plane.width, plane.height, |_| 0.0);
    for (weight, line) in gaussians {
        if weight > 0.0 {
            let filtered_plane = plane.filtered(&line, &line);
            for (out, value) in out.values.iter_mut().zip(filtered_plane.values) {
                *out += weight / total * value;
            }
        }
    }
    out
}

/// Converts to CIE L*a*b* with colors adjusted for luminance (Hunt).
fn hunt_lab(linear_rgb: [f32; 3]) -> [f32; 3] {
    let (xyz, white) = (times(&XYZ, linear_rgb), white());
    let delta = 6.0f32 / 29.0;
    let [x, y, z] = [0, 1, 2].map(|k| {
        let t = xyz[k] / white[k];
        if t > delta.powi(3) {
            t.cbrt()
        } else {
            t / (3.0 * delta * delta) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let by_lightness = 0.01 * lightness;
    [
        lightness,
        by_lightness * 500.0 * (x - y),
        by_lightness * 200.0 * (y - z),
    ]
}

/// Returns the distance in lightness plus the distance in color.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

fn color_difference(
    a: &[FilterPlane; 3],
    b: &[FilterPlane; 3],
    pixels_per_degree: f32,
) -> Vec<f32> {
    let (white, to_rgb) = (white(), inverse(&XYZ));
    let seen = |planes: &[FilterPlane; 3]| {
        let planes = [0, 1, 2].map(|k| blurred(&planes[k], k, pixels_per_degree));
        let count = planes[0].values.len();
        let lab = (0..count).into_par_iter().map(|i| {
            let [y, cx, cz] = [0, 1, 2].map(|k| planes[k].values[i]);
            let y = (y + 16.0) / 116.0;
            let xyz = [
                (y + cx / 500.0) * white[0],
                y * white[1],
                (y - cz / 200.0) * white[2],
            ];
            hunt_lab(times(&to_rgb, xyz).map(|c| c.clamp(0.0, 1.0)))
        });
        lab.collect::<Vec<_>>()
    };
    let (a, b) = (seen(a), seen(b));
    const POWER: f32 = 0.7;
    const FEW: f32 = 0.4;
    const MAX_CONTRAST: f32 = 0.95;
    let greatest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(POWER);
    let knee = FEW * greatest;
    a.par_iter()
        .zip(&b)
        .map(|(&a, &b)| {
            let d = hyab(a, b).powf(POWER);
            if d < knee {
                d * MAX_CONTRAST / knee
            } else {
                MAX_CONTRAST + (d - knee) / (greatest - knee) * (1.0 - MAX_CONTRAST)
            }
        })
        .collect()
}

/// Returns weights whose negative ones sum to −1 and whose positive ones sum to 1, over a window that is a product
/// with a Gaussian.
fn balanced(line: &[f32], gaussian: &[f32]) -> Vec<f32> {
    let across: f32 = gaussian.iter().sum();
    let sum = |sign: f32| line.iter().filter(|v| *v * sign > 0.0).sum::<f32>() * sign * across;
    let (positive, negative) = (sum(1.0), sum(-1.0));
    line.iter()
        .map(|&v| v / if v > 0.0 { positive } else { negative })
        .collect()
}

fn feature_difference(a: &FilterPlane, b: &FilterPlane, pixels_per_degree: f32) -> Vec<f32> {
    // Half the width of a detected edge, in degrees.
    let sigma = 0.5 * 0.082 * pixels_per_degree;
    let reach = (3.0 * sigma).ceil() as i32;
    let places: Vec<f32> = (-reach..=reach).map(|i| i as f32).collect();
    let of = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
        let g = |x: f32| (-x * x / (2.0 * sigma * sigma)).exp();
        places.iter().map(|&x| f(x, g(x))).collect()
    };
    let gaussian = of(&|_, g| g);
    let edge = balanced(&of(&|x, g| -x * g), &gaussian);
    let point = balanced(&of(&|x, g| (x * x / (sigma * sigma) - 1.0) * g), &gaussian);
    let magnitudes = |plane: &FilterPlane| {
        let bright = FilterPlane::from_fn(plane.width, plane.height, |i| {
            (plane.values[i] + 16.0) / 116.0
        });
        [&edge, &point].map(|line| {
            let along = bright.filtered(line, &gaussian);
            let across = bright.filtered(&gaussian, line);
            let both = along.values.into_iter().zip(across.values);
            both.map(|(x, y): (f32, f32)| (x * x + y * y).sqrt())
                .collect::<Vec<f32>>()
        })
    };
    let ([edges_a, points_a], [edges_b, points_b]) = (magnitudes(a), magnitudes(b));
    (0..edges_a.len())
        .into_par_iter()
        .map(|i| {
            let edges = (edges_a[i] - edges_b[i]).abs();
            let points = (points_a[i] - points_b[i]).abs();
            (edges.max(points) / SQRT_2).sqrt()
        })
        .collect()
}
