//! The reasons why a mesh cannot be extracted or written.

use crate::BuildError;
use argil_mesh::marching::surface::SurfaceError;
use argil_mesh::{MeshFormat, MeshReadError};
use std::path::PathBuf;

/// The reason why a world cannot be meshed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The world cannot be sampled.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The volume has no surface at that distance.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// Levels have triangles of several sizes already, on the exact surface.
    #[error(
        "levels of detail are meshed at iso level 0, with normals of the field or of faces, and without simplifying: choose the pixel error instead"
    )]
    Levels,
    /// Dual contouring was asked of a volume, which has no exact normals, or of another iso level.
    #[error(
        "dual contouring needs the exact field and iso level 0: mesh the field of a scene, or use marching cubes"
    )]
    Dual,
    /// There are too many vertices to simplify.
    #[error("simplifying: {0}")]
    Simplify(String),
    /// The iso level is not a length.
    #[error("iso level {0}: it must be a length in scene units, from -1e6 to 1e6")]
    NotALength(f32),
    /// The surface at another iso level leaves a volume's box.
    #[error(
        "iso level {0}: the surface leaves the volume's box, which would cut it open; mesh the field, or choose a smaller level"
    )]
    LeavesBox(f32),
    /// The surface cannot be offset.
    #[error("iso level {iso}: the surface cannot be offset; mesh it at 0 first")]
    Offset {
        /// The requested level.
        iso: f32,
        /// The reason.
        source: MeshReadError,
    },
    /// The grid would be too large.
    #[error(
        "{0} samples: an iso level other than 0 needs a dense grid, of at most 2^31 samples; lower the resolution"
    )]
    TooMany(u64),
    /// The file name has no extension of a mesh format.
    #[error("{}: unknown mesh format; name it {}", .0.display(), MeshFormat::extensions("or"))]
    UnknownFormat(PathBuf),
    /// The file cannot be written.
    #[error("{}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}
