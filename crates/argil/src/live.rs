//! Following a scene in place.

use crate::representation::{Kept, budget_on};
use crate::{BricksOptions, BuildError, Engine, Scene};
use argil_field::{LiveProgram, Program};
use argil_gpu::{GpuField, GpuVolume};
use argil_math::Aabb;
use argil_volume::{BrickEdit, BrickLayout, Bricks, EditWork, Volume};
use web_time::{Duration, Instant};

/// How much of an edit is done at once, and what first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Milliseconds that may be taken, about. A GPU takes on as much as it is expected to do in that time.
    pub budget_ms: f64,
    /// What is near to it comes first: the camera's eye.
    pub eye: [f32; 3],
}

/// What following a scene's edits did to a world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Applied {
    /// What was done to bricks. Not known of a GPU, which is not waited for: see [`World::finish`](crate::World::finish).
    pub counts: Option<BrickEdit>,
    /// Blocks of 4³ cells that are left to be done, where a [`Pace`] was given: the next call goes on with them.
    pub blocks_left: u64,
    /// Outside this box no distance within the stored band changed, nor did a material.
    pub dirty_box: Aabb,
    /// Milliseconds; of a GPU, those of the CPU.
    pub duration_ms: f64,
    /// Whether everything was made again and not only what the edits touched.
    pub rebuilt: bool,
}

/// No scene's identity: what was followed is not what the bricks are.
const LOST: u64 = 0;

/// Bricks, wherever they are.
pub(crate) enum Clay<'a> {
    Cpu(&'a mut Bricks),
    Gpu(&'a mut GpuVolume, &'a mut GpuField),
}

impl<'a> Clay<'a> {
    /// Of a world; nothing where it is not kept as bricks, or its shaders are for one scene alone.
    pub fn of(kept: &'a mut Kept, field: Option<&'a mut GpuField>) -> Option<Self> {
        match (kept, field) {
            (Kept::Cpu(Volume::Bricks(bricks)), _) => Some(Self::Cpu(bricks)),
            (Kept::Gpu(volume), Some(field))
                if volume.brick_layout().is_some() && !field.is_specialized() =>
            {
                Some(Self::Gpu(volume, field))
            }
            _ => None,
        }
    }

    fn layout(&self) -> Option<BrickLayout> {
        match self {
            Self::Cpu(bricks) => Some(*bricks.layout()),
            Self::Gpu(volume, _) => volume.brick_layout().copied(),
        }
    }
}

/// How far a world has followed its scene.
pub(crate) struct Live {
    /// The scene's, or [`LOST`].
    identity: u64,
    /// Changes of the scene that the world knows.
    seen: usize,
    /// Made when it is first needed.
    program: Option<LiveProgram>,
    /// What is left to be done.
    work: EditWork,
    /// The boxes of edits that are not done.
    undone: Vec<Aabb>,
    /// What was done on the CPU since it was last asked for.
    done: BrickEdit,
}

impl Live {
    pub fn of(scene: &Scene) -> Self {
        Self {
            identity: scene.identity(),
            seen: scene.changes().len(),
            program: None,
            work: EditWork::default(),
            undone: Vec::new(),
            done: BrickEdit::default(),
        }
    }

    /// Whether a scene is the one that was built, and nothing changed that the world does not know.
    pub fn has_seen_all(&self, scene: &Scene) -> bool {
        self.identity == scene.identity() && self.seen == scene.changes().len()
    }

    /// Whether a scene is the one that was built, with boxes as large as the bricks need them.
    fn knows(&self, scene: &Scene, bands: [f32; 2]) -> bool {
        let is_told = scene
            .bands()
            .iter()
            .zip(bands)
            .all(|(told, needed)| *told >= needed);
        self.identity == scene.identity() && self.seen <= scene.changes().len() && is_told
    }

