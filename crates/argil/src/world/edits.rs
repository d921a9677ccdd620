//! Updates a world after its scene's edits.

use super::World;
use super::rebuild::rebuild;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device};
use crate::edit_session::{EditPace, EditSession, UpdateResult};
use crate::observers::SubscriptionId;
use crate::program_cache::ProgramCache;
use crate::representation::updated_grid;
use crate::{BuildError, EditBudget, EditReport, RebuildReason};
use argil_field::Program;
use argil_math::Aabb;
use argil_scene::Scene;
use argil_volume::EditStats;
use argil_volume::Volume;
use std::sync::OnceLock;
use web_time::Instant;

impl World {
    /// Starts to track a scene whose changes are all applied.
    pub(crate) fn begin_following(&mut self, scene: &Scene) {
        self.edits = EditSession::of(scene);
        if let Some(edits) = self.device.edits() {
            // Edits in place do not move the camera.
            self.framing();
            let program = &ProgramCache::of(&self.program, &self.edits).program;
            self.edits.watch(scene, edits, program);
        }
    }

    /// Updates the world after its scene was edited, as a future: see [`World::apply`].
    ///
    /// # Errors
    /// If the scene cannot be compiled, or the result exceeds the memory budget.
    pub async fn apply_async(&mut self, scene: &Scene) -> Result<EditReport, BuildError> {
        self.follow(scene, EditPace::default()).await
    }

    /// Updates the world within a time budget, as a future: see [`World::apply_within`].
    ///
    /// # Errors
    /// If the scene cannot be compiled, or the result exceeds the memory budget.
    pub async fn apply_within_async(
        &mut self,
        scene: &Scene,
        budget: EditBudget,
    ) -> Result<EditReport, BuildError> {
        let pace = EditPace {
            budget: Some(budget),
            ..EditPace::default()
        };
        self.follow(scene, pace).await
    }

    /// Updates the world after its scene was edited.
    pub(crate) async fn follow(
        &mut self,
        scene: &Scene,
        pace: EditPace<'_>,
    ) -> Result<EditReport, BuildError> {
        let start = Instant::now();
        let is_within_budget = pace.budget.is_some();
        if is_within_budget && let Some(report) = self.report_of_rebuild(scene, start) {
            return Ok(report);
        }
        let taken_over = match self.take_over_rebuild(scene) {
            Ok(reason) => reason,
            // Without a budget, the world is built once more.
            Err(error) if is_within_budget => return Err(error),
            Err(_) => None,
        };
        let Some(reason) = taken_over else {
            return self.follow_changes(scene, pace, start).await;
        };
        let report = if self.edits.has_seen_all(scene) {
            EditReport::of_rebuild(reason, start)
        } else {
            self.follow_changes(scene, pace, start).await?
        };
        Ok(EditReport {
            dirty_box: Aabb::ALL,
            rebuilt: true,
            reason: report.reason.or(Some(reason)),
            ..report
        })
    }

    /// Updates the world after its scene was edited, while it is not being rebuilt.
    async fn follow_changes(
        &mut self,
        scene: &Scene,
        pace: EditPace<'_>,
        start: Instant,
    ) -> Result<EditReport, BuildError> {
        let mut reason = RebuildReason::NotEditable;
        if self.edits.is_in_place() {
            reason = RebuildReason::Specialized;
        }
        let max_ms = pace.budget.map(|budget| budget.max_ms);
        if self.device.is_editable() && self.device.has_lost_edits() {
            reason = RebuildReason::NotSubmitted;
        } else if self.device.is_editable() {
            let is_for_host = pace.encoder.is_some();
            let machine = (&self.engine, self.representation.memory_budget());
            let lowered = self.program.get().map(|lowered| &lowered.program);
            let before = (&self.scene, lowered);
            let device = &mut self.device;
            let followed = self
                .edits
                .update(scene, device, before, machine, pace)
                .await;
            // The program on the GPU already has the new parameters, even if the volume cannot follow.
            if self.engine.is_gpu() && self.edits.tables().is_some() {
                self.forget_program();
            }
            if followed.is_err() {
                self.light.forget();
            }
            match followed {
                // Nothing was counted for a host, so that a rebuild may fit.
                Err(error) if is_for_host && error.exceeded_budget().is_some() => {
                    reason = RebuildReason::TooLarge;
                }
                Err(error) => return Err(error),
                Ok(UpdateResult::InPlace(applied)) => {
                    self.forget_program();
                    if let Some(layout) = self.device.brick_layout()
                        && self.edits.has_followed()
                    {
                        self.light.note_edit(self.edits.program(), &layout);
                    }
                    self.note_ground(applied.dirty_box);
                    self.scene = scene.snapshot();
                    let boxes = self.edits.take_finished_boxes();
                    self.observers.notify(&boxes);
                    return Ok(applied);
                }
                Ok(UpdateResult::Rebuild(why)) => reason = why,
            }
        }
        if let Some(max_ms) = max_ms
            && let Some(report) = self.rebuild_beside(scene, reason, (max_ms, start))?
        {
            return Ok(report);
        }
        self.build_again(scene, reason, start).await
    }

