//! Following a scene in place.

use crate::memory::budget_on;
use crate::representation::Kept;
use crate::{BuildError, Change, Engine, Scene};
use argil_field::{LiveProgram, Program};
use argil_gpu::{GpuField, GpuVolume};
use argil_math::Aabb;
use argil_scene::{Extents, Watch};
use argil_volume::{BrickEdit, BricksError, Edits, Volume};
use web_time::{Duration, Instant};

/// How much of an edit is done at once, and what first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Milliseconds that may be taken, about. A GPU takes on as much as it is expected to do in that time.
    pub budget_ms: f64,
    /// What is near to it comes first: the camera's eye.
    pub eye: [f32; 3],
}

/// What following a scene's edits did to a world. What was done to bricks [`World::finish`](crate::World::finish) tells, as a GPU is
/// waited for then.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Applied {
    /// Blocks of 4³ cells that are left to be done, where a [`Pace`] was given: the next call goes on with them.
    pub blocks_left: u64,
    /// Outside this box no distance within the stored band changed, nor did a material.
    pub dirty_box: Aabb,
    /// Milliseconds; of a GPU, those of the CPU.
    pub duration_ms: f64,
    /// Whether everything was made again and not only what the edits touched.
    pub rebuilt: bool,
    /// Why, if it was.
    pub reason: Option<Rebuilt>,
}

/// Why everything was made again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Rebuilt {
    /// Only sparse bricks are changed in place.
    #[error("only sparse bricks are edited in place: this world is kept in another way")]
    Kept,
    /// The scene reaches beyond the volume's box, and only sparse bricks grow.
    #[error(
        "the scene reaches beyond the volume's box: it was built for a larger one, with voxels of the same size"
    )]
    Box,
    /// What is endless is cut by the box, and came or went.
    #[error("something endless came or went, and what is endless is cut by the volume's box")]
    Cut,
    /// All distances are relied on in another way than before.
    #[error(
        "what all distances are relied on for has changed: materials, or how steep they are or jump"
    )]
    Reliance,
    /// The world came to need to know more of edits than they told, as it has grown since.
    #[error("the world has grown so much that it needs to know more of edits than they told")]
    Bands,
    /// Another scene than the one that the world was built from.
    #[error("it is another scene than the one that the world was built from")]
    Scene,
    /// Changes of the scene that the world has not seen are gone.
    #[error("the scene has forgotten changes that the world has not followed")]
    Forgotten,
    /// The edit touches so much that a bake is as soon done.
    #[error("the edit touches so much of the world that a bake is as soon done")]
    Wide,
    /// Shaders were compiled for the scene as it was.
    #[error("the world's shaders were compiled for the scene as it was")]
    Specialized,
    /// An earlier edit was refused half-way.
    #[error("an edit before was refused, and everything is made again after that")]
    Refused,
}

/// What came of following edits in place.
pub(crate) enum Followed {
    InPlace(Applied),
    /// Everything is to be made again.
    Not(Rebuilt),
}

/// No scene's identity: what was followed is not what the bricks are.
const LOST: u64 = 0;

/// A volume that is changed in place, wherever it is.
pub(crate) enum Editable<'a> {
    Cpu(&'a mut Volume),
    Gpu(&'a mut GpuVolume, &'a mut GpuField),
}

impl<'a> Editable<'a> {
    /// Of a world; nothing where it is kept as no volume, or its shaders are for one scene alone.
    pub fn of(kept: &'a mut Kept, field: Option<&'a mut GpuField>) -> Option<Self> {
        match (kept, field) {
            (Kept::Cpu(volume), _) => Some(Self::Cpu(volume)),
            (Kept::Gpu(volume), Some(field)) if !field.is_specialized() => {
                Some(Self::Gpu(volume, field))
            }
            _ => None,
        }
    }

    fn again(&mut self) -> Editable<'_> {
        match self {
            Self::Cpu(volume) => Editable::Cpu(volume),
            Self::Gpu(volume, field) => Editable::Gpu(volume, field),
        }
    }

    fn grow(&mut self, edits: &dyn Edits) -> Result<(), BuildError> {
        match self {
            Self::Cpu(volume) => volume.grow(edits),
            Self::Gpu(volume, field) => volume.grow(field.gpu(), edits)?,
        }
        Ok(())
    }
}

/// How far a world has followed its scene.
pub(crate) struct Live {
    /// The scene's, or [`LOST`].
    identity: u64,
    /// Changes of the scene that the world knows.
    seen: usize,
    /// Of what is changed in place: what edits have left to be done.
    edits: Option<Box<dyn Edits>>,
    /// Lets the scene's edits tell as much as that needs.
    watch: Option<Watch>,
    /// Made when it is first needed.
    program: Option<LiveProgram>,
    /// The boxes of edits that are not done.
    undone: Vec<Aabb>,
    /// What is known to have been done since it was last asked for.
    done: BrickEdit,
    /// Why nothing can be followed, where that is so.
    lost_by: Rebuilt,
}

