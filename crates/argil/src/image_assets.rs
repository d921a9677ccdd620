//! Reads the images that scenes name: textures, and environments.

#[cfg(feature = "image-files")]
use crate::limits::MAX_IMAGE_PIXELS;
use crate::mesh_file_error::MeshFileError;
use argil_scene::{Scene, SceneImage};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Light above this is cut, so that sums of it stay finite.
#[cfg(feature = "image-files")]
const MAX_LIGHT: f32 = 1e6;

/// Loads images that a scene names. `bytes` returns the place and the bytes of a path, or `None` to leave
/// it out.
pub(crate) fn load(
    scene: &mut Scene,
    paths: Vec<String>,
    bytes: impl Fn(&str) -> Result<Option<(PathBuf, Vec<u8>)>, MeshFileError>,
) -> Result<(), MeshFileError> {
    for path in paths {
        if let Some((place, bytes)) = bytes(&path)? {
            let image = Arc::new(decoded(&bytes, &place)?);
            scene.set_image(&path, &image);
        }
    }
    Ok(())
}

#[cfg(not(feature = "image-files"))]
fn decoded(_: &[u8], place: &Path) -> Result<SceneImage, MeshFileError> {
    Err(MeshFileError::Image {
        path: place.into(),
        reason: "this program reads no images of materials and environments".into(),
    })
}

#[cfg(feature = "image-files")]
fn decoded(bytes: &[u8], place: &Path) -> Result<SceneImage, MeshFileError> {
    use image::{ColorType, DynamicImage, ImageReader};
    let fault = |reason: String| MeshFileError::Image {
        path: place.into(),
        reason,
    };
    let damaged = |error: image::ImageError| {
        fault(format!(
            "the image cannot be read: {error}; is it whole? Save it again"
        ))
    };
    let open = || {
        let reader = ImageReader::new(std::io::Cursor::new(bytes)).with_guessed_format();
        reader.map_err(|error| damaged(error.into()))
    };
    let (width, height) = open()?.into_dimensions().map_err(damaged)?;
    if u64::from(width) * u64::from(height) > MAX_IMAGE_PIXELS {
        return Err(fault(format!(
            "{width} × {height} pixels: images have up to {MAX_IMAGE_PIXELS}; make it smaller"
        )));
    }
    if width == 0 || height == 0 {
        return Err(fault("the image has no pixels".into()));
    }
    let image = open()?.decode().map_err(damaged)?;
    let is_linear = matches!(image.color(), ColorType::Rgb32F | ColorType::Rgba32F);
    let image = DynamicImage::into_rgb32f(image);
    let pixels = image.pixels();
    let mut pixels: Vec<[f32; 3]> = pixels.map(|pixel| pixel.0).collect();
    if let Some(index) = pixels
        .iter()
        .position(|color| color.iter().any(|c| !c.is_finite()))
    {
        let (x, y) = (index % width as usize, index / width as usize);
        return Err(fault(format!(
            "the pixel in column {x} of row {y}, from 0 at the top left, is not a finite color: repair the image"
        )));
    }
    for pixel in &mut pixels {
        *pixel = pixel.map(|c| {
            let c = c.clamp(0.0, MAX_LIGHT);
            if is_linear { c } else { linear(c) }
        });
    }
    Ok(SceneImage {
        size: [width, height],
        pixels,
    })
}

/// Returns the light of a coded component (sRGB, IEC 61966-2-1).
#[cfg(feature = "image-files")]
fn linear(c: f32) -> f32 {
    if c <= 0.040_45 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}
