#[cfg(feature = "png")]
use crate::{ImageFileError, limits::MAX_IMAGE_PIXELS};
use argil_render::{RayStatistics, RenderMode, RenderOutput, RenderSettings};
#[cfg(feature = "png")]
use std::path::Path;

/// A rendered image.
///
/// [`World::render`](crate::World::render) returns it.
#[derive(Clone, Debug)]
pub struct RenderedImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels as 8-bit sRGB, three bytes each, row by row from the top.
    pub rgb: Vec<u8>,
    /// Statistics of the primary rays, if [`RenderSettings::statistics`](argil_render::RenderSettings::statistics) asks for them.
    pub statistics: Option<RayStatistics>,
    /// Pixels of which at least half of the samples hit a solid.
    pub hit_pixels: usize,
    /// Steps that are red, if the image shows [`RenderMode::Heat`](argil_render::RenderMode::Heat): blue are none, green a third, and
    /// yellow two thirds of them.
    pub heat_steps: Option<u32>,
    /// Duration in milliseconds: from the GPU's timestamps, or from the clock on the CPU and on software GPUs.
    pub duration_ms: f64,
}

/// What is known of an image that stays on the GPU.
///
/// `World::render_into` returns it.
#[cfg(feature = "gpu")]
#[derive(Clone, Debug)]
pub struct RenderReport {
    /// Statistics of the primary rays, if [`RenderSettings::statistics`](argil_render::RenderSettings::statistics) asks for them.
    pub statistics: Option<RayStatistics>,
    /// Duration in milliseconds: from the GPU's timestamps, or from the clock on software GPUs.
    pub duration_ms: f64,
}

impl RenderedImage {
    pub(crate) fn new(picture: RenderOutput, settings: &RenderSettings, duration_ms: f64) -> Self {
        Self {
            size: picture.size,
            statistics: picture.statistics,
            hit_pixels: picture.hit_pixels,
            rgb: picture.rgb,
            heat_steps: settings
                .heat_steps
                .filter(|_| settings.mode == RenderMode::Heat),
            duration_ms,
        }
    }

    /// Writes the image as a PNG file, atomically.
    ///
    /// # Errors
    /// If the file cannot be written.
    #[cfg(feature = "png")]
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), ImageFileError> {
        save_png(path.as_ref(), self.size, &self.rgb)
    }
}

/// Writes 8-bit RGB as a PNG file, atomically.
///
/// # Errors
/// If the file cannot be written, or `rgb` is not three bytes per pixel.
#[cfg(feature = "png")]
pub fn save_png(path: &Path, size: [u32; 2], rgb: &[u8]) -> Result<(), ImageFileError> {
    argil_scene::write_atomically(path, |out| write_png(size, rgb, out)).map_err(|e| {
        ImageFileError {
            path: path.into(),
            reason: e.to_string(),
        }
    })
}

/// Writes 8-bit RGB as a PNG stream.
///
/// # Errors
/// If `out` fails, or `rgb` is not three bytes per pixel.
#[cfg(feature = "png")]
pub fn write_png(
    [width, height]: [u32; 2],
    rgb: &[u8],
    out: &mut dyn std::io::Write,
) -> std::io::Result<()> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(std::io::Error::other)?;
    writer
        .write_image_data(rgb)
        .map_err(std::io::Error::other)?;
    writer.finish().map_err(std::io::Error::other)
}

/// An image from a PNG file.
#[cfg(feature = "png")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PngImage {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels as 8-bit RGB, three bytes each, row by row from the top.
    pub rgb: Vec<u8>,
    /// Whether the file held more than that: an alpha channel, or 16 bits per channel.
    pub lost_precision: bool,
}

/// Reads a PNG file as 8-bit RGB.
///
/// # Errors
/// If the file cannot be read, or is not a PNG image.
#[cfg(feature = "png")]
pub fn read_png(path: impl AsRef<Path>) -> Result<PngImage, ImageFileError> {
    let path = path.as_ref();
    let fault = |reason: String| ImageFileError {
        path: path.into(),
        reason,
    };
    let file = std::fs::File::open(path).map_err(|e| fault(e.to_string()))?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(file));
    let header = decoder
        .read_header_info()
        .map_err(|e| fault(format!("not a PNG image: {e}")))?;
    let (width, height) = header.size();
    if u64::from(width) * u64::from(height) > MAX_IMAGE_PIXELS {
        return Err(fault(format!(
            "{width} × {height} pixels: images have up to {MAX_IMAGE_PIXELS}; make it smaller"
        )));
    }
    let had_more = header.bit_depth == png::BitDepth::Sixteen
        || matches!(
            header.color_type,
            png::ColorType::Rgba | png::ColorType::GrayscaleAlpha
        );
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let wrong = |e: png::DecodingError| fault(format!("it is damaged: {e}"));
    let mut reader = decoder.read_info().map_err(wrong)?;
    let bytes = reader
        .output_buffer_size()
        .ok_or_else(|| fault("it is too large".into()))?;
    let mut pixels = vec![0; bytes];
    let frame = reader.next_frame(&mut pixels).map_err(wrong)?;
    let samples = frame.color_type.samples();
    let rgb = pixels[..frame.buffer_size()]
        .chunks_exact(samples)
        .flat_map(|pixel| match *pixel {
            [r, g, b, ..] => [r, g, b],
            [gray, ..] => [gray; 3],
            [] => [0; 3],
        })
        .collect();
    Ok(PngImage {
        size: [frame.width, frame.height],
        rgb,
        lost_precision: had_more,
    })
}

#[cfg(all(test, feature = "png"))]
mod tests {
    use super::*;

    /// A file of any length can announce pixels that fill the memory.
    #[test]
    fn absurd_sizes_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let file = std::fs::File::create(&path).expect("a file");
        let mut encoder = png::Encoder::new(file, 60_000, 60_000);
        encoder.set_color(png::ColorType::Rgb);
        drop(encoder.write_header().expect("a header"));
        let refused = read_png(&path).expect_err("too large").to_string();
        assert!(refused.contains("60000 × 60000 pixels"), "{refused}");
    }
}
