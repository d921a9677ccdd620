//! Which brushes the last edits moved.

use argil_field::{BrushMotion, IncrementalProgram, MovedBrush};
use std::collections::VecDeque;

/// Edits that are kept. A frame that is older shows the camera's motion alone.
const KEPT_EDITS: usize = 16;

/// The scene, and the number of its changes that a world has applied.
pub(crate) type SceneState = (u64, usize);

/// The brushes that each of the last edits moved.
#[derive(Debug, Default)]
pub(crate) struct Moves {
    /// With the state before each edit.
    edits: VecDeque<(SceneState, Vec<MovedBrush>)>,
}

impl Moves {
    /// Notes an edit.
    pub(crate) fn note(&mut self, before: SceneState, moved: Vec<MovedBrush>) {
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
