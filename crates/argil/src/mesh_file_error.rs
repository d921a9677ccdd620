//! Errors of files that scenes name.

use argil_mesh::MeshReadError;
use std::path::PathBuf;

/// The reason why a mesh that a scene names cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// The file cannot be read.
    #[error(transparent)]
    Input(#[from] MeshReadError),
    /// The file holds no solid.
    #[error("{}", path.display())]
    Empty {
        /// Path of the file.
        path: PathBuf,
        /// What was wrong.
        source: MeshReadError,
    },
    /// The volume of another program cannot be read.
    #[cfg(feature = "volume-files")]
    #[error(transparent)]
    Volume(#[from] crate::VolumeReadError),
    /// An image cannot be read.
    #[error("{}: {reason}", path.display())]
    Image {
        /// Path of the file.
        path: PathBuf,
        /// What was wrong, and what helps.
        reason: String,
    },
    /// The file lies outside the scene's folder.
    #[error(
        "the file \"{path}\" is outside the folder of its scene, {}: move it there, or allow external meshes",
        folder.display()
    )]
    ExternalMesh {
        /// Path in the scene.
        path: String,
        /// Folder of the scene.
        folder: PathBuf,
    },
}
