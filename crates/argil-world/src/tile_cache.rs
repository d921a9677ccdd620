//! Tiles in memory, as far as they were read.

use crate::{WorldError, WorldPlan};
use argil::scene::Scene;
use argil::volume::{LevelsLayout, Tile, TileAddress, TileHead, TileState};
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use web_time::{Duration, Instant};

/// Bytes that are read of a tile first. They hold its head and some coarse levels.
const FIRST_BYTES: u64 = 32 << 10;
/// After this time, a tile that was missing is looked for again.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// Returns the name of a tile's object in the folder of its world.
pub fn tile_name(address: TileAddress) -> String {
    format!("tiles/{address}")
}

/// A tile, as far as it was read.
#[derive(Debug)]
struct HeldTile {
    used: u64,
    head: TileHead,
    tile: Arc<Tile>,
}

#[derive(Debug, Default)]
struct Held {
    tiles: FxHashMap<TileAddress, HeldTile>,
    bytes: u64,
    clock: u64,
    problems: FxHashMap<TileAddress, (Instant, String)>,
}

/// Tiles of a world in memory, up to a number of bytes. Whoever fetches asks it which bytes of a tile are wanted, and gives them
/// to it.
#[derive(Debug)]
pub struct TileCache {
    key: [u8; 32],
    layout: LevelsLayout,
    materials: usize,
    most_bytes: u64,
    held: Mutex<Held>,
}

impl TileCache {
    /// Creates an empty cache for the tiles of a plan.
    ///
    /// # Errors
    /// If the scene is not the plan's.
    pub fn new(plan: &WorldPlan, scene: &Scene, most_bytes: u64) -> Result<Self, WorldError> {
        let prepared = plan.prepare(scene)?;
        Ok(Self {
            key: plan.tile_key(),
            layout: prepared.layout,
            materials: prepared.materials(),
            most_bytes,
            held: Mutex::default(),
        })
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a tile, if it is here with a level.
    pub fn get(&self, address: TileAddress, level: u32) -> Option<Arc<Tile>> {
        let mut held = self.held();
        held.clock += 1;
        let now = held.clock;
        let entry = held.tiles.get_mut(&address)?;
        entry.used = now;
        entry.tile.holds(level).then(|| entry.tile.clone())
    }

    /// Returns what is known of a tile: it is here with a level, or it could not be had at the last attempt. `None`: nothing is
    /// known of it.
    pub fn state(&self, address: TileAddress, level: u32) -> Option<TileState> {
        match self.get(address, level) {
            Some(tile) => Some(TileState::Ready(tile)),
            None => self.failed_at(address).map(|_| TileState::Missing),
        }
    }

    /// Returns true if a tile is to be fetched for a level. One that could not be had is fetched again after some seconds, and
    /// counts as missing in the meantime.
    pub fn is_wanted(&self, address: TileAddress, level: u32) -> bool {
        let failed = self.failed_at(address);
        self.get(address, level).is_none() && failed.is_none_or(|at| at.elapsed() >= ASK_AGAIN)
    }

    /// Returns which bytes of a tile's object are wanted next for a level. What is behind the object's end is not there.
    pub fn wanted(&self, address: TileAddress, level: u32) -> Range<u64> {
        let held = self.held();
        match held.tiles.get(&address) {
            None => 0..FIRST_BYTES,
            Some(entry) => {
                entry.head.bytes_to(entry.tile.finest_held())..entry.head.bytes_to(level)
            }
        }
    }

    /// Takes bytes of a tile's object, from a place on. They are at least as many as were wanted, or the object ends there.
    ///
    /// # Errors
    /// If they are damaged, too few, or of another tile.
    pub fn add(&self, address: TileAddress, begin: u64, bytes: &[u8]) -> Result<(), String> {
        let text = |error: argil::volume::TileError| error.to_string();
        let (head, mut tile, rest) = if begin == 0 {
            let head = TileHead::from_bytes(bytes, &self.key, address, &self.layout);
            let head = head.map_err(text)?;
            let tile = Tile::of_head(&head);
            (head, tile, &bytes[TileHead::BYTES..])
        } else {
            let held = self.held();
            let entry = held.tiles.get(&address);
            let entry =
                entry.filter(|entry| entry.head.bytes_to(entry.tile.finest_held()) == begin);
            // What was dropped in the meantime is asked for again.
            let Some(entry) = entry else { return Ok(()) };
            (entry.head.clone(), (*entry.tile).clone(), bytes)
        };
        let before = tile.finest_held();
        tile.read_levels(&head, rest).map_err(text)?;
        if begin > 0 && tile.finest_held() == before {
            return Err(format!(
                "it ends after {} bytes",
                begin + bytes.len() as u64
            ));
        }
        if !tile.fits(self.materials) {
            return Err("it has materials that the scene lacks".to_owned());
        }
        self.hold(head, tile);
        Ok(())
    }

    fn hold(&self, head: TileHead, tile: Tile) {
        let mut held = self.held();
        held.clock += 1;
        let address = tile.address();
        held.bytes += tile.memory_bytes();
        held.problems.remove(&address);
        let entry = HeldTile {
            used: held.clock,
            head,
            tile: Arc::new(tile),
        };
        if let Some(old) = held.tiles.insert(address, entry) {
            held.bytes -= old.tile.memory_bytes();
        }
        while held.bytes > self.most_bytes && held.tiles.len() > 1 {
            let oldest = held.tiles.iter().min_by_key(|(_, entry)| entry.used);
            let Some(oldest) = oldest.map(|(address, _)| *address) else {
                break;
            };
            if let Some(old) = held.tiles.remove(&oldest) {
                held.bytes -= old.tile.memory_bytes();
            }
        }
    }

    /// Notes that a tile cannot be had, and why.
    pub fn fail(&self, address: TileAddress, reason: String) {
        self.held()
            .problems
            .insert(address, (Instant::now(), reason));
    }

    /// Returns when a tile could not be had, if that is how the last attempt ended.
    fn failed_at(&self, address: TileAddress) -> Option<Instant> {
        self.held().problems.get(&address).map(|(at, _)| *at)
    }

    /// Returns the tiles that could not be had when they were asked for last, and why.
    pub fn problems(&self) -> Vec<(TileAddress, String)> {
        let held = self.held();
        let mut all: Vec<_> = held
            .problems
            .iter()
            .map(|(address, (_, reason))| (*address, reason.clone()))
            .collect();
        all.sort_unstable();
        all
    }
}
