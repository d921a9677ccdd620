//! The samples that a shape reads from a file.

use crate::SampledGrid;
use argil_math::Aabb;
use std::sync::Arc;

/// The distances of a mesh, where it is loaded. Any two are equal: what they are follows from the file's name.
#[derive(Clone, Debug, Default)]
pub struct LoadedGrid(pub Option<Arc<SampledGrid>>);

impl PartialEq for LoadedGrid {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl LoadedGrid {
    /// A box around the solid, as far as it is known: its samples'; empty where it is not loaded.
    #[doc(hidden)]
    pub fn region(&self) -> Aabb {
        self.0.as_ref().map_or(Aabb::EMPTY, |grid| grid.region())
    }

    /// The samples as interpreters read them; none where it is not loaded.
    #[doc(hidden)]
    pub fn words(&self) -> &[f32] {
        self.0.as_ref().map_or(&[], |grid| grid.words())
    }
}