    /// Builds the world again after an edit that it cannot follow in place.
    pub(super) async fn build_again(
        &mut self,
        scene: &Scene,
        reason: RebuildReason,
        start: Instant,
    ) -> Result<EditReport, BuildError> {
        let voxel_grid = self.device.voxel_grid();
        let target = (self.representation, voxel_grid);
        let built = rebuild(&mut self.device, (&self.engine, scene), target, reason);
        let built = built.await?;
        self.build_timings = built.timings;
        self.rebuild_ms = built.duration_ms;
        self.light.forget();
        self.framing = OnceLock::new();
        self.ground = OnceLock::new();
        self.scene = scene.snapshot();
        self.program = OnceLock::from(ProgramCache::from(built.program));
        let done = self.edits.take_stats();
        self.begin_following(scene);
        self.observers.notify(&[Aabb::ALL]);
        let bricks = self
            .volume_info_async()
            .await?
            .and_then(|info| info.bricks)
            .map_or(0, |s| s.bricks);
        self.edits.record_rebuild(bricks, done);
        Ok(EditReport::of_rebuild(built.reason, start))
    }

    /// Finishes earlier edits, as a future: see [`World::flush`].
    ///
    /// # Errors
    /// If the result exceeds the memory budget, or the device fails.
    pub async fn flush_async(&mut self) -> Result<EditStats, BuildError> {
        self.finish_rebuild().await?;
        if !self.device.is_editable() {
            return Ok(self.edits.take_stats());
        }
        let machine = (&self.engine, self.representation.memory_budget());
        let edit = self.edits.flush(&mut self.device, machine).await?;
        let boxes = self.edits.take_finished_boxes();
        self.observers.notify(&boxes);
        Ok(edit)
    }

    /// Frees unused memory on a GPU, as a future: see [`World::shrink_to_fit`].
    ///
    /// # Errors
    /// If the device fails.
    pub async fn shrink_to_fit_async(&mut self) -> Result<(), BuildError> {
        self.device.shrink_to_fit().await
    }

    /// Calls `listener` whenever edits are finished, with boxes outside which no distance near a surface changed.
    /// After a rebuild, it is the box of everything. The thread that applies edits makes the call. On a GPU, the
    /// call comes after the work is submitted.
    #[doc(alias = "observer")]
    #[doc(alias = "callback")]
    pub fn subscribe(
        &mut self,
        listener: impl FnMut(&[Aabb]) + Send + Sync + 'static,
    ) -> SubscriptionId {
        self.observers.add(Box::new(listener))
    }

    /// Ends a subscription. Returns whether there was one.
    pub fn unsubscribe(&mut self, listener: SubscriptionId) -> bool {
        self.observers.remove(listener)
    }

    /// Counts differing cells, as a future: see [`World::diff_from_rebuild`].
    ///
    /// # Errors
    /// If the scene cannot be baked.
    pub async fn diff_from_rebuild_async(&self) -> Result<Option<u64>, BuildError> {
        let volume = self.volume_async().await?;
        let Some(Volume::Bricks(bricks)) = volume.as_deref() else {
            return Ok(None);
        };
        let program = Program::lower(&self.scene)?;
        // The world's own program has its tables in another order after edits.
        let mut device = AnyDevice::new(&self.engine, &program)?;
        // It has the same box, if that contains the scene.
        let voxel_grid = match self.device.voxel_grid() {
            Some(voxel_grid) => Some(updated_grid(&voxel_grid, &self.scene, &program)?),
            None => None,
        };
        let site = BuildContext {
            engine: &self.engine,
            scene: &self.scene,
            program: &program,
        };
        let built = self.representation.build(&mut device, &site, voxel_grid);
        built.await?;
        Ok(match device.volume().await?.as_deref() {
            Some(Volume::Bricks(fresh)) => Some(bricks.differing_cells(fresh)),
            _ => None,
        })
    }
}
