//! Fetches tiles from a store.

use crate::Store;
use crate::limits::MAX_TILE_BYTES;
use crate::tile_cache::{TileCache, tile_name};
use crate::tile_cache_options::TileCacheOptions;
use crate::tile_folder::TileFolder;
use argil::volume::{Tile, TileAddress, TileSource, TileState};
use futures_util::StreamExt;
use rustc_hash::FxHashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Semaphore;

/// Tiles that are fetched at once.
const AT_ONCE: usize = 16;
/// How often a tile is fetched whose bytes are damaged.
const TRIES: u32 = 3;

/// The tiles of a world, fetched when they are asked for.
#[derive(Debug)]
pub(crate) struct StoredTiles {
    world: Store,
    pub cache: TileCache,
    /// Tiles on the disk, of worlds from behind the network.
    folder: Option<TileFolder>,
    fetched: [AtomicU64; 2],
    /// Tiles that are on their way.
    pending: Mutex<FxHashSet<TileAddress>>,
    room: Semaphore,
}

impl StoredTiles {
    pub(crate) fn new(
        world: Store,
        hash: &str,
        cache: TileCache,
        options: &TileCacheOptions,
    ) -> Self {
        let is_near = !world.place().contains("://");
        let folder = options.folder.as_ref().filter(|_| !is_near);
        // A folder that cannot be used costs only time.
        let folder = folder.and_then(|at| TileFolder::open(at, hash, options.disk_bytes).ok());
        Self {
            cache,
            folder,
            fetched: [const { AtomicU64::new(0) }; 2],
            pending: Mutex::default(),
            room: Semaphore::new(AT_ONCE),
            world,
        }
    }

    /// Returns the number of requests that the store answered with bytes, and the bytes.
    pub(crate) fn fetched(&self) -> [u64; 2] {
        self.fetched.each_ref().map(|n| n.load(Ordering::Relaxed))
    }

    fn pending(&self) -> MutexGuard<'_, FxHashSet<TileAddress>> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fetches a tile down to a level, from the disk as far as it is there.
    async fn fetch(&self, address: TileAddress, level: u32) -> Result<Arc<Tile>, String> {
        if self.cache.wanted(address, level).start == 0
            && let Some(bytes) = self.folder.as_ref().and_then(|cached| cached.read(address))
        {
            // Fetched again if it is damaged.
            let _ = self.cache.add(address, 0, &bytes);
        }
        let (mut reason, mut damaged) = ("it was dropped again and again".to_owned(), 0);
        // A tile comes in two parts, or more if it is dropped from memory in between.
        for _ in 0..4 * TRIES {
            if damaged == TRIES {
                break;
            }
            if let Some(tile) = self.cache.get(address, level) {
                return Ok(tile);
            }
            let range = self.cache.wanted(address, level);
            let part = self
                .world
                .get_part(&tile_name(address), range, MAX_TILE_BYTES)
                .await;
            let part = part.map_err(|error| error.to_string())?;
            let Some((begin, bytes)) = part else {
                return Err("the store does not have it".to_owned());
            };
            match self.cache.add(address, begin, &bytes) {
                Ok(()) => {
                    self.fetched[0].fetch_add(1, Ordering::Relaxed);
                    self.fetched[1].fetch_add(bytes.len() as u64, Ordering::Relaxed);
                    if let Some(folder) = &self.folder {
                        // What fails there costs only time.
                        let _ = folder.write(address, begin, &bytes);
                    }
                }
                Err(error) => {
                    reason = error;
                    damaged += 1;
                }
            }
        }
        Err(reason)
    }

    /// Fetches a tile, or notes why it cannot be had.
    async fn take(&self, address: TileAddress, level: u32) -> Option<Arc<Tile>> {
        let fetched = self.fetch(address, level).await;
        fetched
            .map_err(|reason| self.cache.fail(address, reason))
            .ok()
    }
}

/// Waits for tiles, for pictures that are to be complete.
impl TileSource for StoredTiles {
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        let wanted = wanted.iter().copied();
        let wanted = wanted.filter(|&(address, level)| self.cache.is_wanted(address, level));
        let fetches =
            futures_util::stream::iter(wanted).map(|(address, level)| self.take(address, level));
        let all = fetches.buffer_unordered(AT_ONCE).for_each(|_| async {});
        self.world.runtime().block_on(all);
    }

    fn tile(&self, address: TileAddress, level: u32) -> TileState {
        if self.cache.is_wanted(address, level)
            && let Some(tile) = self.world.runtime().block_on(self.take(address, level))
        {
            return TileState::Ready(tile);
        }
        let known = self.cache.state(address, level);
        known.unwrap_or(TileState::Missing)
    }
}

/// Fetches tiles in the background, for whoever draws in the meantime.
#[derive(Debug)]
pub(crate) struct EventualTiles(pub Arc<StoredTiles>);

impl TileSource for EventualTiles {
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        for &(address, level) in wanted {
            if self.0.cache.is_wanted(address, level) && self.0.pending().insert(address) {
                let tiles = self.0.clone();
                self.0.world.runtime().spawn(async move {
                    let room = tiles.room.acquire().await;
                    tiles.take(address, level).await;
                    tiles.pending().remove(&address);
                    drop(room);
                });
            }
        }
    }

    fn tile(&self, address: TileAddress, level: u32) -> TileState {
        self.prefetch(&[(address, level)]);
        let known = self.0.cache.state(address, level);
        known.unwrap_or(TileState::Pending)
    }
}
