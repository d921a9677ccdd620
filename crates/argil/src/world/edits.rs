//! Updates a world after its scene's edits.

use super::World;
use crate::edit_session::{EditPace, EditSession, EditableVolume, UpdateResult};
use crate::observers::SubscriptionId;
use crate::program_cache::ProgramCache;
use crate::representation::{BuildContext, Storage, updated_grid, view_bounds_of};
use crate::{BuildError, EditBudget, EditReport, RebuildReason};
use argil_field::Program;
use argil_gpu::{GpuError, GpuProgram};
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
        let edits = match &self.storage {
            Storage::Cpu(volume) => volume.edits(),
            Storage::Gpu(volume) => volume.edits(),
            Storage::Field | Storage::Mesh(_) => None,
        };
        if let Some(edits) = edits {
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
        let mut reason = RebuildReason::NotEditable;
        if self.edits.is_in_place() {
            reason = RebuildReason::Specialized;
        }
        let kept = EditableVolume::of(&mut self.storage, self.gpu.as_mut());
        if kept.as_ref().is_some_and(EditableVolume::has_lost_edits) {
            reason = RebuildReason::NotSubmitted;
        } else if let Some(kept) = kept {
            let is_for_host = pace.encoder.is_some();
            let machine = (&self.engine, self.representation.memory_budget());
            let lowered = self.program.get().map(|lowered| &lowered.program);
            let before = (&self.scene, lowered);
            let followed = self.edits.update(scene, kept, before, machine, pace).await;
            // The program on the GPU already has the new parameters, even if the volume cannot follow.
            if self.gpu.is_some() && self.edits.tables().is_some() {
                self.forget_program();
            }
            if followed.is_err() {
                self.light.forget();
            }
            match followed {
                // Nothing was counted for a host, so that a rebuild may fit.
                Err(BuildError::Gpu(GpuError::Budget { .. })) if is_for_host => {
                    reason = RebuildReason::TooLarge;
                }
                Err(error) => return Err(error),
                Ok(UpdateResult::InPlace(applied)) => {
                    self.forget_program();
                    if let Some(layout) = self.storage.brick_layout() {
                        self.light.note_edit(self.edits.program(), &layout);
                    }
                    self.scene = scene.snapshot();
                    let boxes = self.edits.take_finished_boxes();
                    self.observers.notify(&boxes);
                    return Ok(applied);
                }
                Ok(UpdateResult::Rebuild(why)) => reason = why,
            }
        }
        let program = Program::lower(scene)?;
        match &mut self.gpu {
            Some(gpu) if !gpu.is_specialized() => gpu.update(&program)?,
            Some(gpu) => *gpu = GpuProgram::new(gpu.gpu().clone(), &program, true)?,
            None => {}
        }
        let voxel_grid = match self.storage.voxel_grid() {
            Some(old) => {
                let new = updated_grid(&old, scene, &program)?;
                if new != old && reason == RebuildReason::NotEditable {
                    reason = RebuildReason::OutsideBox;
                }
                Some(new)
            }
            None => None,
        };
        let site = self.site(scene, &program);
        let (kept, times) = self.representation.build(&site, voxel_grid).await?;
        (self.storage, self.build_timings) = (kept, times);
        self.light.forget();
        self.view_bounds = view_bounds_of(scene, &program);
        self.scene = scene.snapshot();
        self.program = OnceLock::from(ProgramCache::from(program));
        let done = self.edits.take_stats();
        self.begin_following(scene);
        self.observers.notify(&[Aabb::ALL]);
        let bricks = self
            .volume_info_async()
            .await?
            .and_then(|info| info.bricks)
            .map_or(0, |s| s.bricks);
        self.edits.record_rebuild(bricks, done);
        Ok(EditReport {
            remaining_blocks: 0,
            dirty_box: Aabb::ALL,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: true,
            reason: Some(reason),
        })
    }

    /// Finishes earlier edits, as a future: see [`World::flush`].
    ///
    /// # Errors
    /// If the result exceeds the memory budget, or the device fails.
    pub async fn flush_async(&mut self) -> Result<EditStats, BuildError> {
        let Some(kept) = EditableVolume::of(&mut self.storage, self.gpu.as_mut()) else {
            return Ok(self.edits.take_stats());
        };
        let machine = (&self.engine, self.representation.memory_budget());
        let edit = self.edits.flush(kept, machine).await?;
        let boxes = self.edits.take_finished_boxes();
        self.observers.notify(&boxes);
        Ok(edit)
    }

    /// Frees unused memory on a GPU, as a future: see [`World::shrink_to_fit`].
    ///
    /// # Errors
    /// If the device fails.
    pub async fn shrink_to_fit_async(&mut self) -> Result<(), BuildError> {
        if let (Storage::Gpu(volume), Some(field)) = (&mut self.storage, &self.gpu) {
            volume.shrink_to_fit(field).await?;
        }
        Ok(())
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
        let field = match &self.gpu {
            Some(own) => Some(GpuProgram::new(own.gpu().clone(), &program, false)?),
            None => None,
        };
        let field = field.as_ref();
        // It has the same box, if that contains the scene.
        let voxel_grid = match self.storage.voxel_grid() {
            Some(voxel_grid) => Some(updated_grid(&voxel_grid, &self.scene, &program)?),
            None => None,
        };
        let site = BuildContext {
            field,
            ..self.site(&self.scene, &program)
        };
        let (fresh, _) = self.representation.build(&site, voxel_grid).await?;
        let fresh = match (fresh, field) {
            (Storage::Cpu(volume), _) => volume,
            (Storage::Gpu(volume), Some(field)) => volume.download(field.gpu()).await?,
            _ => return Ok(None),
        };
        Ok(match &fresh {
            Volume::Bricks(fresh) => Some(bricks.differing_cells(fresh)),
            _ => None,
        })
    }
}
