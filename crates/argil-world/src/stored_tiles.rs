//! Fetches tiles from a store.

use crate::Store;
use crate::tile_cache::{TileCache, tile_name};
use crate::tile_cache_options::TileCacheOptions;
use argil::volume::{Tile, TileAddress, TileSource, TileState};
use futures_util::StreamExt;
use rustc_hash::FxHashSet;
use std::path::PathBuf;
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
    /// The world's folder on disk, and the folder of all worlds.
    folder: Option<PathBuf>,
    root: Option<PathBuf>,
    disk_bytes: u64,
    fetched: [AtomicU64; 2],
    /// Bytes that were written to the disk since it was looked at.
    written: AtomicU64,
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
        let root = options.folder.clone().filter(|_| !is_near);
        Self {
            cache,
            folder: root.as_ref().map(|folder| folder.join(hash)),
            root,
            disk_bytes: options.disk_bytes,
            fetched: [const { AtomicU64::new(0) }; 2],
            written: AtomicU64::new(options.disk_bytes),
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
            && let Some(bytes) = self.on_disk(address)
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
            let part = self.world.get_part(&tile_name(address), range).await;
            let part = part.map_err(|error| error.to_string())?;
            let Some((begin, bytes)) = part else {
                return Err("the store does not have it".to_owned());
            };
            match self.cache.add(address, begin, &bytes) {
                Ok(()) => {
                    self.fetched[0].fetch_add(1, Ordering::Relaxed);
                    self.fetched[1].fetch_add(bytes.len() as u64, Ordering::Relaxed);
                    self.to_disk(address, begin, &bytes);
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

    fn is_wanted(&self, address: TileAddress, level: u32) -> bool {
        self.cache.state(address, level).is_none()
    }

    fn on_disk(&self, address: TileAddress) -> Option<Vec<u8>> {
        let path = self.folder.as_ref()?.join(tile_name(address));
        let bytes = std::fs::read(&path).ok()?;
        // The oldest go first.
        let file = std::fs::File::options().append(true).open(&path);
        let _ = file.and_then(|file| file.set_modified(std::time::SystemTime::now()));
        Some(bytes)
    }

    /// Keeps bytes of a tile on the disk, behind those that are there. What fails there costs only time.
    fn to_disk(&self, address: TileAddress, begin: u64, bytes: &[u8]) {
        let Some(folder) = &self.folder else { return };
        let path = folder.join(tile_name(address));
        let Some(parent) = path.parent() else { return };
        let before = match begin {
            0 => Vec::new(),
            _ => std::fs::read(&path).unwrap_or_default(),
        };
        if (before.len() as u64) < begin {
            return;
        }
        let write = || {
            std::fs::create_dir_all(parent)?;
            let mut file = tempfile::NamedTempFile::new_in(parent)?;
            std::io::Write::write_all(&mut file, &before[..begin as usize])?;
            std::io::Write::write_all(&mut file, bytes)?;
            file.persist(&path).map_err(|error| error.error)?;
            Ok::<(), std::io::Error>(())
        };
        let _ = write();
        let more = bytes.len() as u64;
        if self.written.fetch_add(more, Ordering::Relaxed) + more > self.disk_bytes / 16 {
            self.written.store(0, Ordering::Relaxed);
            self.trim_disk();
        }
    }

    /// Removes the tiles that were not used for the longest time, of all worlds.
    fn trim_disk(&self) {
        let (mut files, mut open) = (Vec::new(), Vec::from_iter(self.root.clone()));
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let Ok(about) = entry.metadata() else {
                    continue;
                };
                if about.is_dir() {
                    open.push(entry.path());
                } else if let Ok(when) = about.modified() {
                    files.push((when, about.len(), entry.path()));
                }
            }
        }
        files.sort_unstable();
        let mut bytes: u64 = files.iter().map(|(_, length, _)| length).sum();
        for (_, length, path) in files {
            if bytes <= self.disk_bytes {
                break;
            }
            if std::fs::remove_file(path).is_ok() {
                bytes -= length;
            }
        }
    }
}

/// Waits for tiles, for pictures that are to be complete.
impl TileSource for StoredTiles {
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        let wanted = wanted.iter().copied();
        let wanted = wanted.filter(|&(address, level)| self.is_wanted(address, level));
        let fetches =
            futures_util::stream::iter(wanted).map(|(address, level)| self.take(address, level));
        let all = fetches.buffer_unordered(AT_ONCE).for_each(|_| async {});
        self.world.runtime().block_on(all);
    }

    fn tile(&self, address: TileAddress, level: u32) -> TileState {
        if let Some(known) = self.cache.state(address, level) {
            return known;
        }
        match self.world.runtime().block_on(self.take(address, level)) {
            Some(tile) => TileState::Ready(tile),
            None => TileState::Missing,
        }
    }
}

/// Fetches tiles in the background, for whoever draws in the meantime.
#[derive(Debug)]
pub(crate) struct EventualTiles(pub Arc<StoredTiles>);

impl TileSource for EventualTiles {
    fn prefetch(&self, wanted: &[(TileAddress, u32)]) {
        for &(address, level) in wanted {
            if self.0.is_wanted(address, level) && self.0.pending().insert(address) {
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
        self.0.cache.state(address, level).unwrap_or_else(|| {
            self.prefetch(&[(address, level)]);
            TileState::Pending
        })
    }
}
