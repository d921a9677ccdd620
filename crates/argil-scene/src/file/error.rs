//! Errors of scene files, and limits on their size.

use crate::{EditError, ValidationError};
use std::path::PathBuf;

/// The version that this program writes, and the newest that it reads.
pub const FORMAT_VERSION: u32 = 1;

/// Maximum nesting of JSON values. Two levels make one level of groups.
pub(super) const MAX_DEPTH: u32 = 200_000;

/// Maximum bytes of a part: a shape, a list of modifiers, a name.
pub(super) const MAX_PART_BYTES: usize = 1 << 26;

/// Maximum bytes of a file that is read as a whole. Larger files are streamed.
pub(super) const MAX_QUICK_BYTES: u64 = 1 << 30;

/// The reason why a scene file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file cannot be opened, read or written.
    #[error("{path}: this file cannot be read or written")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file does not hold a valid scene.
    #[error("{path}:{line}:{column}: {fault}")]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column in characters, from 1.
        column: u64,
        /// Path in the document, and what is wrong there.
        fault: ValidationError,
    },
    /// A newer program wrote the file.
    #[error(
        "{path}: format version {found} is newer than this program reads ({FORMAT_VERSION}): update argil"
    )]
    Newer {
        /// Path of the file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
}

/// Turns an error of an edit into an error of the file.
pub(super) fn fault_of(error: EditError) -> ValidationError {
    match error {
        EditError::Fault(fault) => fault,
        EditError::NoSuchMaterial(name) => {
            ValidationError::new("material", format!("the scene has no material \"{name}\""))
        }
        other => ValidationError::new("", other.to_string()),
    }
}
