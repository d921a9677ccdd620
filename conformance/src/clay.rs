//! Bricks that are edited, for tests and benchmarks.

use crate::lattice;
use argil_field::{LiveProgram, Program};
use argil_scene::Scene;
use argil_volume::{BrickLayout, BrickSettings, Bricks, Word};

/// Bricks that follow a scene.
pub struct Clay {
    /// Where they lie.
    pub layout: BrickLayout,
    /// They.
    pub bricks: Bricks,
    live: LiveProgram,
    seen: usize,
    /// How often everything had to be made again.
    pub rebakes: usize,
    /// Bricks that edits have sampled.
    pub filled: u64,
}

impl Clay {
    /// Bake a scene; its edits tell the boxes that the bricks need from now on.
    pub fn of(scene: &mut Scene, resolution: u32, settings: &BrickSettings) -> Self {
        let program = Program::lower(scene).expect("a program");
        let layout = BrickLayout::new(lattice(scene, &program, resolution), settings);
        let layout = layout.expect("a layout");
        scene.set_bands(layout.bands(&program));
        Self {
            layout,
            bricks: Bricks::bake(&program, layout, None).expect("bricks").0,
            live: LiveProgram::new(scene, layout.parts(&program)).expect("a program"),
            seen: scene.changes().len(),
            rebakes: 0,
            filled: 0,
        }
    }

    /// Follow its edits since the last time, in one pass.
    pub fn follow(&mut self, scene: &mut Scene) {
        let changes = &scene.changes()[self.seen..];
        let upset = self.live.follow(scene, changes).expect("a program");
        if upset.everything {
            let (rebakes, filled) = (self.rebakes + 1, self.filled);
            let program = Program::lower(scene).expect("a program");
            scene.set_bands(self.layout.bands(&program));
            self.bricks = Bricks::bake(&program, self.layout, None).expect("bricks").0;
            self.live = LiveProgram::new(scene, self.layout.parts(&program)).expect("a program");
            (self.rebakes, self.filled) = (rebakes, filled);
        } else {
            let boxes: Vec<_> = changes.iter().map(|c| [c.dirty_box, c.far_box]).collect();
            let edit = self.bricks.edit(&self.live, &boxes, None).expect("bricks");
            self.filled += edit.filled;
        }
        self.seen = scene.changes().len();
    }

    /// What differs from a fresh bake: cells, and entries of tables that are more or fewer.
    pub fn differing(&self, scene: &Scene) -> u64 {
        let program = Program::lower(scene).expect("a program");
        let fresh = Bricks::bake(&program, self.layout, None).expect("bricks").0;
        let tables = self.bricks.len().abs_diff(fresh.len())
            + self.bricks.mixed().len().abs_diff(fresh.mixed().len())
            + usize::from(self.bricks.masks() != fresh.masks());
        let signs = self.bricks.words().iter().zip(fresh.words());
        let wrong = signs.filter(|&(&own, &theirs)| match (Word::of(own), Word::of(theirs)) {
            (
                Word::Empty { center, lonely },
                Word::Empty {
                    center: theirs,
                    lonely: as_lonely,
                },
            ) => lonely != as_lonely || (center < 0.0) != (theirs < 0.0) && center * theirs != 0.0,
            _ => false,
        });
        self.bricks.differing_cells(&fresh) + tables as u64 + wrong.count() as u64
    }
}
