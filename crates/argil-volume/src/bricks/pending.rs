//! The state of sparse bricks for edits in place, on either device.

use super::{BrickLayout, EditQueue};
use crate::{PendingEdits, TooFarError, VoxelGrid};
use argil_field::{IncrementalProgram, PartGrid, Program};
use argil_math::Aabb;
use glam::Vec3;
use std::any::Any;

/// The layout of sparse bricks, and what edits left to do.
#[derive(Debug)]
pub struct BrickPendingEdits {
    /// The layout.
    pub layout: BrickLayout,
    /// The remaining work.
    pub queue: EditQueue,
    /// The layout when work was last added.
    merged: BrickLayout,
}

impl BrickPendingEdits {
    /// Creates the state of bricks with a layout, with nothing to do.
    pub fn of(layout: BrickLayout) -> Self {
        Self {
            layout,
            merged: layout,
            queue: EditQueue::default(),
        }
    }

    /// Returns edits of sparse bricks, if these are.
    pub fn downcast_ref(edits: &dyn PendingEdits) -> Option<&Self> {
        (edits as &dyn Any).downcast_ref()
    }

    /// Returns edits of sparse bricks, to change them.
    pub fn downcast_mut(edits: &mut dyn PendingEdits) -> Option<&mut Self> {
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
        let Some(work) = EditQueue::new(&self.layout, &self.merged, live, boxes) else {
            return false;
        };
        self.merged = self.layout;
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
