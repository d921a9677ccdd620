//! Reads mesh files.

mod address;
#[cfg(feature = "files")]
mod budget;
mod error;
mod file;
#[cfg(feature = "files")]
mod gltf;
#[cfg(feature = "files")]
mod obj;
mod parse;
#[cfg(feature = "files")]
mod ply;
#[cfg(feature = "files")]
mod polygon;
mod source;
#[cfg(feature = "files")]
mod stl;
#[cfg(feature = "files")]
mod strips;
#[cfg(feature = "files")]
mod text;
#[cfg(feature = "files")]
mod three_mf;

use crate::MeshFormat;
pub use error::MeshReadError;
pub use file::MeshFile;
pub use source::{MeshSource, bytes, path_within};
use std::path::Path;

/// Reads a mesh file's triangles: all its objects, without normals and materials.
///
/// # Errors
/// If the file cannot be read, or does not hold what its extension says.
pub fn read(path: &Path) -> Result<MeshFile, MeshReadError> {
    MeshSource::open(path)?.read()
}

/// Reads a mesh from bytes: see [`read`](fn@read). `path` appears only in messages.
///
/// # Errors
/// If the bytes are not a mesh of this format.
pub fn from_bytes(
    bytes: &[u8],
    format: MeshFormat,
    path: &Path,
) -> Result<MeshFile, MeshReadError> {
    MeshSource::new(bytes, format, path).read()
}
