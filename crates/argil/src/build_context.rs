//! What a representation is built from.

use crate::Engine;
use argil_field::Program;
use argil_scene::Scene;

/// What a representation is built from.
pub(crate) struct BuildContext<'a> {
    pub engine: &'a Engine,
    pub scene: &'a Scene,
    pub program: &'a Program,
}
