//! Bakes the tiles of a shard.

use crate::plan::mesh_bytes;
use crate::{Shard, Store, WorldError, WorldPlan, tile_name};
use argil::math::Control;
use argil::scene::Scene;
use argil::volume::TileAddress;
use bytes::Bytes;
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use tokio::sync::Semaphore;

/// Tiles that are on their way to the store at once.
const IN_FLIGHT: usize = 16;

/// Tiles that a thread bakes one after another, because they share the way down from the root.
const NEIGHBORS: usize = 4;

/// What a worker did.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct BakeReport {
    /// Tiles of the shard.
    pub tiles: u64,
    /// Tiles that were there already, or that another worker put there first.
    pub present: u64,
    /// Tiles that this worker put into the store.
    pub baked: u64,
    /// Tiles that bounds did not rule out, and through which no surface passes. They are not stored.
    pub empty: u64,
    /// Bricks in the baked tiles.
    pub bricks: u64,
    /// Bytes of the baked tiles.
    pub bytes: u64,
    /// Milliseconds to find the tiles, and to bake them.
    pub plan_ms: f64,
    /// Milliseconds to bake tiles and to put them into the store.
    pub bake_ms: f64,
}

/// Bakes the tiles of a shard that a store lacks, on rayon's current threads. It can be stopped at any moment, and begun
/// again, and several workers can bake the same shard.
///
/// # Errors
/// If the scene is not the plan's, the store fails again and again, or the work was canceled. Tiles that were put into the
/// store stay there.
pub fn bake(
    plan: &WorldPlan,
    scene: &Scene,
    store: &Store,
    shard: Shard,
    control: &Control,
) -> Result<BakeReport, WorldError> {
    if shard.index >= shard.count {
        let Shard { index, count } = shard;
        return Err(WorldError::Shard { index, count });
    }
    let start = Instant::now();
    let world = store.within(plan.hash());
    let prepared = plan.prepare(scene)?;
    let baker = prepared.baker();
    control.begin("tiles", 0);
    let assigned = shard.part(&baker.candidates(control));
    let present = world.runtime().block_on(async {
        for (name, bytes) in shared(plan, scene) {
            world.put_new(&name, bytes).await?;
        }
        present_tiles(&world).await
    })?;
    let missing: Vec<TileAddress> = assigned
        .iter()
        .copied()
        .filter(|address| !present.contains(address))
        .collect();
    let plan_ms = start.elapsed().as_secs_f64() * 1e3;
    let begin = Instant::now();
    let job = Job {
        world: &world,
        key: plan.tile_key(),
        room: Arc::new(Semaphore::new(IN_FLIGHT)),
        failed: Arc::default(),
        counts: Arc::default(),
    };
    let empty = AtomicU64::new(0);
    control.begin("tiles", missing.len() as u64);
    missing.par_iter().with_min_len(NEIGHBORS).for_each_init(
        || baker.worker(),
        |worker, &address| {
            if !control.is_cancelled() && !job.has_failed() {
                let tile = worker.bake(address);
                if tile.page_count() == 0 {
                    empty.fetch_add(1, Ordering::Relaxed);
                } else {
                    job.put(&tile);
                }
                control.advance(1);
            }
        },
    );
    let [baked, others, bricks, bytes] = job.finish()?;
    if control.is_cancelled() {
        return Err(WorldError::Cancelled);
    }
    Ok(BakeReport {
        tiles: assigned.len() as u64,
        present: (assigned.len() - missing.len()) as u64 + others,
        baked,
        empty: empty.into_inner(),
        bricks,
        bytes,
        plan_ms,
        bake_ms: begin.elapsed().as_secs_f64() * 1e3,
    })
}

/// Returns the tiles that a store has.
pub(crate) async fn present_tiles(world: &Store) -> Result<FxHashSet<TileAddress>, WorldError> {
    let listed = world.list("tiles").await?;
    let parsed = listed.iter().filter_map(|(name, _)| name.parse().ok());
    Ok(parsed.collect())
}

/// Returns what all tiles share, with its names: the samples of meshes, and the plan.
pub(crate) fn shared(plan: &WorldPlan, scene: &Scene) -> impl Iterator<Item = (String, Bytes)> {
    let meshes = scene.loaded_meshes().into_iter().enumerate();
    let meshes =
        meshes.map(|(index, (_, _, grid))| (format!("meshes/{index}"), mesh_bytes(grid).into()));
    let manifest = ("plan.json".to_owned(), plan.to_json().into());
    meshes.chain(std::iter::once(manifest))
}

/// Counts: tiles that were put, and that others had put; bricks; bytes.
type Counts = [AtomicU64; 4];

struct Job<'a> {
    world: &'a Store,
    key: [u8; 32],
    /// How many more tiles may be on their way.
    room: Arc<Semaphore>,
    failed: Arc<Mutex<Option<WorldError>>>,
    counts: Arc<Counts>,
}

impl Job<'_> {
    fn has_failed(&self) -> bool {
        let failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.is_some()
    }

    /// Sends a tile on its way, as soon as there is room.
    fn put(&self, tile: &argil::volume::Tile) {
        let bytes: Bytes = tile.to_bytes(&self.key).into();
        let (name, bricks) = (tile_name(tile.address()), tile.brick_count() as u64);
        let runtime = self.world.runtime();
        let Ok(permit) = runtime.block_on(self.room.clone().acquire_owned()) else {
            return;
        };
        let (world, failed, counts) =
            (self.world.clone(), self.failed.clone(), self.counts.clone());
        runtime.spawn(async move {
            let length = bytes.len() as u64;
            let add = |index: usize, more: u64| counts[index].fetch_add(more, Ordering::Relaxed);
            match world.put_new(&name, bytes).await {
                Ok(true) => {
                    add(0, 1);
                    add(2, bricks);
                    add(3, length);
                }
                Ok(false) => {
                    add(1, 1);
                }
                Err(error) => {
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    failed.get_or_insert(error);
                }
            }
            drop(permit);
        });
    }

    /// Waits for what is on its way. Returns the counts.
    fn finish(self) -> Result<[u64; 4], WorldError> {
        // Whoever holds all permits is alone.
        let all = self.room.acquire_many(IN_FLIGHT as u32);
        let _ = self.world.runtime().block_on(all);
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        match failed.take() {
            Some(error) => Err(error),
            None => Ok(self
                .counts
                .each_ref()
                .map(|count| count.load(Ordering::Relaxed))),
        }
    }
}
