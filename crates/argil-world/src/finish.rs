//! Whether a world is complete.

use crate::limits::{MAX_MESH_BYTES, MAX_TEXT_BYTES, MAX_TILE_BYTES};
use crate::plan::Prepared;
use crate::work::shared;
use crate::{Manifest, Store, WorldError, WorldPlan, tile_name};
use argil::math::Control;
use argil::scene::Scene;
use argil::volume::{Tile, TileAddress};
use bytes::Bytes;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::atomic::{AtomicU64, Ordering};

/// How much of a world is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorldStatus {
    /// Tiles that there must be: those that coarser tiles refine, and below missing ones all that bounds do not rule out.
    pub tiles: u64,
    /// Tiles that are there.
    pub present: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Tiles that are missing, up to a thousand.
    pub missing: Vec<TileAddress>,
    /// Tiles that are damaged, and why, if they were read.
    pub damaged: Vec<(TileAddress, String)>,
    /// Whether the manifest is there.
    pub is_finished: bool,
}

/// Most missing tiles that are listed.
const LISTED: usize = 1000;

/// Counts what a store has of a world. With `verify`, all tiles are read, and what is damaged is listed.
///
/// # Errors
/// If the scene is not the plan's, the store fails again and again, or the work was canceled.
pub fn status(
    plan: &WorldPlan,
    scene: &Scene,
    store: &Store,
    verify: bool,
    control: &Control,
) -> Result<WorldStatus, WorldError> {
    let world = store.within(plan.hash());
    let prepared = plan.prepare(scene)?;
    control.begin("tiles", 0);
    let candidates = prepared.baker().candidates(control);
    let runtime = world.runtime();
    let listed = runtime.block_on(world.list("tiles"))?;
    let sizes: FxHashMap<TileAddress, u64> = listed
        .iter()
        .filter_map(|(name, size)| Some((name.parse().ok()?, *size)))
        .collect();
    let is_there = |address: &TileAddress| sizes.contains_key(address);
    let required = required(&world, plan, &prepared, &candidates, &is_there)?;
    let (there, missing): (Vec<TileAddress>, Vec<TileAddress>) =
        required.iter().partition(|address| is_there(address));
    let mut damaged = Vec::new();
    if verify {
        control.begin("tiles", there.len() as u64);
        let key = plan.tile_key();
        let read = |&address: &TileAddress| {
            if control.is_cancelled() {
                return Ok(None);
            }
            let bytes = world
                .runtime()
                .block_on(world.get(&tile_name(address), MAX_TILE_BYTES))?;
            control.advance(1);
            let bytes = bytes.unwrap_or_default();
            let found = Tile::from_bytes(&bytes, &key, address, &prepared.layout);
            Ok(found.err().map(|error| (address, error.to_string())))
        };
        let found: Result<Vec<_>, WorldError> = there.par_iter().map(read).collect();
        damaged = found?.into_iter().flatten().collect();
    }
    if control.is_cancelled() {
        return Err(WorldError::Cancelled);
    }
    let manifest = runtime.block_on(world.get("manifest.json", MAX_TEXT_BYTES))?;
    Ok(WorldStatus {
        tiles: required.len() as u64,
        present: there.len() as u64,
        bytes: there.iter().map(|address| sizes[address]).sum(),
        missing: missing.into_iter().take(LISTED).collect(),
        damaged,
        is_finished: manifest.is_some(),
    })
}

