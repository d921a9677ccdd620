//! Why a scene's file cannot be read or written, and how large one may be.

use crate::{EditError, ValidationError};
use std::path::PathBuf;

/// The version that this program writes, and the newest that it reads.
pub const FORMAT_VERSION: u32 = 1;

/// Deepest nesting of JSON values in a file; two levels make one level of groups.
pub(super) const MAX_DEPTH: u32 = 200_000;

/// Longest part (a shape, a list of modifiers, a name) in bytes.
pub(super) const MAX_PART_BYTES: usize = 1 << 20;

/// Longest file that is read as a whole; others are streamed.
pub(super) const MAX_QUICK_BYTES: u64 = 1 << 30;

/// Why a scene file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file itself could not be opened, read or written.
    #[error("{path}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// What the file holds is not a scene.
    #[error("{path}:{line}:{column}: {fault}")]
    Content {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column in characters, from 1.
        column: u64,
        /// The path in the document, and what is wrong there.
        fault: ValidationError,
    },
    /// The file was written by a newer program.
    #[error(
        "{path}: format version {found} is newer than this program reads ({FORMAT_VERSION}): update argil"
    )]
    Newer {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
}

/// A fault in an entry seen as a fault in the file.
pub(super) fn fault_of(error: EditError) -> ValidationError {
    match error {
        EditError::Fault(fault) => fault,
        EditError::NoSuchMaterial(name) => {
            ValidationError::new("material", format!("the scene has no material \"{name}\""))
        }
        other => ValidationError::new("", other.to_string()),
    }
}
