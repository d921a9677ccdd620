//! What following edits with sparse bricks takes, on either device.

use super::{BrickLayout, EditQueue};
use crate::{PendingEdits, TooFarError, VoxelGrid};
use argil_field::{IncrementalProgram, PartGrid, Program};
use argil_math::Aabb;
use glam::Vec3;
use std::any::Any;

/// How sparse bricks lie, and what edits have left to be done.
#[derive(Debug)]
pub struct BrickPendingEdits {
    /// How they lie.
    pub layout: BrickLayout,
    /// What is left.
    pub queue: EditQueue,
}

impl BrickPendingEdits {
    /// Of bricks that lie so, with nothing to be done.
    pub fn of(layout: BrickLayout) -> Self {
        Self {
            layout,
            queue: EditQueue::default(),
        }
    }

    /// If edits are of sparse bricks, these.
    pub fn among(edits: &dyn PendingEdits) -> Option<&Self> {
        (edits as &dyn Any).downcast_ref()
    }

    /// The same, to be worked on.
    pub fn among_mut(edits: &mut dyn PendingEdits) -> Option<&mut Self> {
        (edits as &mut dyn Any).downcast_mut()
    }
}

impl PendingEdits for BrickPendingEdits {
    fn voxel_grid(&self) -> &VoxelGrid {
        &self.layout.voxel_grid
    }

    fn margins(&self, program: &Program) -> [f32; 2] {
        self.layout.margins(program)
    }

    fn min_margins(&self, program: &Program) -> [f32; 2] {
        self.layout.min_margins(program)
    }

    fn parts(&self, program: &Program) -> PartGrid {
        self.layout.parts(program)
    }

    fn grow_to(&mut self, solid: Aabb) -> Result<bool, TooFarError> {
        let grown = self.layout.grown_to(solid)?;
        let is_larger = grown != self.layout;
        self.layout = grown;
        Ok(is_larger)
    }

    fn merge(&mut self, live: &IncrementalProgram, boxes: &[[Aabb; 2]]) -> bool {
        let Some(work) = EditQueue::new(&self.layout, live, boxes) else {
            return false;
        };
        let left = std::mem::replace(&mut self.queue, work);
        self.queue.merge(&self.layout, live, left);
        true
    }

    fn sort_by_distance(&mut self, eye: Vec3) {
        self.queue.sort_by_distance(&self.layout, eye);
    }

    fn remaining_blocks(&self) -> u64 {
        self.queue.blocks()
    }

    fn clear(&mut self) {
        self.queue = EditQueue::default();
    }
}
