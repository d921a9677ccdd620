//! How large pictures can be.

/// Longest side of a picture in pixels.
pub(crate) const MAX_IMAGE_SIDE: u32 = 16_384;
/// Most pixels of a picture: it takes 76 bytes a pixel while it is drawn.
pub(crate) const MAX_IMAGE_PIXELS: u64 = 1 << 26;
