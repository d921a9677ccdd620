//! Reads finished worlds.

use crate::delta::{MOST_DELTAS, apply_delta, delta_name, is_delta};
use crate::limits::{MAX_MESH_BYTES, MAX_TEXT_BYTES};
use crate::stored_tiles::{EventualTiles, StoredTiles};
use crate::tile_cache_options::TileCacheOptions;
use crate::{Manifest, Store, TileCache, WorldError, WorldPlan};
use argil::scene::Scene;
use argil::volume::{TileAddress, TileSource};
use argil::{Engine, LevelsOptions, World};
use bytes::Bytes;
use std::sync::Arc;

/// How a world takes its pages from a store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadMode {
    /// Whoever asks for pages waits until they were fetched. Where the store lacks a tile, rays see what is coarser.
    Wait,
    /// As [`ReadMode::Wait`], but what the store lacks is baked.
    WaitOrBake,
    /// Tiles are fetched in the background. What was not fetched yet stays coarse, and is asked for again.
    Eventually,
}

/// A world in a store.
#[derive(Clone, Debug)]
pub struct StoredWorld {
    plan: WorldPlan,
    /// The plan's scene, and the same with all edits.
    planned: Scene,
    scene: Scene,
    /// Files of edits that the scene has, with their places.
    deltas: Vec<(String, Bytes)>,
    world: Store,
    tiles: Arc<StoredTiles>,
}

impl StoredWorld {
    /// Opens a finished world by the address of its manifest, or of its folder.
    ///
    /// # Errors
    /// If there is no manifest, it is of another version, or the scene cannot be read.
    pub fn open(address: &str, options: &TileCacheOptions) -> Result<Self, WorldError> {
        let folder = address.trim_end_matches('/');
        let folder = folder.strip_suffix("manifest.json").unwrap_or(folder);
        let folder = folder.trim_end_matches('/');
        if !folder.contains("://") && !std::path::Path::new(folder).is_dir() {
            let reason =
                "there is no world: expected the folder with manifest.json, or its address";
            return Err(WorldError::plan(folder, reason));
        }
        let world = Store::open(if folder.is_empty() { "." } else { folder })?;
        let text = world
            .runtime()
            .block_on(world.get("manifest.json", MAX_TEXT_BYTES))?;
        let text = text.ok_or_else(|| {
            let reason = "there is no manifest.json: finish the world with `argil world finish`";
            WorldError::plan(folder, reason)
        })?;
        let plan = Manifest::from_bytes(&text, &format!("{folder}/manifest.json"))?.plan;
        let mut scene = plan.scene()?;
        for (index, name) in plan.mesh_names().enumerate() {
            let bytes = world.runtime().block_on(world.get(&name, MAX_MESH_BYTES))?;
            plan.set_mesh(&mut scene, index, &bytes.unwrap_or_default(), folder)?;
        }
        let mut opened = Self::of(plan, scene, world, options)?;
        opened.read_deltas()?;
        Ok(opened)
    }

    /// Opens what a store has of a scene's world, finished or not.
    ///
    /// # Errors
    /// If the scene is not the plan's.
    pub fn of_scene(
        plan: &WorldPlan,
        scene: &Scene,
        store: &Store,
        options: &TileCacheOptions,
    ) -> Result<Self, WorldError> {
        let world = store.within(plan.hash());
        Self::of(plan.clone(), scene.clone(), world, options)
    }

    fn of(
        plan: WorldPlan,
        scene: Scene,
        world: Store,
        options: &TileCacheOptions,
    ) -> Result<Self, WorldError> {
        let cache = TileCache::new(&plan, &scene, options.memory_bytes)?;
        let tiles = StoredTiles::new(world.clone(), plan.hash(), cache, options);
        Ok(Self {
            plan,
            planned: scene.clone(),
            scene,
            deltas: Vec::new(),
            world,
            tiles: Arc::new(tiles),
        })
    }

    /// Whether anybody has begun to bake the world into the store.
    ///
    /// # Errors
    /// If the store fails again and again.
    pub fn is_begun(&self) -> Result<bool, WorldError> {
        let found = self
            .world
            .runtime()
            .block_on(self.world.find("plan.json", MAX_TEXT_BYTES))?;
        Ok(found.is_some())
    }

    /// Returns the plan.
    pub fn plan(&self) -> &WorldPlan {
        &self.plan
    }

    /// Returns the scene, with its meshes and all saved edits.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the options of levels that have the world's voxels.
    pub fn levels_options(&self) -> LevelsOptions {
        self.plan.levels_options()
    }