    /// Follow a scene's changes with bricks; `before` is the program that they were made of, where it is not followed yet.
    /// Nothing where everything is to be made again.
    ///
    /// # Errors
    /// If the scene cannot be lowered: nothing is changed then; or if its bricks take too much: everything is to be made again
    /// the next time.
    pub async fn follow(
        &mut self,
        scene: &Scene,
        mut clay: Clay<'_>,
        before: Option<&Program>,
        (engine, options): (&Engine, &BricksOptions),
        pace: Option<Pace>,
    ) -> Result<Option<Applied>, BuildError> {
        let start = Instant::now();
        let Some(layout) = clay.layout() else {
            return Ok(None);
        };
        let bands = self.tables().or(before).map(|tables| layout.bands(tables));
        if !bands.is_some_and(|bands| self.knows(scene, bands)) {
            return Ok(None);
        }
        let changes = &scene.changes()[self.seen..];
        let live = match &mut self.program {
            Some(live) => {
                if live.follow(scene, changes)?.everything {
                    self.identity = LOST;
                    return Ok(None);
                }
                live
            }
            None => {
                let Some(before) = before else {
                    return Ok(None);
                };
                let live = LiveProgram::new(scene, layout.parts(before))?;
                if !live.relies_on_the_same_as(before) {
                    return Ok(None);
                }
                self.program.insert(live)
            }
        };
        self.seen = scene.changes().len();
        if let Clay::Gpu(_, field) = &mut clay
            && let Err(error) = field.follow(live)
        {
            return Err(self.lost(error.into()));
        }
        let boxes: Vec<[Aabb; 2]> = changes.iter().map(|c| [c.dirty_box, c.far_box]).collect();
        let left = std::mem::take(&mut self.work);
        self.work = EditWork::new(&layout, live, &boxes);
        self.work.take_on(&layout, live, left);
        self.undone.extend(boxes.iter().map(|[dirty, _]| *dirty));
        if let Some(pace) = pace {
            self.work.sort_by_distance(&layout, pace.eye.into());
        }
        let counts = match self.go_on(clay, (engine, options), pace, start).await {
            Ok(counts) => counts,
            Err(error) => return Err(self.lost(error)),
        };
        let dirty_box = boxes
            .iter()
            .fold(Aabb::EMPTY, |all, [own, _]| all.union(*own));
        Ok(Some(Applied {
            counts,
            blocks_left: self.work.blocks(),
            dirty_box,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: false,
        }))
    }

    /// Go on with what is left to be done.
    async fn go_on(
        &mut self,
        clay: Clay<'_>,
        (engine, options): (&Engine, &BricksOptions),
        pace: Option<Pace>,
        start: Instant,
    ) -> Result<Option<BrickEdit>, BuildError> {
        let Some(live) = &self.program else {
            return Ok(None);
        };
        let budget = budget_on(engine, options);
        // A number that is none, or is no time, is the least there is.
        let within = pace.map(|pace| {
            let seconds = (pace.budget_ms * 1e-3).clamp(0.0, 1e6);
            Duration::try_from_secs_f64(seconds).unwrap_or_default()
        });
        match clay {
            Clay::Cpu(bricks) => {
                let until = within.map(|within| start + within);
                let edit = bricks.edit(live, &mut self.work, budget, until)?;
                self.done += edit;
                Ok(Some(edit))
            }
            Clay::Gpu(volume, field) => {
                volume
                    .edit(field, live, &mut self.work, budget, within)
                    .await?;
                Ok(None)
            }
        }
    }

    /// The program has gone ahead of the bricks: everything is to be made again the next time.
    fn lost(&mut self, error: BuildError) -> BuildError {
        self.identity = LOST;
        self.work = EditWork::default();
        self.undone.clear();
        error
    }

    /// Do what is left to be done and wait for it; what edits did since this was last called.
    pub async fn finish(
        &mut self,
        mut clay: Clay<'_>,
        machine: (&Engine, &BricksOptions),
    ) -> Result<BrickEdit, BuildError> {
        let again = match &mut clay {
            Clay::Cpu(bricks) => Clay::Cpu(bricks),
            Clay::Gpu(volume, field) => Clay::Gpu(volume, field),
        };
        if let Err(error) = self.go_on(again, machine, None, Instant::now()).await {
            return Err(self.lost(error));
        }
        match clay {
            Clay::Cpu(_) => Ok(std::mem::take(&mut self.done)),
            Clay::Gpu(volume, field) => Ok(volume.settle(field.gpu()).await?),
        }
    }

    /// The boxes of edits that are done by now and were not told.
    pub fn told(&mut self) -> Vec<Aabb> {
        if self.work.is_done() {
            std::mem::take(&mut self.undone)
        } else {
            Vec::new()
        }
    }

    /// What holds of the whole, and the tables, if the scene was followed.
    pub fn tables(&self) -> Option<&Program> {
        self.program.as_ref().map(LiveProgram::program)
    }

    /// The whole program as it is now, if the scene was followed.
    pub fn whole(&self) -> Option<Program> {
        self.program.as_ref().map(LiveProgram::whole)
    }
}
