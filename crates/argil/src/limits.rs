//! Limits on image sizes.

/// Maximum side of an image in pixels.
pub(crate) const MAX_IMAGE_SIDE: u32 = 16_384;
/// Maximum pixels of an image. Rendering takes 76 bytes per pixel.
pub(crate) const MAX_IMAGE_PIXELS: u64 = 1 << 26;
