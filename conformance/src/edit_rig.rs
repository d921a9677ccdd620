//! Sparse bricks under edits, for tests and benchmarks.

use crate::Wait;
use crate::voxel_grid;
use argil_field::{IncrementalProgram, Program};
use argil_gpu::{Gpu, GpuProgram, GpuVolume, wgpu};
use argil_math::Aabb;
use argil_scene::{MarginRequest, Scene};
use argil_volume::{
    BrickCell, BrickLayout, BrickPendingEdits, BrickSettings, Bricks, EditQueue, EditStats, Volume,
};
use glam::IVec3;
use std::borrow::Cow;
use std::cell::RefCell;
use std::sync::Arc;

/// Bricks on a device.
#[derive(Debug)]
enum RigVolume {
    Cpu(Box<Bricks>),
    Gpu(Box<GpuVolume>),
}

impl RigVolume {
    /// Bakes a program, with the field of a GPU if there is one.
    fn bake(field: Option<&mut GpuProgram>, program: &Program, layout: BrickLayout) -> Self {
        let Some(field) = field else {
            let (bricks, _) = Bricks::bake(program, layout, None).expect("bricks");
            return Self::Cpu(Box::new(bricks));
        };
        field.update(program).expect("a field");
        let (volume, _) = GpuVolume::bricks(field, program, layout, None)
            .wait()
            .expect("bricks");
        Self::Gpu(Box::new(volume))
    }

    fn bricks(&self, gpu: Option<&Gpu>) -> Cow<'_, Bricks> {
        match (self, gpu) {
            (Self::Cpu(bricks), _) => Cow::Borrowed(&**bricks),
            (Self::Gpu(volume), Some(gpu)) => match volume.download(gpu).wait() {
                Ok(Volume::Bricks(bricks)) => Cow::Owned(bricks),
                other => panic!("bricks come back: {:?}", other.err()),
            },
            (Self::Gpu(_), None) => panic!("a volume of a GPU has one"),
        }
    }
}

/// Bricks that follow a scene.
#[derive(Debug)]
pub struct EditRig {
    /// Layout of the bricks.
    pub layout: BrickLayout,
    /// On a GPU, the field of edits, and the one of fresh bakes. They keep the shaders that they have compiled.
    field: Option<GpuProgram>,
    fresh: RefCell<Option<GpuProgram>>,
    kept: RigVolume,
    live: IncrementalProgram,
    seen: usize,
    /// Edits that a host is to submit, and the number of those so far.
    encoder: Option<wgpu::CommandEncoder>,
    encoded: u32,
    /// Makes the scene record dirty boxes with the margins that the bricks need.
    watch: MarginRequest,
    /// Number of rebuilds.
    pub rebakes: usize,
    /// Statistics of edits. On a GPU they are complete after `settle`.
    pub done: EditStats,
}

impl EditRig {
    /// Bakes a scene on the CPU, and requests the margins for its edits.
    pub fn of(scene: &mut Scene, resolution: u32, settings: &BrickSettings) -> Self {
        Self::on(None, scene, resolution, settings)
    }

    /// Bakes a scene on a GPU or, without one, on the CPU.
    pub fn on(
        gpu: Option<Arc<Gpu>>,
        scene: &mut Scene,
        resolution: u32,
        settings: &BrickSettings,
    ) -> Self {
        let program = Program::lower(scene).expect("a program");
        let layout = BrickLayout::new(voxel_grid(scene, &program, resolution), settings);
        let layout = layout.expect("a layout");
        let watch = scene.request_margins(layout.margins(&program));
        let field_of = |gpu: Arc<Gpu>| GpuProgram::new(gpu, &program, false).expect("a field");
        let mut field = gpu.clone().map(field_of);
        Self {
            layout,
            kept: RigVolume::bake(field.as_mut(), &program, layout),
            field,
            fresh: RefCell::new(gpu.map(field_of)),
            live: IncrementalProgram::new(scene, layout.parts(&program)).expect("a program"),
            seen: scene.change_count(),
            encoder: None,
            encoded: 0,
            watch,
            rebakes: 0,
            done: EditStats::default(),
        }
    }

