//! Updates a world after its scene's edits, in place.

#[cfg(not(target_arch = "wasm32"))]
mod beside;

use crate::device::{AnyDevice, Device, EditWork, HostEncoder};
use crate::edit_report::{EditBudget, EditReport, RebuildReason};
use crate::memory::{budget_on, without_budget};
#[cfg(feature = "gpu")]
use crate::moves::Moves;
use crate::representation::has_outgrown;
#[cfg(feature = "gpu")]
use crate::scene_state::SceneState;
use crate::scene_state::state_of;
use crate::{BuildError, Engine};
#[cfg(feature = "gpu")]
use argil_field::BrushMotion;
use argil_field::{IncrementalProgram, Program};
use argil_math::Aabb;
use argil_scene::{Extents, MarginRequest};
use argil_scene::{Scene, SceneChange};
use argil_volume::{BricksError, EditStats, PendingEdits};
use web_time::{Duration, Instant};

/// The result of updating a world in place.
pub(crate) enum UpdateResult {
    InPlace(EditReport),
    /// The whole world must be rebuilt.
    Rebuild(RebuildReason),
}

/// An id that no scene has. It marks a world that no longer matches any scene.
const STALE: u64 = 0;

/// How much of the edits to process, and who submits them.
#[derive(Default)]
pub(crate) struct EditPace<'a> {
    /// `None` for all of them.
    pub budget: Option<EditBudget>,
    /// The encoder of a host, if the host submits what a device does.
    pub encoder: Option<&'a mut HostEncoder>,
}

impl EditPace<'_> {
    /// Returns the time to spend. NaN and negative budgets count as 0.
    fn within(&self) -> Option<Duration> {
        let budget = self.budget?;
        let seconds = (budget.max_ms * 1e-3).clamp(0.0, 1e6);
        Some(Duration::try_from_secs_f64(seconds).unwrap_or_default())
    }

    /// Whether all of the time since a start is spent.
    fn is_used_up(&self, start: Instant) -> bool {
        let within = self.within();
        within.is_some_and(|within| !within.is_zero() && start.elapsed() >= within)
    }
}

/// Tracks which changes of its scene a world has applied.
#[derive(Debug)]
pub(crate) struct EditSession {
    /// The scene's id, or [`STALE`].
    identity: u64,
    /// Number of the scene's changes that the world has applied.
    seen_changes: usize,
    /// What earlier edits left to do. `None` unless the representation can change in place.
    edits: Option<Box<dyn PendingEdits>>,
    /// Makes the scene record dirty boxes with the margins that the representation needs.
    watch: Option<MarginRequest>,
    /// Created when it is first needed.
    program: Option<IncrementalProgram>,
    /// Dirty boxes of edits that are not finished.
    pending_boxes: Vec<Aabb>,
    /// What edits did since this was last taken.
    stats: EditStats,
    /// Why the world cannot be updated in place, if it is stale.
    stale_reason: RebuildReason,
    /// Whether the last update followed changes, and did not only go on with what remained.
    has_followed: bool,
    /// Whether the last update had no time for any block.
    has_waited: bool,
    /// What the last edits moved.
    #[cfg(feature = "gpu")]
    moves: Moves,
}

impl EditSession {
    pub(crate) fn of(scene: &Scene) -> Self {
        let (identity, seen_changes) = state_of(scene);
        Self {
            identity,
            seen_changes,
            edits: None,
            watch: None,
            program: None,
            pending_boxes: Vec::new(),
            stats: EditStats::default(),
            stale_reason: RebuildReason::FailedEdit,
            has_followed: false,
            has_waited: false,
            #[cfg(feature = "gpu")]
            moves: Moves::default(),
        }
    }

    /// Starts to track a scene with a representation that can change in place.
    pub(crate) fn watch(&mut self, scene: &Scene, edits: Box<dyn PendingEdits>, program: &Program) {
        self.watch = Some(scene.request_margins(edits.margins(program)));
        self.edits = Some(edits);
    }

    /// Whether the last update followed changes, and did not only go on with what remained.
    pub(crate) fn has_followed(&self) -> bool {
        self.has_followed
    }

