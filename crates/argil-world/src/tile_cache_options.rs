//! What is kept of tiles.

use std::path::PathBuf;

/// What is kept of a world's tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileCacheOptions {
    /// Maximum bytes of tiles in memory.
    pub memory_bytes: u64,
    /// A folder for tiles from behind the network, which lie in `argil-tiles` in it. Worlds share it. Nothing else there is touched.
    pub folder: Option<PathBuf>,
    /// Maximum bytes of tiles in the folder.
    pub disk_bytes: u64,
}

impl Default for TileCacheOptions {
    fn default() -> Self {
        Self {
            memory_bytes: 256 << 20,
            folder: None,
            disk_bytes: 4 << 30,
        }
    }
}

impl TileCacheOptions {
    /// Returns the usual limits, with the folder that the variable `ARGIL_TILE_CACHE` names: by default one in the user's cache, and
    /// none if it is empty.
    pub fn from_environment() -> Self {
        let folder = match std::env::var_os("ARGIL_TILE_CACHE") {
            Some(folder) if folder.is_empty() => None,
            Some(folder) => Some(folder.into()),
            None => argil::cache_folder(),
        };
        Self {
            folder,
            ..Self::default()
        }
    }
}
