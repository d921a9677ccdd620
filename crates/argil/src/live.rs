//! Following a scene in place.

use crate::representation::{Kept, budget_of};
use crate::{BricksOptions, BuildError, Scene};
use argil_field::{LiveProgram, Program};
use argil_math::Aabb;
use argil_volume::{Bricks, Volume};
use std::time::Instant;

/// What following a scene's edits did to a world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Applied {
    /// Bricks that were sampled.
    pub bricks: u64,
    /// Bricks that there were not before.
    pub added: u64,
    /// Bricks that there are no more.
    pub removed: u64,
    /// Outside this box no distance within the stored band changed, nor did a material.
    pub dirty_box: Aabb,
    /// Milliseconds.
    pub duration_ms: f64,
    /// Whether everything was made again and not only what the edits touched.
    pub rebuilt: bool,
}

/// No scene's identity: what was followed is not what the bricks are.
const LOST: u64 = 0;

/// How far a world has followed its scene.
pub(crate) struct Live {
    /// The scene's, or [`LOST`].
    identity: u64,
    /// Changes of the scene that the world knows.
    seen: usize,
    /// Made when it is first needed.
    program: Option<LiveProgram>,
}

impl Live {
    pub fn of(scene: &Scene) -> Self {
        Self {
            identity: scene.identity(),
            seen: scene.changes().len(),
            program: None,
        }
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
    /// If the scene cannot be lowered: nothing is changed then; or if its bricks take too much: they are then as they were, and
    /// everything is to be made again the next time.
    pub fn follow(
        &mut self,
        scene: &Scene,
        bricks: &mut Bricks,
        before: Option<&Program>,
        options: &BricksOptions,
    ) -> Result<Option<Applied>, BuildError> {
        let start = Instant::now();
        let layout = *bricks.layout();
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
        let boxes: Vec<[Aabb; 2]> = changes.iter().map(|c| [c.dirty_box, c.far_box]).collect();
        let edit = bricks.edit(live, &boxes, budget_of(options));
        if edit.is_err() {
            // The program has gone ahead of the bricks.
            self.identity = LOST;
        }
        let edit = edit?;
        self.seen = scene.changes().len();
        let dirty_box = boxes
            .iter()
            .fold(Aabb::EMPTY, |all, [own, _]| all.union(*own));
        Ok(Some(Applied {
            bricks: edit.filled,
            added: edit.added,
            removed: edit.removed,
            dirty_box,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: false,
        }))
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

/// The bricks on the CPU, if the world is kept so.
pub(crate) fn bricks_of(kept: &mut Kept) -> Option<&mut Bricks> {
    match kept {
        Kept::Cpu(Volume::Bricks(bricks)) => Some(bricks),
        _ => None,
    }
}
