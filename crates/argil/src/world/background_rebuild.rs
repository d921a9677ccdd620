//! Builds a world again on another thread, while the world shows its scene as it was.

use super::rebuild::{Rebuilt, rebuild};
use crate::device::{AnyDevice, Device};
use crate::edit_session::EditSession;
use crate::framing::Framing;
use crate::light::Light;
use crate::scene_state::{SceneState, state_of};
use crate::{BuildError, EditReport, Engine, RebuildReason, Representation};
use argil_field::in_background;
use argil_math::{Aabb, Control};
use argil_scene::{MarginRequest, Scene};
use argil_volume::VoxelGrid;
use pollster::block_on as wait;
use std::thread::JoinHandle;
use web_time::{Duration, Instant};

/// Waits for a thread. A thread of rayon works for others meanwhile, because the rebuild may wait for it.
fn joined<T>(thread: JoinHandle<T>) -> std::thread::Result<T> {
    while !thread.is_finished() && rayon::current_thread_index().is_some() {
        pause();
    }
    thread.join()
}

/// Works for others on a thread of rayon, or else sleeps a little.
fn pause() {
    if rayon::yield_now() != Some(rayon::Yield::Executed) {
        std::thread::sleep(Duration::from_micros(100));
    }
}

/// Returns an error if the work is canceled.
fn check(control: &Control) -> Result<(), BuildError> {
    match control.is_cancelled() {
        true => Err(BuildError::Cancelled),
        false => Ok(()),
    }
}

/// A world that was built on another thread.
pub(super) struct RebuiltWorld {
    pub device: AnyDevice,
    pub built: Rebuilt,
    pub scene: Scene,
    pub edits: EditSession,
    pub framing: Framing,
    pub light: Light,
}

/// What to build on another thread.
pub(super) struct RebuildOrder {
    pub engine: Engine,
    /// A device on which nothing is stored.
    pub device: AnyDevice,
    /// The representation, and the grid whose voxels it keeps.
    pub target: (Representation, Option<VoxelGrid>),
    pub reason: RebuildReason,
    /// Whether light reads levels beside bricks.
    pub is_lit: bool,
    /// Makes the scene record edits with the margins that the new world needs.
    pub margins: Option<MarginRequest>,
}

/// A rebuild on another thread. Dropping it cancels the rebuild, and waits until the thread has ended.
#[derive(Debug)]
pub(super) struct BackgroundRebuild {
    thread: Option<JoinHandle<Result<RebuiltWorld, BuildError>>>,
    control: Control,
    reason: RebuildReason,
    /// The state of the scene that is built.
    state: SceneState,
    /// The scene as it was last applied, if that is a later state.
    latest: Option<(SceneState, Scene)>,
    /// Makes the scene record edits with the margins that the new world needs.
    margins: Option<MarginRequest>,
}

impl BackgroundRebuild {
    /// Starts to build a scene. Returns `None` if the system has no thread for it.
    pub(super) fn start(order: RebuildOrder, scene: &Scene) -> Option<Self> {
        let control = Control::new();
        let (edits, copy) = (EditSession::of(scene), scene.snapshot());
        let engine = order.engine.with_control(&control);
        let RebuildOrder {
            mut device,
            target,
            reason,
            is_lit,
            margins,
            ..
        } = order;
        let work = async move || {
            let built = rebuild(&mut device, (&engine, &copy), target, reason).await?;
            check(&engine.control)?;
            let framing = Framing::of(&copy, &built.program);
            let mut made = RebuiltWorld {
                device,
                built,
                scene: copy,
                edits,
                framing,
                light: Light::default(),
            };
            made.prepare_edits(is_lit, &engine.control).await?;
            Ok(made)
        };
        let thread = std::thread::Builder::new().name("argil rebuild".into());
        let thread = thread.spawn(move || in_background(|| wait(work()))).ok();
        thread.map(|thread| Self {
            thread: Some(thread),
            control,
            reason,
            state: state_of(scene),
            latest: None,
            margins,
        })
    }

    /// Cancels the rebuild.
    pub(super) fn cancel(&self) {
        self.control.cancel();
    }

    /// Whether the new world shows all changes of a scene.
    pub(super) fn shows(&self, scene: &Scene) -> bool {
        self.state == state_of(scene)
    }

    /// Whether the new world is there.
    pub(super) fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the new world until a call has taken `max_ms` since `start`. Returns whether it is there.
    pub(super) fn is_finished_within(&self, max_ms: f64, start: Instant) -> bool {
        while !self.is_finished() && start.elapsed().as_secs_f64() * 1e3 < max_ms {
            pause();
        }
        self.is_finished()
    }

    /// Notes the scene that the new world is to show in the end.
    pub(super) fn note_scene(&mut self, scene: &Scene) {
        let state = state_of(scene);
        let known = self.latest.as_ref().map_or(self.state, |(known, _)| *known);
        if state != known {
            self.latest = (state != self.state).then(|| (state, scene.snapshot()));
        }
    }

    /// Waits for the new world.
    ///
    /// # Errors
    /// If it could not be built.
    pub(super) fn finish(mut self) -> Result<RebuiltWorld, BuildError> {
        let thread = self.thread.take().expect("a thread until it is joined");
        let joined = joined(thread);
        let mut made = joined.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        made.edits.set_margin_request(self.margins.take());
        Ok(made)
    }

    /// Returns the scene as it was last applied, if the new world does not show it.
    pub(super) fn take_latest(&mut self) -> Option<(SceneState, Scene, Option<MarginRequest>)> {
        let (state, scene) = self.latest.take()?;
        Some((state, scene, self.margins.take()))
    }

    /// Returns the report of a call that did not wait for the new world.
    pub(super) fn report(&self, blocks: u64, start: Instant) -> EditReport {
        EditReport {
            remaining_blocks: blocks.max(1),
            dirty_box: Aabb::EMPTY,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: false,
            is_rebuilding: true,
            reason: Some(self.reason),
        }
    }
}

impl Drop for BackgroundRebuild {
    fn drop(&mut self) {
        self.control.cancel();
        if let Some(thread) = self.thread.take() {
            // What it has made is of no use any more.
            let _ = joined(thread);
        }
    }
}

impl RebuiltWorld {
    /// Prepares what the first edit and the first image would otherwise have to.
    async fn prepare_edits(&mut self, is_lit: bool, control: &Control) -> Result<(), BuildError> {
        let program = &self.built.program;
        if let Some(edits) = self.device.edits() {
            self.edits.prepare(&self.scene, edits, program)?;
        }
        check(control)?;
        if let Some(layout) = self.device.brick_layout().filter(|_| is_lit) {
            self.light = Light::baked(program, &layout);
        }
        let info = self.device.info().await?;
        let bricks = info
            .and_then(|info| info.bricks)
            .map_or(0, |known| known.bricks);
        self.edits.record_rebuild(bricks, Default::default());
        Ok(())
    }
}
