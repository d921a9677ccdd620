//! What can go wrong with a world.

use crate::redact::redacted;
use argil::BuildError;
use std::path::PathBuf;

/// The reason why a world cannot be planned, baked or read. No message holds a secret.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A store or an object in it cannot be read or written.
    #[error("{place}: {reason}")]
    Store {
        /// The store, and the object in it.
        place: String,
        /// What the store says.
        reason: String,
    },
    /// A store's address cannot be used.
    #[error("{place}: {reason}")]
    Address {
        /// The address.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// A file is no plan or manifest, or of a later version.
    #[error("{place}: {reason}")]
    Plan {
        /// The file or object.
        place: String,
        /// What is wrong.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {reason}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// What the system says.
        reason: std::io::Error,
    },
    /// The scene was changed after the plan was made, so other tiles would come out.
    #[error(
        "the plan was made for another scene: {0}. Make a new plan: its tiles go to a folder of their own"
    )]
    Changed(String),
    /// A world is not complete.
    #[error("{missing} of {tiles} tiles are missing, among them {first}: bake them first")]
    Incomplete {
        /// Tiles that are missing.
        missing: u64,
        /// Tiles of the world.
        tiles: u64,
        /// One that is missing.
        first: String,
    },
    /// Tiles are damaged.
    #[error(
        "{damaged} of {tiles} tiles were damaged, among them {first} ({reason}), and are removed: bake again"
    )]
    Damaged {
        /// Tiles that are damaged.
        damaged: u64,
        /// Tiles of the world.
        tiles: u64,
        /// One that is damaged.
        first: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A shard does not exist.
    #[error(
        "shard {index} of {count}: shards count from 0 to {count} − 1, and there is one at least"
    )]
    Shard {
        /// The number of the shard.
        index: u64,
        /// The number of shards.
        count: u64,
    },
    /// A voxel size is no length.
    #[error("voxel_size: {0} is not a positive length")]
    VoxelSize(f32),
    /// The scene cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The work was canceled.
    #[error("canceled")]
    Cancelled,
}

impl WorldError {
    #[cfg(feature = "store")]
    pub(crate) fn store(place: impl Into<String>, reason: &impl std::fmt::Display) -> Self {
        Self::Store {
            place: redacted(&place.into()),
            reason: redacted(&reason.to_string()),
        }
    }

    pub(crate) fn plan(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Plan {
            place: redacted(&place.into()),
            reason: reason.into(),
        }
    }
}
