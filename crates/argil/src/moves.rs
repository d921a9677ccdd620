//! Which brushes the last edits moved.

use crate::scene_state::SceneState;
use argil_field::{BrushMotion, IncrementalProgram, MovedBrush};
use std::collections::VecDeque;

/// Edits that are kept. A frame that is older shows the camera's motion alone.
const KEPT_EDITS: usize = 16;

/// The brushes that each of the last edits moved.
#[derive(Debug, Default)]
pub(crate) struct Moves {
    /// With the state before each edit.
    edits: VecDeque<(SceneState, Vec<MovedBrush>)>,
}

impl Moves {
    /// Notes an edit, and the brushes that it moved, if these are known. Otherwise, no frame before it can be followed.
    pub(crate) fn note(&mut self, before: SceneState, moved: Option<Vec<MovedBrush>>) {
        let Some(moved) = moved else {
            self.edits.clear();
            return;
        };
        if self.edits.len() == KEPT_EDITS {
            self.edits.pop_front();
        }
        self.edits.push_back((before, moved));
    }

    /// Returns what moved since a state, with what is near it now.
    pub(crate) fn since(
        &self,
        before: SceneState,
        live: &IncrementalProgram,
    ) -> Option<BrushMotion> {
        let first = self.edits.iter().position(|(state, _)| *state == before)?;
        let edits = self.edits.range(first..);
        live.motion_of(edits.map(|(_, moved)| &moved[..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_scene::{Edit, Modifier, Scene, Shape};

    #[test]
    fn no_frame_before_an_unknown_motion_is_followed() -> Result<(), Box<dyn std::error::Error>> {
        let mut scene = Scene::new();
        let node = scene.push(Shape::sphere(0.5))?.node;
        let parts = argil_field::PartGrid {
            corner: glam::Vec3::splat(-1.0),
            edge: 0.5,
            far: 1.0,
            base: 2.0,
        };
        let mut live = IncrementalProgram::new(&scene, parts)?;
        let start = scene.change_count();
        let by = Modifier::Translate {
            by: [0.1, 0.0, 0.0],
        };
        scene.apply(Edit::Transform { node, by })?;
        live.update(&scene, scene.changes_since(start).expect("changes"))?;
        let mut moves = Moves::default();
        moves.note((1, 0), live.moved());
        assert!(moves.since((1, 0), &live).is_some());
        moves.note((1, 1), None);
        moves.note((1, 2), live.moved());
        assert!(moves.since((1, 2), &live).is_some());
        for before in [(1, 0), (1, 1)] {
            assert!(moves.since(before, &live).is_none(), "{before:?}");
        }
        Ok(())
    }
}
