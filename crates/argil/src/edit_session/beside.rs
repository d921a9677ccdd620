//! What edits need of a world that is built on another thread, beside the one that is shown.

use super::EditSession;
use crate::BuildError;
use crate::device::{AnyDevice, Device};
use crate::scene_state::SceneState;
use argil_field::{IncrementalProgram, Program};
use argil_scene::{MarginRequest, Scene};
use argil_volume::{EditStats, PendingEdits};

impl EditSession {
    /// Prepares to change in place what was built on another thread: what the first edit would otherwise do.
    ///
    /// # Errors
    /// If the scene exceeds a limit of edits in place.
    pub(crate) fn prepare(
        &mut self,
        scene: &Scene,
        edits: Box<dyn PendingEdits>,
        program: &Program,
    ) -> Result<(), BuildError> {
        let live = IncrementalProgram::new(scene, edits.parts(program))?;
        self.program = live.has_same_bounds_as(program).then_some(live);
        self.edits = Some(edits);
        Ok(())
    }

    /// Makes a scene record edits with the margins that are needed after all of its changes, if the representation can
    /// change in place. `lowered` is the program of the world, as long as nothing has changed.
    pub(crate) fn request_margins(
        &self,
        scene: &Scene,
        lowered: Option<&Program>,
    ) -> Option<MarginRequest> {
        let (edits, tables) = (self.edits.as_ref()?, self.tables().or(lowered)?);
        Some(scene.request_margins(edits.margins(tables)))
    }

    /// Makes a scene record edits with the margins that are needed, unless it does.
    pub(crate) fn ensure_margins(&mut self, scene: &Scene, lowered: Option<&Program>) {
        if self.watch.is_none() && self.identity == scene.id() {
            self.watch = self.request_margins(scene, lowered);
        }
    }

    /// Takes the request for margins that was made while a world was built on another thread.
    pub(crate) fn set_margin_request(&mut self, request: Option<MarginRequest>) {
        self.watch = request;
        if let (Some(request), Some(edits), Some(tables)) =
            (&self.watch, &self.edits, self.tables())
        {
            request.set(edits.margins(tables));
        }
    }

    /// Follows another scene from a state on, whose copy the world was built from.
    pub(crate) fn follow_instead(&mut self, state: SceneState, request: Option<MarginRequest>) {
        (self.identity, self.seen_changes) = state;
        self.set_margin_request(request);
    }

    /// Counts what earlier edits did as well.
    pub(crate) fn add_stats(&mut self, before: EditStats) {
        self.stats += before;
    }

    /// Lets a device follow the program as it is now.
    ///
    /// # Errors
    /// If the device cannot run it.
    pub(crate) fn follow_program(&self, device: &mut AnyDevice) -> Result<(), BuildError> {
        match &self.program {
            Some(live) => device.follow_program(live),
            None => Ok(()),
        }
    }
}
