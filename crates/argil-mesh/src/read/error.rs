//! The reason why a mesh cannot be read.

use crate::MeshFormat;
use std::path::PathBuf;

/// Maximum triangles of a mesh.
pub(super) const MAX_TRIANGLES: usize = 50_000_000;

/// The reason why bytes are not a mesh.
#[derive(Debug)]
pub(super) enum ReadFault {
    Damaged(String),
    Unsupported(String),
    /// What there is too much of, with the number and the maximum.
    TooLarge(String),
}

impl From<String> for ReadFault {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

impl From<&str> for ReadFault {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.into())
    }
}

#[cfg(feature = "files")]
impl ReadFault {
    /// Adds the place to a reason.
    pub(super) fn within(self, place: &str) -> Self {
        match self {
            Self::Damaged(reason) => Self::Damaged(format!("{place}: {reason}")),
            other => other,
        }
    }
}

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
