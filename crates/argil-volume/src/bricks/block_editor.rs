//! Rebuilds a block after an edit: decides which cells can have changed, and samples them.

use super::block_program::BlockProgram;
use super::bounds::CellBounds;
use super::brick_baker::{BrickBaker, only_material};
use super::candidates::{CandidateBlock, Wanted, near_block};
use super::cell::{center_of, empty_word, is_brick};
use super::edit_queue::EditQueue;
use super::sample_offsets::SampleOffsets;
use super::{BLOCK_SIDE, BrickLayout, Bricks, inner_cell};
use crate::Texel;
use argil_abi::{FillUniform, Instruction};
use argil_field::{Additions, CELLS_PER_BATCH, ChangeSet, HardBrush, IncrementalProgram, Pruner};
use glam::{IVec3, Vec3};
use std::ops::Range;
use web_time::{Duration, Instant};

/// If more octants than this changed, the whole brick is sampled, because an octant has more than an eighth of a
/// brick's samples.
const MAX_OCTANTS: u32 = 5;
/// A block's new words and bricks.
pub(super) struct BakedBlock<T> {
    /// The block's first cell.
    pub first: IVec3,
    /// Whether the block is far from every surface now, and then whether it is inside.
    pub far: Option<bool>,
    pub words: [u32; CELLS_PER_BATCH],
    /// Cells with a brick: their index, and the brick's material.
    pub bricks: Vec<(u8, u32)>,
    pub texels: Vec<T>,
    pub mixed: Vec<[u32; 2]>,
    /// Bricks of which at least one sample was evaluated.
    pub sampled: u64,
    /// Cells for which there was no time, one bit each. They are as before.
    pub late: u64,
}

/// Moves the lowest bits of `bits` to the positions of the set bits in `places`, in order.
fn scattered(bits: u64, places: u64) -> u64 {
    if places == u64::MAX {
        return bits;
    }
    let all = (0..CELLS_PER_BATCH)
        .filter(|i| places >> i & 1 != 0)
        .enumerate();
    all.fold(0, |out, (index, i)| out | (bits >> index & 1) << i)
}

/// Moves the bits of `bits` at the set positions of `places` to the lowest bits, in order.
fn gathered(bits: u64, places: u64) -> u64 {
    if places == u64::MAX {
        return bits;
    }
    let all = (0..CELLS_PER_BATCH)
        .filter(|i| places >> i & 1 != 0)
        .enumerate();
    all.fold(0, |out, (index, i)| out | (bits >> i & 1) << index)
}

/// What all blocks of an edit share.
pub(super) struct BlockEditor<'a> {
    pub layout: BrickLayout,
    pub live: &'a IncrementalProgram,
    pub bounds: CellBounds<'a>,
    pub fill: FillUniform,
    pub places: SampleOffsets,
    /// What can have changed, if it is known.
    pub touched: Option<&'a ChangeSet>,
    /// The appended brushes, if nothing else was touched.
    pub added: Option<Additions<'a>>,
    /// Appended brushes that alone determine how existing bricks changed. Empty if more must be known.
    pub hard: Vec<HardBrush>,
    pub work: &'a EditQueue,
    /// When to stop, if the time is limited.
    pub until: Option<Instant>,
}

/// The state of a thread.
pub(super) struct BlockWorker<'a> {
    pruner: Pruner<'a>,
    filler: BrickBaker<'a>,
    /// How long it took at most to measure a block.
    pub slowest_block: Duration,
    /// How long it took at most to sample a brick.
    slowest_brick: Duration,
}

impl<T> BakedBlock<T> {
    fn new(first: IVec3, far: Option<bool>) -> Self {
        Self {
            first,
            far,
            words: [empty_word(0.0); CELLS_PER_BATCH],
            bricks: Vec::new(),
            texels: Vec::new(),
            mixed: Vec::new(),
            sampled: 0,
            late: 0,
        }
    }
}

/// Returns the word of a cell in which no stored distance changed, or `None` if it was measured again and has no
/// brick.
fn kept_word(old: u32, is_changed: bool) -> Option<u32> {
    match (is_brick(old), is_changed) {
        (true, _) => Some(old),
        // Whether the whole block is empty is determined later.
        (false, false) => Some(empty_word(center_of(old))),
        (false, true) => None,
    }
}

/// A brick before the edit.
struct PreviousBlock<'a, T> {
    samples: &'a [T],
    look: u32,
}

/// A cell near the surface: its program, and the octants in which something can have changed.
struct NearSurface<'a> {
    list: &'a [Instruction],
    cell: IVec3,
    octants: u8,
    bounds: &'a CellBounds<'a>,
}

