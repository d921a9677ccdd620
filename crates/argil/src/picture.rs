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
    /// What the device took: on a GPU its own time stamps, on the CPU the clock.
    pub duration_ms: f64,
}

impl Drawn {
    pub(crate) fn new(picture: Picture, duration_ms: f64) -> Self {
        Self {
            size: picture.size,
            statistics: Statistics::of(&picture.hits),
            hit_pixels: argil_march::hit_pixels(&picture),
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
pub fn save_png(path: &Path, [width, height]: [u32; 2], rgb: &[u8]) -> Result<(), PictureError> {
    let fault = |reason: String| PictureError { path: path.into(), reason };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file =
        tempfile::Builder::new().prefix(".argil-").tempfile_in(folder).map_err(|e| fault(e.to_string()))?;
    let encoder = image::codecs::png::PngEncoder::new(std::io::BufWriter::new(&mut file));
    image::ImageEncoder::write_image(encoder, rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| fault(e.to_string()))?;
    file.persist(path).map_err(|e| fault(e.error.to_string()))?;
    Ok(())
}
