//! How a world follows its scene.

use super::World;
use crate::listeners::Listener;
use crate::live::{Applied, Editable, Followed, Live, Pace, Rebuilt};
use crate::lowered::Lowered;
use crate::representation::{Kept, Site, focus, following, found_again};
use crate::{BuildError, Scene, Volume};
use argil_field::Program;
use argil_gpu::GpuField;
use argil_math::Aabb;
use argil_volume::BrickEdit;
use std::sync::OnceLock;
use web_time::Instant;

impl World {
    /// Follow a scene from now on, whose changes are all known.
    pub(crate) fn begin_following(&mut self, scene: &Scene) {
        self.live = Live::of(scene);
        let edits = match &self.kept {
            Kept::Cpu(volume) => volume.edits(),
            Kept::Gpu(volume) => volume.edits(),
            Kept::Field | Kept::Mesh(_) => None,
        };
        if let Some(edits) = edits {
            let program = &Lowered::of(&self.program, &self.live).program;
            self.live.watch(scene, edits, program);
        }
    }

    /// [`World::apply`] as a future; see [`Build::via_async`](crate::Build::via_async).
    ///
    /// # Errors
    /// As there.
    pub async fn apply_async(&mut self, scene: &Scene) -> Result<Applied, BuildError> {
        self.follow(scene, None).await
    }

    /// [`World::apply_at`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn apply_at_async(
        &mut self,
        scene: &Scene,
        pace: Pace,
    ) -> Result<Applied, BuildError> {
        self.follow(scene, Some(pace)).await
    }

    async fn follow(&mut self, scene: &Scene, pace: Option<Pace>) -> Result<Applied, BuildError> {
        let start = Instant::now();
        let mut reason = Rebuilt::Kept;
        if self.live.is_in_place() {
            reason = Rebuilt::Specialized;
        }
        if let Some(kept) = Editable::of(&mut self.kept, self.gpu.as_mut()) {
            let machine = (&self.engine, self.via.memory_budget());
            let before = self.program.get().map(|lowered| &lowered.program);
            let followed = self.live.follow(scene, kept, before, machine, pace).await;
            // The field on a GPU has the parameters of what was followed, even where the volume could not be.
            if self.gpu.is_some() && self.live.tables().is_some() {
                self.forget_program();
            }
            match followed? {
                Followed::InPlace(applied) => {
                    self.forget_program();
                    self.scene = scene.snapshot();
                    let boxes = self.live.told();
                    self.listeners.tell(&boxes);
                    return Ok(applied);
                }
                Followed::Not(why) => reason = why,
            }
        }
        let program = Program::lower(scene)?;
        match &mut self.gpu {
            Some(gpu) if !gpu.is_specialized() => gpu.update(&program)?,
            Some(gpu) => *gpu = GpuField::new(gpu.gpu().clone(), &program, true)?,
            None => {}
        }
        let lattice = match self.kept.lattice() {
            Some(old) => {
                let new = following(&old, scene, &program)?;
                if new != old && reason == Rebuilt::Kept {
                    reason = Rebuilt::Box;
                }
                Some(new)
            }
            None => None,
        };
        let site = self.site(scene, &program);
        let (kept, times) = self.via.build(&site, lattice).await?;
        (self.kept, self.times) = (kept, times);
        self.focus = focus(scene, &program);
        self.scene = scene.snapshot();
        self.program = OnceLock::from(Lowered::from(program));
        let done = self.live.take_done();
        self.begin_following(scene);
        self.listeners.tell(&[Aabb::ALL]);
        let bricks = self
            .volume_info_async()
            .await?
            .and_then(|info| info.sparse)
            .map_or(0, |s| s.bricks);
        self.live.made(bricks, done);
        Ok(Applied {
            blocks_left: 0,
            dirty_box: Aabb::ALL,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: true,
            reason: Some(reason),
        })
    }

    /// [`World::finish`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn finish_async(&mut self) -> Result<BrickEdit, BuildError> {
        let Some(kept) = Editable::of(&mut self.kept, self.gpu.as_mut()) else {
            return Ok(self.live.take_done());
        };
        let machine = (&self.engine, self.via.memory_budget());
        let edit = self.live.finish(kept, machine).await?;
        let boxes = self.live.told();
        self.listeners.tell(&boxes);
        Ok(edit)
    }

    /// [`World::trim`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn trim_async(&mut self) -> Result<(), BuildError> {
        if let (Kept::Gpu(volume), Some(field)) = (&mut self.kept, &self.gpu) {
            volume.trim(field).await?;
        }
        Ok(())
    }

    /// Call `listener` whenever edits are done, with the boxes outside of which no distance near a surface changed: the
    /// box of everything where all was made again. It is called by the thread that applies edits, after they were applied;
    /// of a GPU, after they were submitted.
    pub fn listen(&mut self, listener: impl FnMut(&[Aabb]) + Send + Sync + 'static) -> Listener {
        self.listeners.add(Box::new(listener))
    }

    /// Call a listener no more; whether it was there.
    pub fn unlisten(&mut self, listener: Listener) -> bool {
        self.listeners.remove(listener)
    }

    /// [`World::differing_cells`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn differing_cells_async(&self) -> Result<Option<u64>, BuildError> {
        let volume = self.volume_async().await?;
        let Some(Volume::Bricks(bricks)) = volume.as_deref() else {
            return Ok(None);
        };
        let program = Program::lower(&self.scene)?;
        // The world's own field follows edits, with tables in another order.
        let field = match &self.gpu {
            Some(own) => Some(GpuField::new(own.gpu().clone(), &program, false)?),
            None => None,
        };
        let field = field.as_ref();
        // The box is found anew: what an edit has put outside of the old one must be there.
        let lattice = match self.kept.lattice() {
            Some(lattice) => Some(found_again(&lattice, &self.scene, &program)?),
            None => None,
        };
        let site = Site {
            field,
            ..self.site(&self.scene, &program)
        };
        let (fresh, _) = self.via.build(&site, lattice).await?;
        let fresh = match (fresh, field) {
            (Kept::Cpu(volume), _) => volume,
            (Kept::Gpu(volume), Some(field)) => volume.read(field.gpu()).await?,
            _ => return Ok(None),
        };
        Ok(match &fresh {
            Volume::Bricks(fresh) => Some(bricks.differing_cells(fresh)),
            _ => None,
        })
    }
}
