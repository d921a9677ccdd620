use crate::PictureError;
use argil_march::{Picture, Statistics};
use std::path::Path;

/// A picture with how it was made.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// RGB in sRGB, 8 bits a channel, row by row from the top.
    pub rgb: Vec<u8>,
    /// What the primary rays did.
    pub statistics: Statistics,
    /// Pixels of which at least half of the samples hit a solid.
    pub hit_pixels: usize,
    /// What the device took: by a GPU's own time stamps, by the clock on the CPU and on a GPU in software, whose stamps tell nothing.
    pub duration_ms: f64,
}

impl Drawn {
    pub(crate) fn new(picture: Picture, duration_ms: f64) -> Self {
        Self {
            size: picture.size,
            statistics: picture.statistics,
            hit_pixels: picture.hit_pixels,
            rgb: picture.rgb,
            duration_ms,
        }
    }

    /// Write a PNG, beside its place and then renamed into it.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), PictureError> {
        save_png(path.as_ref(), self.size, &self.rgb)
    }
}

/// Write 8-bit RGB as a PNG, beside its place and then renamed into it.
pub fn save_png(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), PictureError> {
    argil_scene::replace_file(path, |out| write_png(size, rgb, out)).map_err(|e| PictureError {
        path: path.into(),
        reason: e.to_string(),
    })
}

/// Write 8-bit RGB as a PNG.
///
/// # Errors
/// If `out` does not take it, or there are not as many bytes as pixels take.
pub fn write_png(
    [width, height]: [u32; 2],
    rgb: &[u8],
    out: &mut dyn std::io::Write,
) -> std::io::Result<()> {
    let encoder = image::codecs::png::PngEncoder::new(out);
    image::ImageEncoder::write_image(encoder, rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(std::io::Error::other)
}