    /// Builds the world on an engine, with levels whose pages come from here. Those that saved edits reach come from the field.
    /// Returns it with the scene that it follows: later edits are made there, and [applied](World::apply). An edit that rebuilds
    /// the world, such as one outside of its box, takes all pages from the field.
    ///
    /// # Errors
    /// If the scene cannot be built.
    pub fn build(
        &self,
        engine: &Engine,
        options: LevelsOptions,
        mode: ReadMode,
    ) -> Result<(Scene, World), WorldError> {
        let mut scene = self.planned.clone();
        let built = engine.build(&scene)?;
        let mut world = built.with_representation(options)?;
        world.set_tile_source(self.source(mode), mode == ReadMode::WaitOrBake);
        for (place, bytes) in &self.deltas {
            apply_delta(&mut scene, bytes, place)?;
        }
        if !self.deltas.is_empty() {
            world.apply(&scene)?;
        }
        Ok((scene, world))
    }

    /// Returns the tiles, for a world of the plan's scene: see [`StoredWorld::build`].
    pub fn source(&self, mode: ReadMode) -> Arc<dyn TileSource> {
        match mode {
            ReadMode::Wait | ReadMode::WaitOrBake => self.tiles.clone(),
            ReadMode::Eventually => Arc::new(EventualTiles(self.tiles.clone())),
        }
    }

    /// Returns the plan's scene, with its meshes and without the saved edits.
    pub fn planned_scene(&self) -> &Scene {
        &self.planned
    }

    /// Returns the texts of all saved edits with the places of their files, in order.
    pub fn deltas(&self) -> impl ExactSizeIterator<Item = (&str, &[u8])> {
        self.deltas
            .iter()
            .map(|(place, bytes)| (&**place, &**bytes))
    }

    fn next_delta(&self) -> String {
        delta_name(self.deltas.len() as u32 + 1)
    }

    fn place_of(&self, name: &str) -> String {
        format!("{}/{name}", self.world.place().trim_end_matches('/'))
    }

    /// Performs the edits that were saved since.
    fn read_deltas(&mut self) -> Result<(), WorldError> {
        while self.deltas.len() < MOST_DELTAS && self.read_delta()? {}
        Ok(())
    }

    fn read_delta(&mut self) -> Result<bool, WorldError> {
        let name = self.next_delta();
        // All of them are in memory.
        let held: u64 = self
            .deltas
            .iter()
            .map(|(_, bytes)| bytes.len() as u64)
            .sum();
        let find = self.world.find(&name, MAX_TEXT_BYTES.saturating_sub(held));
        let found = self.world.runtime().block_on(find)?;
        let Some(bytes) = found.filter(|bytes| is_delta(bytes)) else {
            return Ok(false);
        };
        let place = self.place_of(&name);
        apply_delta(&mut self.scene, &bytes, &place)?;
        self.deltas.push((place, bytes));
        Ok(true)
    }

    /// Saves edits beside the world, as lines that `argil edit` reads. They are performed after all others, also those that
    /// somebody else saved in the meantime. Returns the name of the new object.
    ///
    /// # Errors
    /// If a line cannot be read or performed, or the store cannot be written. Nothing is saved then.
    pub fn save_edits(&mut self, lines: &str, place: &str) -> Result<String, WorldError> {
        while self.deltas.len() < MOST_DELTAS {
            let mut scene = self.scene.clone();
            if apply_delta(&mut scene, lines.as_bytes(), place)? == 0 {
                return Err(WorldError::plan(place, "there are no edits"));
            }
            let name = self.next_delta();
            let bytes = Bytes::from(lines.to_owned());
            let put = self.world.put_new(&name, bytes.clone());
            if self.world.runtime().block_on(put)? {
                self.scene = scene;
                self.deltas.push((self.place_of(&name), bytes));
                return Ok(name);
            }
            if !self.read_delta()? {
                let reason = "it is there, and cannot be read: remove it, and save again";
                return Err(WorldError::plan(self.place_of(&name), reason));
            }
        }
        let reason =
            format!("the world has {MOST_DELTAS} files of edits, the most: plan a new one");
        Err(WorldError::plan(self.place_of("edits"), reason))
    }

    /// Returns the number of requests that the store answered with parts of tiles, and their bytes.
    pub fn fetched(&self) -> [u64; 2] {
        self.tiles.fetched()
    }

    /// Returns the tiles that were missing or damaged when they were asked for last, and why.
    pub fn problems(&self) -> Vec<(TileAddress, String)> {
        self.tiles.cache.problems()
    }
}
