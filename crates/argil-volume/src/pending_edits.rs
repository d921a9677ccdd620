//! The CPU's side of edits in place.

use crate::TooFarError;
use crate::VoxelGrid;
use argil_field::{IncrementalProgram, PartGrid, Program};
use argil_math::Aabb;
use glam::Vec3;
use std::any::Any;

/// What earlier edits left to do, for a representation that can change in place. The samples may be on either
/// device.
pub trait PendingEdits: std::fmt::Debug + Any + Send + Sync {
    /// Returns the voxel grid.
    fn voxel_grid(&self) -> &VoxelGrid;

    /// Returns the margins that dirty boxes must have: the stored band, and the distance up to which cells store
    /// bounds.
    fn margins(&self, program: &Program) -> [f32; 2];

    /// Returns the smallest margins that suffice. A world that grows needs a little more over time, and
    /// [`PendingEdits::margins`] includes it.
    fn min_margins(&self, program: &Program) -> [f32; 2];

    /// Returns the grid of parts for an [`IncrementalProgram`].
    fn parts(&self, program: &Program) -> PartGrid;

    /// Grows the grid to contain a solid, with the same voxels. Returns whether it grew.
    ///
    /// # Errors
    /// If the solid is too far away.
    fn grow_to(&mut self, solid: Aabb) -> Result<bool, TooFarError>;

    /// Adds the blocks that the last edits of `live` touched. `boxes` are pairs of dirty box and influence box.
    /// Returns false if they touch so much that a rebuild is as fast.
    fn merge(&mut self, live: &IncrementalProgram, boxes: &[[Aabb; 2]]) -> bool;

    /// Sorts the work by its distance to a point, and cuts it into small batches.
    fn sort_by_distance(&mut self, eye: Vec3);

    /// Returns the number of blocks that remain.
    fn remaining_blocks(&self) -> u64;

    /// Drops all remaining work.
    fn clear(&mut self);
}
