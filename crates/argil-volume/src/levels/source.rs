//! Stores of tiles.

use super::tile::{Tile, TileAddress};
use argil_abi::GpuMaterial;
use argil_math::Aabb;
use rustc_hash::FxHashMap;
use std::fmt::Debug;
use std::sync::Arc;

/// Whether a store has a tile.
#[derive(Clone, Debug)]
pub enum TileState {
    /// It is here.
    Ready(Arc<Tile>),
    /// It is on its way: ask again.
    Pending,
    /// The store lacks it, or its bytes are damaged.
    Missing,
}

/// A store of tiles of the same world, with the same layout.
pub trait TileSource: Debug + Send + Sync {
    /// Begins to fetch tiles that will be asked for, at once. Each is wanted down to a level.
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        let _ = wanted;
    }

    /// Returns a tile that holds a level and all coarser ones, if it is there.
    fn tile(&self, address: TileAddress, level: u32) -> TileState;
}

/// The store of levels, and what is not to be taken from it.
#[derive(Clone, Debug)]
pub(super) struct StoredTiles {
    pub source: Arc<dyn TileSource>,
    pub bakes_missing: bool,
    /// The materials to whose places the tiles refer.
    pub palette: Vec<GpuMaterial>,
    /// What edits changed since the tiles were baked, level by level.
    pub edited: Vec<Vec<Aabb>>,
}

impl StoredTiles {
    /// Notes boxes of a level in which stored pages are no longer true.
    pub(super) fn note_edits(&mut self, level: u32, boxes: &[Aabb]) {
        let own = &mut self.edited[level as usize];
        for one in boxes {
            if !own.contains(one) {
                own.push(*one);
            }
        }
    }
}

/// Tiles in memory, for tests and small worlds.
impl TileSource for FxHashMap<TileAddress, Arc<Tile>> {
    fn tile(&self, address: TileAddress, _: u32) -> TileState {
        match self.get(&address) {
            Some(tile) => TileState::Ready(tile.clone()),
            None => TileState::Missing,
        }
    }
}
