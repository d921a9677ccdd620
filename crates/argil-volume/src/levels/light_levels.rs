//! Coarse levels around sparse bricks, from which light reads the distances that bricks do not store.
//!
//! *Theory.* A brick stores distances in its own cell, and a cell without one only a bound of few voxels. Light needs
//! distances as far as shadows and occlusion reach, with a relative error: a shadow depends on a distance through the
//! way to it. The finest level that has a brick at a point gives that (see `light.rs`). These levels are coarser than
//! the bricks, down to a few cells for the whole scene, and have all bricks that they can have.
//!
//! *Practice.* Voxels four times as long as those of bricks cost 7 % of their memory, and voxels twice as long 30 %,
//! for nearly the same image.

use super::layout::LevelsLayout;
use super::pending::LevelsPendingEdits;
use super::tree::Levels;
use crate::{BrickLayout, BrickSettings, BricksError, PendingEdits};
use argil_field::{IncrementalProgram, Program};
use glam::Vec3;
use std::sync::Arc;

/// By how much a voxel of the finest level is longer than that of bricks, as a power of two.
const FINEST_LOG2: u32 = 2;
/// Maximum bytes. What does not fit stays coarser.
const MAX_BYTES: u64 = 256 << 20;

/// The levels from which the light of sparse bricks reads distances. They follow edits.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{BrickLayout, BrickSettings, LightLevels, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 256)?;
/// let bricks = BrickLayout::new(grid, &BrickSettings::default())?;
/// let light = LightLevels::bake(&program, &bricks)?;
/// assert!(light.levels().brick_count() > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LightLevels {
    bricks: BrickLayout,
    levels: Arc<Levels>,
    edits: LevelsPendingEdits,
}

impl LightLevels {
    /// Bakes the levels for bricks of a layout, all of them.
    ///
    /// # Errors
    /// If the coarsest level alone exceeds 256 MiB.
    pub fn bake(program: &Program, bricks: &BrickLayout) -> Result<Self, BricksError> {
        let settings = BrickSettings::default();
        let own = LevelsLayout::new(bricks.voxel_grid, &settings)?;
        let layout = LevelsLayout::new(own.level(FINEST_LOG2).voxel_grid, &settings)?;
        let mut levels = Levels::bake(program, layout, MAX_BYTES)?;
        levels.refine_around(program, Vec3::ZERO, 0.0);
        Ok(Self {
            bricks: *bricks,
            levels: Arc::new(levels),
            edits: LevelsPendingEdits::of(layout),
        })
    }

    /// Returns the levels. Samples have 16 bits.
    pub fn levels(&self) -> &Arc<Levels> {
        &self.levels
    }

    /// Notes what a program's last update changed. Returns whether the levels can follow it: if not, bake them again.
    pub fn note_edit(&mut self, live: &IncrementalProgram, bricks: &BrickLayout) -> bool {
        self.bricks == *bricks && self.edits.merge(live, &[])
    }

    /// Bakes again what edits changed, and what became possible by them.
    ///
    /// # Errors
    /// If the coarsest level alone exceeds 256 MiB.
    pub fn update(
        &mut self,
        live: &IncrementalProgram,
        program: &Program,
    ) -> Result<(), BricksError> {
        if self.edits.is_done() {
            return Ok(());
        }
        let levels = Arc::make_mut(&mut self.levels);
        levels.edit(live, &mut self.edits, None)?;
        levels.refine_around(program, Vec3::ZERO, 0.0);
        Ok(())
    }
}