/// Returns the tiles that there must be. Empty ones are not stored, so it reads all tiles but the finest, and finds what they
/// refine. Below those that are missing or damaged it is not known, and all candidates count.
fn required(
    world: &Store,
    plan: &WorldPlan,
    prepared: &Prepared,
    candidates: &[TileAddress],
    is_there: &(dyn Fn(&TileAddress) -> bool + Sync),
) -> Result<Vec<TileAddress>, WorldError> {
    let (key, layout) = (plan.tile_key(), &prepared.layout);
    let read = |&address: &TileAddress| {
        let bytes = world
            .runtime()
            .block_on(world.get(&tile_name(address), MAX_TILE_BYTES))?;
        let bytes = bytes.unwrap_or_default();
        Ok(Tile::from_bytes(&bytes, &key, address, layout).ok())
    };
    let top = candidates
        .iter()
        .map(|candidate| candidate.tier)
        .max()
        .unwrap_or(0);
    let mut addresses: Vec<TileAddress> = candidates
        .iter()
        .copied()
        .filter(|candidate| candidate.tier == top)
        .collect();
    let mut all = addresses.clone();
    for tier in (0..top).rev() {
        let (there, lost): (Vec<TileAddress>, Vec<TileAddress>) =
            addresses.iter().partition(|address| is_there(address));
        let tiles: Result<Vec<_>, WorldError> = there.par_iter().map(read).collect();
        let tiles = tiles?;
        let damaged = there.iter().zip(&tiles).filter(|(_, tile)| tile.is_none());
        let mut unknown: FxHashSet<TileAddress> = damaged.map(|(address, _)| *address).collect();
        unknown.extend(lost);
        let finer = tiles.iter().flatten().flat_map(Tile::finer_tiles);
        let mut found: FxHashSet<TileAddress> = finer.collect();
        let below = candidates.iter().filter(|candidate| candidate.tier == tier);
        found.extend(below.filter(|candidate| {
            candidate
                .coarser()
                .is_some_and(|above| unknown.contains(&above))
        }));
        addresses = found.into_iter().collect();
        addresses.sort_unstable();
        all.extend(&addresses);
    }
    Ok(all)
}

/// Puts an object. What is there is replaced if it is something else: damaged, or of another program.
async fn put_right(world: &Store, name: &str, bytes: Bytes) -> Result<(), WorldError> {
    let is_new = world.put_new(name, bytes.clone()).await?;
    if !is_new
        && world
            .get(name, MAX_MESH_BYTES)
            .await?
            .is_none_or(|found| found != bytes)
    {
        world.remove(name).await?;
        world.put_new(name, bytes).await?;
    }
    Ok(())
}

/// Puts what tiles share in place of what is damaged.
async fn mend_shared(plan: &WorldPlan, scene: &Scene, world: &Store) -> Result<(), WorldError> {
    for (name, bytes) in shared(plan, scene) {
        put_right(world, &name, bytes).await?;
    }
    Ok(())
}

/// Writes a world's manifest if no tile is missing. It can be called again. With `verify`, all tiles are read; those that are
/// damaged are removed, so that a worker bakes them again.
///
/// # Errors
/// If tiles are missing or damaged, the scene is not the plan's, or the store fails again and again.
pub fn finish(
    plan: &WorldPlan,
    scene: &Scene,
    store: &Store,
    verify: bool,
    control: &Control,
) -> Result<Manifest, WorldError> {
    let found = status(plan, scene, store, verify, control)?;
    let world = store.within(plan.hash());
    let runtime = world.runtime();
    if let Some((first, reason)) = found.damaged.first() {
        let removed = AtomicU64::new(0);
        for (address, _) in &found.damaged {
            runtime.block_on(world.remove(&tile_name(*address)))?;
            removed.fetch_add(1, Ordering::Relaxed);
        }
        return Err(WorldError::Damaged {
            damaged: removed.into_inner(),
            tiles: found.tiles,
            first: first.to_string(),
            reason: reason.clone(),
        });
    }
    if let Some(first) = found.missing.first() {
        return Err(WorldError::Incomplete {
            missing: found.tiles - found.present,
            tiles: found.tiles,
            first: first.to_string(),
        });
    }
    let manifest = Manifest {
        tiles: found.tiles,
        bytes: found.bytes,
        plan: plan.clone(),
    };
    let mut text = serde_json::to_string_pretty(&manifest)
        .map_err(|error| WorldError::plan("manifest.json", error.to_string()))?;
    text.push('\n');
    if verify {
        runtime.block_on(mend_shared(plan, scene, &world))?;
    }
    runtime.block_on(put_right(&world, "manifest.json", text.into()))?;
    Ok(manifest)
}
