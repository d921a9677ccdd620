//! How far two answers are apart.
//!
//! *Theory.* Pictures are compared as a viewer would ([`flip`], [`ssim`]), as signals ([`psnr`]), and as the 2023 study did, by
//! the difference of their Laplacians ([`laplacian`]). Rays' lengths are compared where both hit, and silhouettes where one
//! does ([`depth`]). Surfaces are compared by how far points of one are from the other ([`surface`]), stored distances by
//! their error ([`ErrorStats`]).
//!
//! *Practice.* A judge shares no code with what it judges: this crate knows pictures, slices and closures, and no other of
//! Argil's crates. Each measure is held in the tests against an independent implementation, on pictures that Argil drew. Pictures are 8-bit sRGB, and all
//! windows are applied as each page says.

pub mod depth;
mod error_stats;
pub mod flip;
pub mod laplacian;
mod picture;
mod psnr;
mod separable_filter;
mod ssim;
pub mod surface;

pub use error_stats::ErrorStats;
pub use picture::Picture;
pub use psnr::{differing_pixels, psnr};
pub use ssim::ssim;

/// Two pictures of different sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("pictures of {}x{} and {}x{} pixels: they are compared pixel by pixel, so draw them at one size", .0[0], .0[1], .1[0], .1[1])]
pub struct SizeMismatch(pub [u32; 2], pub [u32; 2]);

/// That two pictures have one size.
///
/// # Errors
/// If they have not.
pub fn check_sizes(a: &Picture, b: &Picture) -> Result<(), SizeMismatch> {
    let (a, b) = (a.size(), b.size());
    if a == b {
        Ok(())
    } else {
        Err(SizeMismatch(a, b))
    }
}
