//! States of scenes that worlds follow.

use argil_scene::Scene;

/// A scene's id, and the number of its changes that a world has applied.
pub(crate) type SceneState = (u64, usize);

/// Returns the state of a scene with all of its changes.
pub(crate) fn state_of(scene: &Scene) -> SceneState {
    (scene.id(), scene.change_count())
}