    /// Whether the representation can change in place.
    pub(crate) fn is_in_place(&self) -> bool {
        self.edits.is_some()
    }

    /// Whether the world has applied every change of this scene.
    pub(crate) fn has_seen_all(&self, scene: &Scene) -> bool {
        self.identity == scene.id() && self.seen_changes == scene.change_count()
    }

    /// Returns why this scene's changes cannot be applied in place, or `None` if they can.
    fn rebuild_reason(&self, scene: &Scene) -> Option<RebuildReason> {
        if self.identity == STALE {
            return Some(self.stale_reason);
        }
        let is_other = self.identity != scene.id() || self.seen_changes > scene.change_count();
        is_other.then_some(RebuildReason::OtherScene)
    }

    /// Returns the scene's changes since the last update. `min_margins` are the margins that their dirty boxes must
    /// have.
    ///
    /// # Errors
    /// The reason for a rebuild, if the world cannot be updated from these changes.
    fn changes_of<'s>(
        &self,
        scene: &'s Scene,
        min_margins: [f32; 2],
    ) -> Result<&'s [SceneChange], RebuildReason> {
        if let Some(reason) = self.rebuild_reason(scene) {
            return Err(reason);
        }
        let changes = scene
            .changes_since(self.seen_changes)
            .ok_or(RebuildReason::HistoryGone)?;
        let has_margins = |change: &SceneChange| {
            let mut pairs = change.margins.into_iter().zip(min_margins);
            pairs.all(|(margin, min)| margin >= min)
        };
        if changes.iter().all(has_margins) {
            Ok(changes)
        } else {
            Err(RebuildReason::DirtyMargin)
        }
    }

    /// Applies a scene's changes to what a device stores. `before` is the scene that the volume follows, and the program that it was
    /// built from, if there is no incremental program yet.
    ///
    /// # Errors
    /// If the scene cannot be compiled; then nothing changes. If the bricks exceed the memory budget; then the next
    /// update rebuilds the world.
    pub(crate) async fn update(
        &mut self,
        scene: &Scene,
        device: &mut AnyDevice,
        before: (&Scene, Option<&Program>),
        (engine, budget): (&Engine, Option<u64>),
        pace: EditPace<'_>,
    ) -> Result<UpdateResult, BuildError> {
        let start = Instant::now();
        let Some(edits) = &self.edits else {
            return Ok(UpdateResult::Rebuild(RebuildReason::NotEditable));
        };
        let Some(tables) = self.tables().or(before.1) else {
            return Ok(UpdateResult::Rebuild(RebuildReason::FailedEdit));
        };
        let changes = match self.changes_of(scene, edits.min_margins(tables)) {
            Ok(changes) => changes,
            Err(reason) => return Ok(UpdateResult::Rebuild(reason)),
        };
        let is_going_on = self.program.is_some() && edits.remaining_blocks() > 0;
        let boxes: Vec<[Aabb; 2]> = changes.iter().flat_map(SceneChange::boxes).collect();
        // What is known of earlier changes holds until others come.
        self.has_followed = !(changes.is_empty() && is_going_on);
        if self.has_followed
            && let Some(reason) = self.add_changes(scene, changes, &boxes, (device, before))?
        {
            return Ok(self.request_rebuild(reason));
        }
        if let (Some(budget), Some(edits)) = (pace.budget, &mut self.edits) {
            edits.sort_by_distance(budget.priority_point.into());
        }
        let dirty = boxes.iter().map(|[dirty, _]| *dirty);
        self.pending_boxes
            .extend(dirty.filter(|dirty| !dirty.is_empty()));
        // Where following the changes took all of the time, blocks wait for the next call, once.
        self.has_waited = !self.has_waited && self.has_followed && pace.is_used_up(start);
        if !self.has_waited {
            let edited = self.continue_edits(device, (engine, budget), pace, start);
            if let Err(error) = edited.await {
                return Err(self.mark_stale(error));
            }
        }
        let dirty_box = boxes
            .iter()
            .fold(Aabb::EMPTY, |all, [changed, _]| all.union(*changed));
        Ok(UpdateResult::InPlace(EditReport {
            remaining_blocks: self.remaining_blocks(),
            dirty_box,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: false,
            is_rebuilding: false,
            reason: None,
        }))
    }

    /// Lets the program, the voxel grid and the remaining work follow a scene's changes. Returns the reason for a rebuild if they
    /// cannot.
    ///
    /// # Errors
    /// If the scene cannot be compiled; then nothing changes. If the device fails; then the next update rebuilds the world.
    fn add_changes(
        &mut self,
        scene: &Scene,
        changes: &[SceneChange],
        boxes: &[[Aabb; 2]],
        (device, before): (&mut AnyDevice, (&Scene, Option<&Program>)),
    ) -> Result<Option<RebuildReason>, BuildError> {
        let Some(edits) = &self.edits else {
            return Ok(Some(RebuildReason::NotEditable));
        };
        let is_first = self.program.is_none();
        let live = match &mut self.program {
            Some(live) => live,
            None => {
                let (scene, Some(program)) = before else {
                    return Ok(Some(RebuildReason::FailedEdit));
                };
                let live = IncrementalProgram::new(scene, edits.parts(program))?;
                if !live.has_same_bounds_as(program) {
                    return Ok(Some(RebuildReason::GlobalBounds));
                }
                self.program.insert(live)
            }
        };
        if live.update(scene, changes)?.needs_rebuild {
            return Ok(Some(RebuildReason::GlobalBounds));
        }
        if is_first {
            live.tighten_box();
        }
        let put = live.inserted_box();
        match self.grow(scene, device, put) {
            Ok(None) => {}
            Ok(Some(reason)) => return Ok(Some(reason)),
            // The program is already ahead of the volume, so the next update must rebuild.
            Err(error) => return Err(self.mark_stale(error)),
        }
        let (Some(live), Some(edits)) = (&mut self.program, &mut self.edits) else {
            return Ok(Some(RebuildReason::FailedEdit));
        };
        #[cfg(feature = "gpu")]
        self.moves
            .note((self.identity, self.seen_changes), live.moved());
        self.seen_changes = scene.change_count();
        if let Some(watch) = &self.watch {
            watch.set(edits.margins(live.program()));
        }
        if let Err(error) = device.follow_program(live) {
            return Err(self.mark_stale(error));
        }
        // Much steeper than before, blocks depend on more than the program tells of their parts.
        if edits.min_margins(live.program())[1] > live.parts().far {
            return Ok(Some(RebuildReason::GlobalBounds));
        }
        let fits = edits.merge(live, boxes);
        Ok((!fits).then_some(RebuildReason::TooLarge))
    }

    /// Grows the voxel grid to contain what was inserted. Returns the reason for a rebuild if it cannot.
    fn grow(
        &mut self,
        scene: &Scene,
        device: &mut AnyDevice,
        (put, touched_ends): (Aabb, bool),
    ) -> Result<Option<RebuildReason>, BuildError> {
        let Some(edits) = &mut self.edits else {
            return Ok(None);
        };
        let voxel_grid = *edits.voxel_grid();
        let held = voxel_grid.aabb().grown(-2.0 * voxel_grid.voxel_size);
        let is_held = put.is_empty() || (held.contains(put.min) && held.contains(put.max));
        let is_fixed = voxel_grid.is_clipped && scene.view.bounds.is_some();
        if !touched_ends && (is_held || is_fixed) {
            return Ok(None);
        }
        let solid = Extents::of(scene).node_bounds(Scene::ROOT).aabb;
        let is_infinite = !solid.is_finite() && !solid.is_empty();
        if is_infinite != voxel_grid.is_clipped {
            return Ok(Some(RebuildReason::Unbounded));
        }
        if is_infinite {
            let grows = !is_fixed && has_outgrown(&voxel_grid, scene);
            return Ok(grows.then_some(RebuildReason::OutsideBox));
        }
        if edits.grow_to(solid).map_err(BricksError::from)? {
            device.grow(&**edits);
        }
        Ok(None)
    }

    /// Processes remaining batches until the budget is used up.
    async fn continue_edits(
        &mut self,
        device: &mut AnyDevice,
        (engine, requested): (&Engine, Option<u64>),
        pace: EditPace<'_>,
        start: Instant,
    ) -> Result<(), BuildError> {
        let (Some(live), Some(edits)) = (&self.program, &mut self.edits) else {
            return Ok(());
        };
        let work = EditWork {
            memory_budget: budget_on(engine, requested),
            start,
            within: pace.within(),
            encoder: pace.encoder,
        };
        let edited = device.edit(live, &mut **edits, work).await;
        self.stats += edited.map_err(|error| without_budget(error, requested))?;
        Ok(())
    }

    /// Returns the number of blocks that remain to be rebuilt.
    pub(crate) fn remaining_blocks(&self) -> u64 {
        self.edits
            .as_ref()
            .map_or(0, |edits| edits.remaining_blocks())
    }

    /// Marks the world as stale, and returns the request for a rebuild.
    fn request_rebuild(&mut self, reason: RebuildReason) -> UpdateResult {
        (self.identity, self.stale_reason) = (STALE, reason);
        UpdateResult::Rebuild(reason)
    }

    /// Marks the world as stale after a failure, because the program is ahead of the bricks.
    fn mark_stale(&mut self, error: BuildError) -> BuildError {
        (self.identity, self.stale_reason) = (STALE, RebuildReason::FailedEdit);
        if let Some(edits) = &mut self.edits {
            edits.clear();
        }
        self.pending_boxes.clear();
        error
    }

    /// Processes all remaining blocks and waits for the device. Returns what edits did since the last call.
    pub(crate) async fn flush(
        &mut self,
        device: &mut AnyDevice,
        machine: (&Engine, Option<u64>),
    ) -> Result<EditStats, BuildError> {
        let pace = EditPace::default();
        let edited = self.continue_edits(device, machine, pace, Instant::now());
        if let Err(error) = edited.await {
            return Err(self.mark_stale(error));
        }
        match device.flush().await {
            Ok(stats) => self.stats += stats,
            Err(error) => return Err(self.mark_stale(error)),
        }
        Ok(self.take_stats())
    }

    /// Takes what edits did since the last call.
    pub(crate) fn take_stats(&mut self) -> EditStats {
        std::mem::take(&mut self.stats)
    }

    /// Records that a rebuild filled a number of bricks, after earlier edits.
    pub(crate) fn record_rebuild(&mut self, bricks: u64, before: EditStats) {
        self.stats = before;
        self.stats.filled += bricks;
    }

    /// Takes the dirty boxes of finished edits, once no block remains.
    pub(crate) fn take_finished_boxes(&mut self) -> Vec<Aabb> {
        if self.remaining_blocks() == 0 {
            std::mem::take(&mut self.pending_boxes)
        } else {
            Vec::new()
        }
    }

    /// Returns the scene, and the number of its changes that the world has applied.
    #[cfg(feature = "gpu")]
    pub(crate) fn state(&self) -> SceneState {
        (self.identity, self.seen_changes)
    }

    /// Returns what moved since the world was in a state, if that is known and nothing remains to be rebuilt.
    #[cfg(feature = "gpu")]
    pub(crate) fn motion_since(&self, state: SceneState) -> Option<BrushMotion> {
        let is_done = self.remaining_blocks() == 0;
        self.moves
            .since(state, self.program.as_ref().filter(|_| is_done)?)
    }

    /// Returns the incremental program, if there is one.
    pub(crate) fn program(&self) -> Option<&IncrementalProgram> {
        self.program.as_ref()
    }

    /// What holds of the whole, and the tables, if the scene was followed.
    pub(crate) fn tables(&self) -> Option<&Program> {
        self.program.as_ref().map(IncrementalProgram::program)
    }

    /// The whole program as it is now, if the scene was followed.
    pub(crate) fn to_program(&self) -> Option<Program> {
        self.program.as_ref().map(IncrementalProgram::to_program)
    }
}
