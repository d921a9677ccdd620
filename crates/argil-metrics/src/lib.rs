#![doc = include_str!("crate.md")]

pub mod depth;
mod error_stats;
pub mod flip;
mod image;
pub mod laplacian;
mod psnr;
mod separable_filter;
mod ssim;
pub mod surface;

pub use error_stats::ErrorStats;
pub use image::Rgb8Image;
pub use psnr::{differing_pixels, psnr};
pub use ssim::ssim;

/// Two images have different sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("images of {}x{} and {}x{} pixels cannot be compared: render both at the same size", .0[0], .0[1], .1[0], .1[1])]
pub struct SizeMismatch(pub [u32; 2], pub [u32; 2]);

/// Checks that two images have the same size.
///
/// # Errors
/// If they do not.
pub fn check_sizes(a: &Rgb8Image, b: &Rgb8Image) -> Result<(), SizeMismatch> {
    let (a, b) = (a.size(), b.size());
    if a == b {
        Ok(())
    } else {
        Err(SizeMismatch(a, b))
    }
}