impl Live {
    pub fn of(scene: &Scene) -> Self {
        Self {
            identity: scene.identity(),
            seen: scene.change_count(),
            edits: None,
            watch: None,
            program: None,
            undone: Vec::new(),
            done: BrickEdit::default(),
            lost_by: Rebuilt::Refused,
        }
    }

    /// Has the scene's edits tell boxes for what is changed in place, from now on.
    pub fn watch(&mut self, scene: &Scene, edits: Box<dyn Edits>, program: &Program) {
        self.watch = Some(scene.watch(edits.bands(program)));
        self.edits = Some(edits);
    }

    /// Whether what the world is kept as is changed in place.
    pub fn is_in_place(&self) -> bool {
        self.edits.is_some()
    }

    /// Whether a scene is the one that was built, and nothing changed that the world does not know.
    pub fn has_seen_all(&self, scene: &Scene) -> bool {
        self.identity == scene.identity() && self.seen == scene.change_count()
    }

    /// Why a scene's changes cannot be followed, if they cannot.
    fn hindrance(&self, scene: &Scene) -> Option<Rebuilt> {
        if self.identity == LOST {
            return Some(self.lost_by);
        }
        let is_other = self.identity != scene.identity() || self.seen > scene.change_count();
        is_other.then_some(Rebuilt::Scene)
    }

    /// Follow a scene's changes with bricks; `before` is the program that they were made of, where it is not followed yet.
    /// Or why everything is to be made again.
    ///
    /// # Errors
    /// If the scene cannot be lowered: nothing is changed then; or if its bricks take too much: everything is to be made again
    /// the next time.
    pub async fn follow(
        &mut self,
        scene: &Scene,
        mut kept: Editable<'_>,
        before: Option<&Program>,
        (engine, budget): (&Engine, Option<u64>),
        pace: Option<Pace>,
    ) -> Result<Followed, BuildError> {
        let start = Instant::now();
        let Some(edits) = &self.edits else {
            return Ok(Followed::Not(Rebuilt::Kept));
        };
        let Some(tables) = self.tables().or(before) else {
            return Ok(Followed::Not(Rebuilt::Refused));
        };
        if let Some(reason) = self.hindrance(scene) {
            return Ok(Followed::Not(reason));
        }
        let Some(changes) = scene.changes_since(self.seen) else {
            return Ok(Followed::Not(Rebuilt::Forgotten));
        };
        let needed = edits.least_bands(tables);
        let is_told = |change: &Change| change.bands.iter().zip(needed).all(|(&told, n)| told >= n);
        if !changes.iter().all(is_told) {
            return Ok(Followed::Not(Rebuilt::Bands));
        }
        let first_put;
        let live = match &mut self.program {
            Some(live) => {
                if live.follow(scene, changes)?.everything {
                    return Ok(self.not(Rebuilt::Reliance));
                }
                first_put = None;
                live
            }
            None => {
                let Some(before) = before else {
                    return Ok(Followed::Not(Rebuilt::Refused));
                };
                let live = LiveProgram::new(scene, edits.parts(before))?;
                if !live.relies_on_the_same_as(before) {
                    return Ok(Followed::Not(Rebuilt::Reliance));
                }
                // What of it is new is not known.
                first_put = Some((Aabb::ALL, true));
                self.program.insert(live)
            }
        };
        let put = first_put.unwrap_or_else(|| live.put());
        match self.grow(scene, &mut kept, put) {
            Ok(None) => {}
            Ok(Some(reason)) => return Ok(self.not(reason)),
            // The program has gone ahead, whatever comes of it.
            Err(error) => return Err(self.lost(error)),
        }
        let (Some(live), Some(edits)) = (&mut self.program, &mut self.edits) else {
            return Ok(Followed::Not(Rebuilt::Refused));
        };
        self.seen = scene.change_count();
        if let Some(watch) = &self.watch {
            watch.set(edits.bands(live.program()));
        }
        if let Editable::Gpu(_, field) = &mut kept
            && let Err(error) = field.follow(live)
        {
            return Err(self.lost(error.into()));
        }
        let boxes: Vec<[Aabb; 2]> = changes.iter().flat_map(Change::boxes).collect();
        if !edits.take_on(live, &boxes) {
            return Ok(self.not(Rebuilt::Wide));
        }
        if let Some(pace) = pace {
            edits.sort_by_distance(pace.eye.into());
        }
        self.undone.extend(boxes.iter().map(|[dirty, _]| *dirty));
        if let Err(error) = self.go_on(kept, (engine, budget), pace, start).await {
            return Err(self.lost(error));
        }
        let dirty_box = boxes
            .iter()
            .fold(Aabb::EMPTY, |all, [own, _]| all.union(*own));
        Ok(Followed::InPlace(Applied {
            blocks_left: self.blocks_left(),
            dirty_box,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: false,
            reason: None,
        }))
    }