/// The cells of a block that edits can have changed.
struct EditedCells<'a> {
    bounds: CellBounds<'a>,
    /// A bit for each cell in which a touched instruction can have mattered.
    changed: u64,
    /// A bit for each cell that the boxes of edits reach.
    dirty: u64,
    /// The octants of each cell in which something can have changed, one bit each.
    octants: [u8; CELLS_PER_BATCH],
    /// The cells near the surface.
    found: CandidateBlock,
}

/// The result of sampling a brick.
enum Sampled {
    /// The brick is unchanged.
    Same,
    /// No surface passes through the cell.
    Clear,
    /// The brick is there. The flag tells whether any sample may differ.
    New(bool),
}

impl BlockEditor<'_> {
    pub(super) fn worker(&self) -> BlockWorker<'_> {
        BlockWorker {
            pruner: Pruner::new(self.live.program()),
            filler: BrickBaker::new(self.live.program(), &self.layout, &self.fill, &self.places),
            slowest_block: Duration::ZERO,
            slowest_brick: Duration::ZERO,
        }
    }

    /// Returns the cells of a block in which a touched instruction can have mattered, one bit each. Uses the
    /// pruner's classification.
    fn mattered(&self, first: IVec3, lists: &BlockProgram, pruner: &mut Pruner<'_>) -> u64 {
        let (Some(before), Some(touched)) = (&lists.previous, self.touched) else {
            return u64::MAX;
        };
        if !touched.intersects(before) {
            return 0;
        }
        let centers: [Vec3; CELLS_PER_BATCH] =
            std::array::from_fn(|i| self.layout.center(first + inner_cell(i), 1));
        let mut d = [0.0; CELLS_PER_BATCH];
        pruner.classify_cells(before, &centers, self.layout.half_diagonal(1), &mut d);
        pruner.affected_cells(before, |instr| touched.contains(instr))
    }

    /// Whether no time is left for work that takes a while.
    pub(super) fn is_late(&self, takes: Duration) -> bool {
        self.until
            .is_some_and(|until| Instant::now() + takes > until)
    }

    /// Measures some of a block's cells, one bit each, and samples the dirty ones, as long as there is time.
    pub(super) fn make<T: Texel>(
        &self,
        worker: &mut BlockWorker<'_>,
        lists: &BlockProgram,
        some: u64,
        bricks: &Bricks,
    ) -> BakedBlock<T> {
        let first = lists.first;
        let mut made = BakedBlock::new(first, lists.far);
        if made.far.is_some() {
            return made;
        }
        let start = self.until.map(|_| Instant::now());
        let bounds = self.bounds.of_block(&self.layout, first);
        let pruner = &mut worker.pruner;
        let (changed, found) = self.measure(pruner, &bounds, (lists, some), &mut made.words);
        // A missing block reads as far.
        let slot = bricks.table.slot(first / BLOCK_SIDE as i32) as usize;
        let old = &bricks.store.words[slot * CELLS_PER_BATCH..(slot + 1) * CELLS_PER_BATCH];
        let dirty = self.work.dirty_cells(&self.layout, self.live, first);
        let lists = (lists, bounds.lipschitz());
        let octants =
            self.octants::<T>(first, lists, changed & dirty, (&found, bricks, old), pruner);
        let slowest = &mut worker.slowest_block;
        *slowest = start.map_or(Duration::ZERO, |start| start.elapsed().max(*slowest));
        let edited = EditedCells {
            bounds,
            changed,
            dirty,
            octants,
            found,
        };
        self.sample_cells(worker, &edited, (bricks, old), &mut made);
        made
    }

    /// Measures some of a block's cells, one bit each. Returns those that edits can have changed, and those near the surface.
    fn measure(
        &self,
        pruner: &mut Pruner<'_>,
        bounds: &CellBounds<'_>,
        (lists, some): (&BlockProgram, u64),
        words: &mut [u32],
    ) -> (u64, CandidateBlock) {
        let (first, instructions) = (lists.first, &lists.current);
        let mut changed = self.mattered(first, lists, pruner);
        let mut select = |pruner: &Pruner<'_>| {
            if let Some(touched) = self.touched.filter(|_| changed != u64::MAX) {
                let needed = pruner.affected_cells(instructions, |instr| touched.contains(instr));
                changed |= scattered(needed, some);
                return gathered(changed, some);
            }
            changed
        };
        let listed = (&instructions[..], some);
        let wanted = Wanted::Programs(&mut select);
        let found = near_block(&self.layout, bounds, first, listed, pruner, words, wanted);
        // The other cells are unchanged.
        (changed & some, found)
    }

    /// Samples the dirty cells of a block, as long as there is time.
    fn sample_cells<T: Texel>(
        &self,
        worker: &mut BlockWorker<'_>,
        edited: &EditedCells<'_>,
        (bricks, old): (&Bricks, &[u32]),
        made: &mut BakedBlock<T>,
    ) {
        let EditedCells {
            bounds,
            changed,
            dirty,
            octants,
            found,
        } = edited;
        let samples = self.layout.brick_samples() as usize;
        let BlockWorker {
            filler,
            slowest_brick,
            ..
        } = worker;
        // The maximum number of bricks, so that they are moved only once.
        let near = found.cells.iter().filter(|&&(i, _)| {
            let i = usize::from(i);
            (changed & dirty) >> i & 1 != 0 && octants[i] != 0
        });
        made.texels.reserve_exact(near.count() * samples);
        let mut next = found.cells.iter().peekable();
        let mut has_sampled = false;
        let added = self.added_in(made.first);
        for (i, &old) in old.iter().enumerate() {
            let list: Option<Range<usize>> = next
                .next_if(|&&(inner, _)| usize::from(inner) == i)
                .map(|(_, range)| range.clone());
            if (changed & dirty) >> i & 1 == 0 {
                let is_changed = changed >> i & 1 != 0;
                made.words[i] = kept_word(old, is_changed).unwrap_or(made.words[i]);
                continue;
            }
            let Some(list) = list else { continue };
            let list = &found.instructions[list];
            let clear = (made.first + inner_cell(i), old);
            if let Some(added) = added.filter(|_| !is_brick(old))
                && self.stays_clear(added, bounds, clear)
            {
                continue;
            }
            if octants[i] == 0 && self.has_same_material(list, bricks.store.materials[old as usize])
            {
                made.words[i] = old;
                continue;
            }
            if has_sampled && self.is_late(*slowest_brick) {
                made.words[i] = kept_word(old, false).unwrap_or(old);
                made.late |= 1 << i;
                continue;
            }
            has_sampled = true;
            let start = self.until.map(|_| Instant::now());
            let was = is_brick(old).then(|| PreviousBlock {
                samples: bricks.samples_of(old),
                look: bricks.store.materials[old as usize],
            });
            let cell = made.first + inner_cell(i);
            let near = NearSurface {
                list,
                cell,
                octants: octants[i],
                bounds,
            };
            match self.sample(filler, &near, was, &mut made.texels) {
                Sampled::Same => made.words[i] = old,
                Sampled::Clear => {}
                Sampled::New(is_other) => {
                    made.sampled += u64::from(is_other);
                    let material = (cell, bounds.lipschitz());
                    let material = filler.material(list, material, &mut made.mixed);
                    made.bricks.push((i as u8, material));
                    // The brick's index is known when it is committed to the pool.
                    made.words[i] = 0;
                }
            }
            *slowest_brick =
                start.map_or(Duration::ZERO, |start| start.elapsed().max(*slowest_brick));
        }
    }

    /// Samples a brick behind `texels`. It stays there unless no surface passes through it or it is unchanged.
    fn sample<T: Texel>(
        &self,
        filler: &mut BrickBaker<'_>,
        near: &NearSurface<'_>,
        was: Option<PreviousBlock<'_, T>>,
        texels: &mut Vec<T>,
    ) -> Sampled {
        let (list, cell) = (near.list, near.cell);
        let reach = 0.5 * 3f32.sqrt() * self.layout.voxel_grid.voxel_size;
        let samples = self.layout.brick_samples() as usize;
        let begin = texels.len();
        let mut changed = near.octants;
        let stays = match &was {
            Some(was) if !self.hard.is_empty() => {
                texels.extend_from_slice(was.samples);
                let out = &mut texels[begin..];
                let least = filler.joined(&self.hard, cell, out);
                // In doubt, the whole program decides.
                let stays = least.is_finite() && !near.bounds.is_clear(least, reach);
                if out == was.samples {
                    changed = 0;
                    // The positions where materials are sampled can have changed all the same.
                    let only = only_material(list, self.live.program().materials());
                    if stays && only == Some(was.look) {
                        texels.truncate(begin);
                        return Sampled::Same;
                    }
                }
                stays
            }
            Some(was) if changed.count_ones() <= MAX_OCTANTS => {
                texels.extend_from_slice(was.samples);
                let out = &mut texels[begin..];
                let is_near = |least: f32| !near.bounds.is_clear(least, reach);
                // What is near enough in a part is near enough in the whole.
                changed == 0
                    || is_near(filler.octants(list, cell, changed, out))
                    || is_near(filler.nearest_stored(out))
            }
            _ => false,
        };
        if !stays {
            texels.resize(begin + samples, T::default());
            let least = filler.brick(list, cell, &mut texels[begin..]);
            if near.bounds.is_clear(least, reach) {
                texels.truncate(begin);
                return Sampled::Clear;
            }
        }
        Sampled::New(changed != 0)
    }
}
