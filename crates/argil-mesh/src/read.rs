//! Reads mesh files.

#[cfg(feature = "files")]
mod budget;
mod error;
mod file;
#[cfg(feature = "files")]
mod gltf;
#[cfg(feature = "files")]
mod obj;
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
use error::{MAX_TRIANGLES, ReadFault};
pub use file::MeshFile;
pub use source::{MeshSource, path_within};
use std::path::{Path, PathBuf};

/// Maximum bytes of a mesh file.
const MAX_BYTES: u64 = 4 << 30;

/// The reason why a mesh cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshReadError {
    /// A [`Control`](argil_math::Control) canceled the work.
    #[error("canceled")]
    Cancelled,
    /// The file cannot be read.
    #[error("{}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file's extension is unknown.
    #[error("{}: unknown mesh format; {} can be read", .0.display(), MeshFormat::extensions("and"))]
    UnknownFormat(PathBuf),
    /// The file does not hold what its extension says.
    #[error("{}: not a valid {kind} file: {reason}", path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// The expected format.
        kind: &'static str,
        /// The reader's message.
        reason: String,
    },
    /// The file uses a feature that is not supported.
    #[error("{}: {what}", path.display())]
    Unsupported {
        /// Path of the file.
        path: PathBuf,
        /// The feature, and the remedy.
        what: String,
    },
    /// The file is too large.
    #[error("{}: {what}", path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// What there is too much of.
        what: String,
    },
    /// The mesh is too small, too large, or too far away.
    #[error(
        "its box is {size} long and {away} from the origin; the size must be 1e-4 to 1e5 and the distance at most 1e5: scale or move the model"
    )]
    Extent {
        /// The longest side.
        size: f32,
        /// The farthest vertex.
        away: f32,
    },
    /// No sample is inside.
    #[error(
        "its triangles enclose no volume that {resolution} samples can find: it may be flat, open or thin; give it a thickness, or raise the resolution"
    )]
    Hollow {
        /// Samples along its longest side.
        resolution: u32,
    },
    /// All parts are flat sheets.
    #[error(
        "its triangles are open sheets that enclose no volume: give them a thickness, for example {}",
        0.01 * size
    )]
    Sheets {
        /// The longest side of its box.
        size: f32,
    },
    /// No triangle has an area.
    #[error("it contains no triangle with an area")]
    NoTriangles,
}

/// Reads a mesh file's triangles: all its objects, without normals and materials.
///
/// # Errors
/// If the file cannot be read, or does not hold what its extension says.
pub fn read(path: &Path) -> Result<MeshFile, MeshReadError> {
    MeshSource::open(path)?.read()
}

/// Reads a mesh file's bytes.
///
/// # Errors
/// If the file cannot be read, or is too large.
pub fn bytes(path: &Path) -> Result<Vec<u8>, MeshReadError> {
    let io = |source| MeshReadError::Io {
        path: path.into(),
        source,
    };
    let about = std::fs::metadata(path).map_err(io)?;
    if about.is_dir() {
        return Err(io(std::io::Error::other("is a folder, not a mesh file")));
    }
    // A pipe that nobody writes to would never end.
    if !about.is_file() {
        return Err(io(std::io::Error::other("is not a regular file")));
    }
    if about.len() > MAX_BYTES {
        let what = format!("{} bytes, and {MAX_BYTES} can be read", about.len());
        return Err(MeshReadError::TooLarge {
            path: path.into(),
            what,
        });
    }
    std::fs::read(path).map_err(io)
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

/// Reads the triangles of a file in memory, and checks what no format promises.
fn parse(source: &MeshSource<'_>) -> Result<MeshFile, MeshReadError> {
    let mut file = parsed(source).map_err(|fault| source.error(fault))?;
    let mesh = &mut file.mesh;
    let count = mesh.triangles.len();
    if count > MAX_TRIANGLES {
        let what = format!("{count} triangles, and {MAX_TRIANGLES} can be read");
        return Err(source.error(ReadFault::TooLarge(what)));
    }
    let vertices = mesh.positions.len() as u32;
    if mesh.triangles.iter().flatten().any(|&i| i >= vertices) {
        return Err(source.error("a triangle refers to a missing vertex".into()));
    }
    if count == 0 && !file.warnings.is_empty() {
        let what = format!("no triangle is left: {}", file.warnings.join("; "));
        return Err(source.error(ReadFault::Unsupported(what)));
    }
    // Points, lines and lattices have vertices, too.
    let mut is_used = vec![false; mesh.positions.len()];
    for &i in mesh.triangles.iter().flatten() {
        is_used[i as usize] = true;
    }
    if is_used.contains(&false) {
        *mesh = mesh.submesh(&mesh.triangles);
    }
    Ok(file)
}

#[cfg(feature = "files")]
fn parsed(source: &MeshSource<'_>) -> Result<MeshFile, ReadFault> {
    let bytes = &source.bytes;
    match source.format {
        MeshFormat::Obj => obj::read(bytes),
        MeshFormat::Glb | MeshFormat::Gltf => gltf::read(bytes, &source.files),
        MeshFormat::Ply => ply::read(bytes),
        MeshFormat::Stl => stl::read(bytes),
        MeshFormat::ThreeMf => three_mf::read(bytes),
    }
}

#[cfg(not(feature = "files"))]
fn parsed(_: &MeshSource<'_>) -> Result<MeshFile, ReadFault> {
    let reason = "this program was compiled without mesh files (the feature `mesh-files`)";
    Err(ReadFault::Unsupported(reason.into()))
}