    /// Have the lattice hold what was put into the scene; why everything is to be made again where that cannot be.
    fn grow(
        &mut self,
        scene: &Scene,
        kept: &mut Editable<'_>,
        (put, touched_ends): (Aabb, bool),
    ) -> Result<Option<Rebuilt>, BuildError> {
        let Some(edits) = &mut self.edits else {
            return Ok(None);
        };
        let lattice = *edits.lattice();
        let held = lattice.aabb().grown(-2.0 * lattice.voxel);
        let is_held = put.is_empty() || (held.contains(put.min) && held.contains(put.max));
        if !touched_ends && (is_held || lattice.is_cut) {
            return Ok(None);
        }
        let solid = Extents::of(scene).outer(Scene::ROOT).aabb;
        let is_endless = !solid.is_finite() && !solid.is_empty();
        if is_endless != lattice.is_cut {
            return Ok(Some(Rebuilt::Cut));
        }
        if edits.grow_to(solid).map_err(BricksError::from)? {
            kept.grow(&**edits)?;
        }
        Ok(None)
    }

    /// Go on with what is left to be done.
    async fn go_on(
        &mut self,
        kept: Editable<'_>,
        (engine, budget): (&Engine, Option<u64>),
        pace: Option<Pace>,
        start: Instant,
    ) -> Result<(), BuildError> {
        let (Some(live), Some(edits)) = (&self.program, &mut self.edits) else {
            return Ok(());
        };
        let budget = budget_on(engine, budget);
        // A number that is none, or is no time, is the least there is.
        let within = pace.map(|pace| {
            let seconds = (pace.budget_ms * 1e-3).clamp(0.0, 1e6);
            Duration::try_from_secs_f64(seconds).unwrap_or_default()
        });
        match kept {
            Editable::Cpu(volume) => {
                let until = within.map(|within| start + within);
                self.done += volume.edit(live, &mut **edits, budget, until)?;
            }
            Editable::Gpu(volume, field) => {
                volume
                    .edit(field, live, &mut **edits, budget, within)
                    .await?;
            }
        }
        Ok(())
    }

    /// Blocks of cells that are left to be done.
    fn blocks_left(&self) -> u64 {
        self.edits.as_ref().map_or(0, |edits| edits.blocks_left())
    }

    /// Everything is to be made again, whatever comes of it now.
    fn not(&mut self, reason: Rebuilt) -> Followed {
        (self.identity, self.lost_by) = (LOST, reason);
        Followed::Not(reason)
    }

    /// The program has gone ahead of the bricks: everything is to be made again the next time.
    fn lost(&mut self, error: BuildError) -> BuildError {
        (self.identity, self.lost_by) = (LOST, Rebuilt::Refused);
        if let Some(edits) = &mut self.edits {
            edits.clear();
        }
        self.undone.clear();
        error
    }

    /// Do what is left to be done and wait for it; what edits did since this was last called.
    pub async fn finish(
        &mut self,
        mut kept: Editable<'_>,
        machine: (&Engine, Option<u64>),
    ) -> Result<BrickEdit, BuildError> {
        let going = self.go_on(kept.again(), machine, None, Instant::now());
        if let Err(error) = going.await {
            return Err(self.lost(error));
        }
        if let Editable::Gpu(volume, field) = kept {
            self.done += volume.settle(field.gpu()).await?;
        }
        Ok(self.take_done())
    }

    /// What is known to have been done since this was last called.
    pub fn take_done(&mut self) -> BrickEdit {
        std::mem::take(&mut self.done)
    }

    /// So many bricks were made anew, after what was done before.
    pub fn made(&mut self, bricks: u64, before: BrickEdit) {
        self.done = before;
        self.done.filled += bricks;
    }

    /// The boxes of edits that are done by now and were not told.
    pub fn told(&mut self) -> Vec<Aabb> {
        if self.blocks_left() == 0 {
            std::mem::take(&mut self.undone)
        } else {
            Vec::new()
        }
    }

    /// The program operand by operand, if the scene was followed.
    pub fn program(&self) -> Option<&LiveProgram> {
        self.program.as_ref()
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
