//! Images that scenes name.

use crate::validation::ValidationError;
use std::sync::Arc;

/// Endings of files that hold images.
pub const IMAGE_ENDINGS: [&str; 5] = ["png", "jpg", "jpeg", "hdr", "exr"];

/// An image: linear RGB with the primaries of sRGB, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneImage {
    /// Width and height in pixels, at least 1.
    pub size: [u32; 2],
    /// The pixels, all finite and not negative.
    pub pixels: Vec<[f32; 3]>,
}

/// An image, if it is loaded. Any two are equal, because the file's name determines them.
#[derive(Clone, Debug, Default)]
pub struct LoadedImage(pub Option<Arc<SceneImage>>);

impl PartialEq for LoadedImage {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Checks the name of an image's file.
pub(crate) fn check(path: &str) -> Result<(), ValidationError> {
    let ending = path.rsplit_once('.').map_or("", |(_, ending)| ending);
    let is_known = IMAGE_ENDINGS
        .iter()
        .any(|known| ending.eq_ignore_ascii_case(known));
    if is_known {
        return Ok(());
    }
    let endings = IMAGE_ENDINGS.join(", .");
    let reason = format!("\"{path}\" is not the name of an image: it ends with one of .{endings}");
    Err(ValidationError::new("", reason))
}
