//! Why a journal cannot be written or read.

use crate::{EditError, FileError, FoldError, LogError};
use std::path::PathBuf;

/// Version of the format. The first one had no samples.
pub(super) const VERSION: u32 = 2;

/// The reason why a journal cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file cannot be written or read.
    #[error("{path}: this file cannot be read or written")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The scene already has a history, whose undo could not be replayed.
    #[error("a journal must begin before the first edit, and this scene has {0} edits")]
    HistoryNotEmpty(usize),
    /// The file has no bytes: its session ended before it recorded anything.
    #[error(
        "{0}: nothing was recorded: the session ended before its first edit, and its scene is as it was"
    )]
    Empty(PathBuf),
    /// There is a journal, and it is not replaced.
    #[error(
        "{0}: the journal already exists: recover its edits with `argil recover`, or remove it"
    )]
    Exists(PathBuf),
    /// The file does not begin as a journal does.
    #[error("{0}: not a journal of edits, or its first line is damaged")]
    NoJournal(PathBuf),
    /// A newer program wrote it.
    #[error(
        "{path}: journal version {found} is newer than this program reads ({VERSION}): update argil"
    )]
    Newer {
        /// Path of the file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The scene at its beginning cannot be read.
    #[error(transparent)]
    Scene(#[from] FileError),
    /// A line before the last one is damaged.
    #[error(
        "{path}:{line}: this line is damaged and more lines follow: to recover the edits before it, truncate a copy of the file before this line"
    )]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// A complete line cannot be replayed.
    #[error(
        "{path}:{line}: this line cannot be replayed: to recover the edits before it, truncate a copy of the file before this line"
    )]
    Line {
        /// Path of the file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The reason.
        source: LogError,
    },
    /// The edit was refused, and nothing was recorded.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A line to replay was refused, and nothing was recorded.
    #[error(transparent)]
    Replay(LogError),
    /// A history could not be folded, and nothing was recorded.
    #[error(transparent)]
    Fold(#[from] FoldError),
}
