//! What following edits with sparse bricks takes, on either device.

use super::{BrickLayout, EditWork};
use crate::{Edits, Lattice, TooFarError};
use argil_field::{LiveProgram, Parts, Program};
use argil_math::Aabb;
use glam::Vec3;
use std::any::Any;

/// How sparse bricks lie, and what edits have left to be done.
pub struct BrickEdits {
    /// How they lie.
    pub layout: BrickLayout,
    /// What is left.
    pub work: EditWork,
}

impl BrickEdits {
    /// Of bricks that lie so, with nothing to be done.
    pub fn of(layout: BrickLayout) -> Self {
        Self {
            layout,
            work: EditWork::default(),
        }
    }

    /// If edits are of sparse bricks, these.
    pub fn among(edits: &dyn Edits) -> Option<&Self> {
        (edits as &dyn Any).downcast_ref()
    }

    /// The same, to be worked on.
    pub fn among_mut(edits: &mut dyn Edits) -> Option<&mut Self> {
        (edits as &mut dyn Any).downcast_mut()
    }
}

impl Edits for BrickEdits {
    fn lattice(&self) -> &Lattice {
        &self.layout.lattice
    }

    fn bands(&self, program: &Program) -> [f32; 2] {
        self.layout.bands(program)
    }

    fn least_bands(&self, program: &Program) -> [f32; 2] {
        self.layout.least_bands(program)
    }

    fn parts(&self, program: &Program) -> Parts {
        self.layout.parts(program)
    }

    fn grow_to(&mut self, solid: Aabb) -> Result<bool, TooFarError> {
        let grown = self.layout.grown_to(solid)?;
        let is_larger = grown != self.layout;
        self.layout = grown;
        Ok(is_larger)
    }

    fn take_on(&mut self, live: &LiveProgram, boxes: &[[Aabb; 2]]) -> bool {
        let Some(work) = EditWork::new(&self.layout, live, boxes) else {
            return false;
        };
        let left = std::mem::replace(&mut self.work, work);
        self.work.take_on(&self.layout, live, left);
        true
    }

    fn sort_by_distance(&mut self, eye: Vec3) {
        self.work.sort_by_distance(&self.layout, eye);
    }

    fn blocks_left(&self) -> u64 {
        self.work.blocks()
    }

    fn clear(&mut self) {
        self.work = EditWork::default();
    }
}