    /// Applies the edits since the last call, in one pass.
    pub fn follow(&mut self, scene: &mut Scene) {
        let changes = scene.changes_since(self.seen).expect("changes");
        let upset = self.live.update(scene, changes).expect("a program");
        let boxes: Vec<_> = changes.iter().flat_map(|c| c.boxes()).collect();
        let program = Program::lower(scene).expect("a program");
        let solid = program.aabb();
        let is_cut = !solid.is_finite() && !solid.is_empty();
        let before = self.layout;
        let turns = is_cut != self.layout.voxel_grid().is_clipped;
        if turns {
            let voxel_grid = self.layout.voxel_grid().recomputed(solid, frame_of(scene));
            let layout = self.layout.with_grid(voxel_grid.expect("a voxel grid"));
            self.layout = layout.expect("a layout");
        } else {
            self.layout = self.layout.grown_to(solid).expect("a layout");
            match &mut self.kept {
                RigVolume::Cpu(bricks) => bricks.grow(self.layout),
                RigVolume::Gpu(volume) => volume.grow(&BrickPendingEdits::of(self.layout)),
            }
        }
        let work = EditQueue::new(&self.layout, &before, &self.live, &boxes);
        let Some(work) = work.filter(|_| !upset.needs_rebuild && !turns) else {
            self.watch.set(self.layout.margins(&program));
            self.kept = RigVolume::bake(self.field.as_mut(), &program, self.layout);
            self.live =
                IncrementalProgram::new(scene, self.layout.parts(&program)).expect("a program");
            self.rebakes += 1;
            self.seen = scene.change_count();
            return;
        };
        let mut edits = BrickPendingEdits::of(self.layout);
        edits.queue = work;
        match (&mut self.kept, &mut self.field) {
            (RigVolume::Cpu(bricks), _) => {
                let edit = bricks.edit(&self.live, &mut edits.queue, None, None);
                self.done += edit.expect("bricks");
            }
            (RigVolume::Gpu(volume), Some(field)) => {
                field.update_from(&self.live).expect("a field");
                // In turns, edits are submitted here, by a host, and by a host two at once.
                let gpu = field.gpu();
                let begin = || gpu.device().create_command_encoder(&Default::default());
                let encoder = match self.encoded % 4 {
                    0 => None,
                    _ => Some(self.encoder.get_or_insert_with(begin)),
                };
                let edit = volume
                    .edit(field, &self.live, &mut edits, None, (None, encoder))
                    .wait();
                edit.expect("an edit");
                if self.encoded % 4 != 1 {
                    self.submit();
                }
                self.encoded += 1;
            }
            (RigVolume::Gpu(_), None) => {}
        }
        self.seen = scene.change_count();
    }

    /// Submits what a host has encoded.
    fn submit(&mut self) {
        if let (Some(encoder), Some(field)) = (self.encoder.take(), &self.field) {
            field.gpu().queue().submit([encoder.finish()]);
        }
    }

    /// Waits for a GPU.
    pub fn settle(&mut self) {
        self.submit();
        if let (RigVolume::Gpu(volume), Some(field)) = (&mut self.kept, &self.field) {
            self.done += volume.flush(field.gpu()).wait().expect("an answer");
        }
    }

    /// Frees memory on a GPU that edits no longer need.
    pub fn trim(&mut self) {
        self.submit();
        if let (RigVolume::Gpu(volume), Some(field)) = (&mut self.kept, &self.field) {
            volume.shrink_to_fit(field).wait().expect("room");
        }
    }

    /// Returns the bricks, downloaded from a GPU.
    pub fn bricks(&self) -> Cow<'_, Bricks> {
        self.kept
            .bricks(self.field.as_ref().map(|field| &**field.gpu()))
    }

    /// Returns the memory of everything in bytes.
    pub fn memory_bytes(&self) -> u64 {
        match &self.kept {
            RigVolume::Cpu(bricks) => bricks.memory_bytes(),
            RigVolume::Gpu(volume) => volume.memory_bytes(),
        }
    }

    /// Counts differences from a fresh bake: cells, table entries, and blocks that should have been
    /// freed.
    pub fn differing(&mut self, scene: &Scene) -> u64 {
        self.compare(scene).0
    }

    /// Returns what [`EditRig::differing`] counts, and describes the first cell that has a brick in one of the two.
    pub fn compare(&mut self, scene: &Scene) -> (u64, Option<String>) {
        self.settle();
        let program = Program::lower(scene).expect("a program");
        // It has the same box, if that contains the solid.
        let layout = self.layout.grown_to(program.aabb()).expect("a layout");
        let mut field = self.fresh.borrow_mut();
        let fresh = RigVolume::bake(field.as_mut(), &program, layout);
        let fresh = fresh.bricks(field.as_ref().map(|field| &**field.gpu()));
        let edited = self.bricks();
        let tables =
            edited.len().abs_diff(fresh.len()) + edited.mixed().len().abs_diff(fresh.mixed().len());
        let (blocks, most) = (edited.table().len(), fresh.table().len());
        // A box that has grown has more blocks around it.
        let kept = blocks.saturating_sub(3 * most + 64);
        let mut wrong = 0;
        let mut first = None;
        for (_, block) in edited.table().blocks().chain(fresh.table().blocks()) {
            for index in 0..64 {
                let inner = IVec3::new(index % 4, index / 4 % 4, index / 16);
                let cell = 4 * block + inner;
                let pair = (edited.cell(cell), fresh.cell(cell));
                if matches!(pair.0, BrickCell::Brick(_)) != matches!(pair.1, BrickCell::Brick(_)) {
                    let length = layout.cell_length();
                    let center = layout.voxel_grid().corner + (cell.as_vec3() + 0.5) * length;
                    let d = program.distance(center);
                    let place =
                        format!("{cell} of length {length} at {center}, {d} from the solid");
                    first
                        .get_or_insert(format!("{place}: edited {:?}, fresh {:?}", pair.0, pair.1));
                }
                wrong += u64::from(match pair {
                    (
                        BrickCell::Empty {
                            center,
                            is_block_empty,
                        },
                        BrickCell::Empty {
                            center: theirs,
                            is_block_empty: is_rebaked_empty,
                        },
                    ) => {
                        is_block_empty != is_rebaked_empty
                            || (center < 0.0) != (theirs < 0.0) && center * theirs != 0.0
                    }
                    _ => false,
                });
            }
        }
        (
            edited.differing_cells(&fresh) + (tables + kept) as u64 + wrong,
            first,
        )
    }
}

fn frame_of(scene: &Scene) -> Option<Aabb> {
    let frame = scene.view.bounds;
    frame.map(|[min, max]| Aabb::new(min.into(), max.into()))
}
