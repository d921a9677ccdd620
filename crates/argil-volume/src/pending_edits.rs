//! What following edits takes on the CPU's side, of a representation that is changed in place.

use crate::TooFarError;
use crate::VoxelGrid;
use argil_field::{IncrementalProgram, PartGrid, Program};
use argil_math::Aabb;
use glam::Vec3;
use std::any::Any;

/// Following edits with a representation, wherever its texels are: how it lies, how far edits must tell what they change, and what they
/// have left to be done. Each that is changed in place has its own.
pub trait PendingEdits: std::fmt::Debug + Any + Send + Sync {
    /// Where the voxels lie.
    fn voxel_grid(&self) -> &VoxelGrid;

    /// The distances up to which edits must tell their boxes: within the stored band, and where bounds alone are kept.
    fn margins(&self, program: &Program) -> [f32; 2];

    /// The least of them that will do. A world that grows needs a little more than before, which [`PendingEdits::margins`] has room for.
    fn min_margins(&self, program: &Program) -> [f32; 2];

    /// The parts in which a [`IncrementalProgram`] tells lists.
    fn parts(&self, program: &Program) -> PartGrid;

    /// Lies over a box that holds a solid too, of the same voxels; whether it is larger than before.
    ///
    /// # Errors
    /// If that is too far away.
    fn grow_to(&mut self, solid: Aabb) -> Result<bool, TooFarError>;

    /// Takes on what edits that `live` has just followed have touched: of each the boxes outside of which nothing changed within
    /// either band. Whether it did: not where they hold so much that it is to be baked anew.
    fn merge(&mut self, live: &IncrementalProgram, boxes: &[[Aabb; 2]]) -> bool;

    /// Puts what is near a point first, and cuts it into what can be done in a short time.
    fn sort_by_distance(&mut self, eye: Vec3);

    /// Blocks of 4³ cells that are left to be done.
    fn remaining_blocks(&self) -> u64;

    /// Leaves undone what is left.
    fn clear(&mut self);
}
