//! Takes over what was built on another thread.

use super::World;
#[cfg(not(target_arch = "wasm32"))]
use super::background_rebuild::{BackgroundRebuild, RebuildOrder, RebuiltWorld};
#[cfg(not(target_arch = "wasm32"))]
use crate::device::Device;
#[cfg(not(target_arch = "wasm32"))]
use crate::program_cache::ProgramCache;
use crate::{BuildError, EditReport, RebuildReason};
#[cfg(not(target_arch = "wasm32"))]
use argil_field::Program;
#[cfg(not(target_arch = "wasm32"))]
use argil_math::Aabb;
use argil_scene::Scene;
#[cfg(not(target_arch = "wasm32"))]
use std::sync::{OnceLock, atomic::AtomicU32};
use web_time::Instant;

/// A call waits for a rebuild if the one before took no more than this share of its budget.
#[cfg(not(target_arch = "wasm32"))]
const SHARE_OF_BUDGET: f64 = 0.25;

impl World {
    /// Whether the world is being built again on another thread, and shows its scene as it was. [`World::apply_within`] starts that
    /// where an edit cannot be applied in place, and takes the new world over once it is there. Until then, volumes and pictures have the
    /// old shapes, while [`World::query`] and materials may be new. A page has no threads, and never does this.
    ///
    /// ```
    /// use argil::prelude::*;
    /// use std::time::Duration;
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let mut world = Engine::cpu().build(&scene)?.dense(64)?;
    /// scene.push(Shape::sphere(0.2).at([0.4, 0.0, 0.0]))?;
    /// while world.apply_within(&scene, EditBudget::new(1.0))?.remaining_blocks > 0 {
    ///     // Frames of a game.
    ///     std::thread::sleep(Duration::from_millis(1));
    /// }
    /// assert!(!world.is_rebuilding());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_rebuilding(&self) -> bool {
        #[cfg(not(target_arch = "wasm32"))]
        return self.rebuild.is_some();
        #[cfg(target_arch = "wasm32")]
        false
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl World {
    /// Returns the number of blocks that remain to be rebuilt, which is not 0 while the world is being rebuilt.
    pub(crate) fn remaining_blocks(&self) -> u64 {
        let blocks = self.edits.remaining_blocks();
        blocks.max(u64::from(self.is_rebuilding()))
    }

    /// Returns what a call within a budget returns while the world is being built again on another thread.
    pub(super) fn report_of_rebuild(
        &mut self,
        scene: &Scene,
        start: Instant,
    ) -> Option<EditReport> {
        let rebuild = self
            .rebuild
            .as_mut()
            .filter(|running| !running.is_finished())?;
        if self.engine.control.is_cancelled() {
            rebuild.cancel();
        }
        rebuild.note_scene(scene);
        Some(rebuild.report(self.edits.remaining_blocks(), start))
    }

    /// Starts to build the world again on another thread. Waits for it as long as a budget lasts, if it seems to be enough. Returns
    /// the report of the call, or `None` if the world is to be built on this thread.
    pub(super) fn rebuild_beside(
        &mut self,
        scene: &Scene,
        reason: RebuildReason,
        (max_ms, start): (f64, Instant),
    ) -> Result<Option<EditReport>, BuildError> {
        let fits = self.rebuild_ms <= SHARE_OF_BUDGET * max_ms;
        let voxel_grid = self.device.voxel_grid();
        // A program alone is ready sooner than a thread.
        let is_here = fits && (voxel_grid.is_none() || max_ms == f64::INFINITY);
        if is_here || self.lacks_room_beside || self.device.is_specialized() {
            return Ok(None);
        }
        if self.edits.tables().is_some() {
            // Queries see the new scene. So does what evaluates the field on a device.
            self.forget_program();
            self.edits.follow_program(&mut self.device)?;
        }
        let order = RebuildOrder {
            engine: self.engine.clone(),
            device: self.device.beside()?,
            target: (self.representation, voxel_grid),
            reason,
            is_lit: self.light.is_baked(),
            margins: self.edits.request_margins(scene, self.known_program()),
        };
        let Some(rebuild) = BackgroundRebuild::start(order, scene) else {
            return Ok(None);
        };
        let is_finished = fits && rebuild.is_finished_within(max_ms, start);
        let report = rebuild.report(self.edits.remaining_blocks(), start);
        self.rebuild = Some(rebuild);
        if is_finished && let Some(reason) = self.take_over_rebuild(scene)? {
            return Ok(Some(EditReport::of_rebuild(reason, start)));
        }
        Ok(Some(report))
    }

    /// Returns the program, if nothing has changed since the world was built.
    fn known_program(&self) -> Option<&Program> {
        self.program.get().map(|lowered| &lowered.program)
    }

    /// Stops a rebuild on another thread.
    pub(super) fn stop_rebuild(&mut self) {
        self.rebuild = None;
    }

    /// Takes over what another thread has built, and waits for it if it is not finished. Returns the reason of the rebuild, if there
    /// was one.
    pub(super) fn take_over_rebuild(
        &mut self,
        scene: &Scene,
    ) -> Result<Option<RebuildReason>, BuildError> {
        let Some(rebuild) = self.rebuild.take() else {
            return Ok(None);
        };
        if !self.edits.is_in_place() && !rebuild.is_finished() && !rebuild.shows(scene) {
            // It would have to be built once more.
            return Ok(None);
        }
        let reason = self.take_over(rebuild)?;
        let lowered = self.program.get().map(|lowered| &lowered.program);
        self.edits.ensure_margins(scene, lowered);
        Ok(Some(reason))
    }

    fn take_over(&mut self, rebuild: BackgroundRebuild) -> Result<RebuildReason, BuildError> {
        let finished = rebuild.finish();
        // Without this world there may be room.
        self.lacks_room_beside |= finished.as_ref().is_err_and(BuildError::lacks_memory);
        let RebuiltWorld {
            device,
            built,
            scene,
            edits,
            framing,
            light,
        } = finished?;
        let before = self.edits.take_stats();
        self.edits = edits;
        self.edits.add_stats(before);
        self.device = device;
        self.program = OnceLock::from(ProgramCache::from(built.program));
        self.query_count = AtomicU32::new(0);
        self.framing = OnceLock::from(framing);
        self.ground = OnceLock::new();
        self.scene = scene;
        self.light = light;
        self.build_timings = built.timings;
        // On half of the threads: rather too long than too short.
        self.rebuild_ms = built.duration_ms;
        self.observers.notify(&[Aabb::ALL]);
        Ok(built.reason)
    }

    /// Finishes a rebuild on another thread, and what was applied since it began.
    pub(super) async fn finish_rebuild(&mut self) -> Result<(), BuildError> {
        let latest = self
            .rebuild
            .as_mut()
            .and_then(BackgroundRebuild::take_latest);
        let Some((state, scene, margins)) = latest else {
            return match self.rebuild.take() {
                Some(rebuild) => self.take_over(rebuild).map(|_| ()),
                None => Ok(()),
            };
        };
        let reason = RebuildReason::FailedEdit;
        self.stop_rebuild();
        self.build_again(&scene, reason, Instant::now()).await?;
        self.edits.follow_instead(state, margins);
        Ok(())
    }
}

/// A page has no threads.
#[cfg(target_arch = "wasm32")]
impl World {
    pub(crate) fn remaining_blocks(&self) -> u64 {
        self.edits.remaining_blocks()
    }

    pub(super) fn stop_rebuild(&mut self) {}

    pub(super) fn take_over_rebuild(
        &mut self,
        _: &Scene,
    ) -> Result<Option<RebuildReason>, BuildError> {
        Ok(None)
    }

    pub(super) fn report_of_rebuild(&mut self, _: &Scene, _: Instant) -> Option<EditReport> {
        None
    }

    pub(super) fn rebuild_beside(
        &mut self,
        _: &Scene,
        _: RebuildReason,
        _: (f64, Instant),
    ) -> Result<Option<EditReport>, BuildError> {
        // Without threads, neither tells anything.
        let _ = (self.rebuild_ms, self.lacks_room_beside);
        Ok(None)
    }

    pub(super) async fn finish_rebuild(&mut self) -> Result<(), BuildError> {
        Ok(())
    }
}
