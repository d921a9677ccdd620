//! Worlds in stores, as they are open.

use crate::render_worker::StoredPages;
use argil::scene::Scene;

/// A world in a store that is open.
pub(crate) struct OpenWorld {
    /// The tiles.
    pub pages: StoredPages,
    /// What saves edits.
    #[cfg(not(target_arch = "wasm32"))]
    pub stored: argil_world::StoredWorld,
}

/// A world that was read.
pub(crate) struct FoundWorld {
    /// The folder or address.
    pub address: String,
    /// The scene of the tiles, without edits.
    pub planned: Scene,
    /// The texts of all saved edits.
    pub deltas: Vec<String>,
    /// The world.
    pub world: OpenWorld,
}
