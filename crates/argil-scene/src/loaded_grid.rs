//! The samples that a shape reads from a file.

use crate::SampledGrid;
use argil_math::Aabb;
use std::sync::Arc;

/// The distances of a mesh, if they are loaded. Any two are equal, because the file's name determines them.
#[derive(Clone, Debug, Default)]
pub struct LoadedGrid(pub Option<Arc<SampledGrid>>);

impl PartialEq for LoadedGrid {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LoadedGrid {
    /// Returns the box of the solid, or an empty box if it is not loaded.
    #[doc(hidden)]
    pub fn solid(&self) -> Aabb {
        self.0.as_ref().map_or(Aabb::EMPTY, |grid| grid.solid())
    }

    /// Returns the samples as interpreters read them, or none if they are not loaded.
    #[doc(hidden)]
    pub fn words(&self) -> &[f32] {
        self.0.as_ref().map_or(&[], |grid| grid.words())
    }
}
