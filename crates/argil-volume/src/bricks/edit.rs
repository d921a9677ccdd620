//! Changes bricks in place.
//!
//! *Practice.* An edit has two boxes. Outside the dirty box, nothing changed within the stored band. Outside the
//! influence box, nothing changed within the distances that empty cells store. Blocks in the influence box are
//! pruned and measured again, and their cells in the dirty box are sampled again. If the touched instructions are
//! known, a cell is skipped when its pruned programs contain none of them, before and after: its distances are
//! unchanged, bit for bit. With wide blends, that skips most of the boxes. Any number of edits go in one pass. The
//! results are committed to the pool at the end, so nothing changes if they do not fit.

use super::additions::{ReachedBlock, hard_brushes};
use super::block_editor::{BakedBlock, BlockEditor, BlockWorker};
use super::block_program::{BlockProgram, emptied_around};
use super::bounds::{CellBounds, SLOT_BYTES};
use super::candidates::empty_cells_of;
use super::cell::{empty_word, is_brick};
use super::edit_queue::{EditBatch, EditQueue};
use super::pool::Pool;
use super::sample_offsets::SampleOffsets;
use super::store::PLACES;
use super::table::FAR_SLOTS;
use super::{BLOCK_SIDE, BrickLayout, Bricks, BricksError};
use crate::{SampleFormat, Texel};
use argil_abi::FillUniform;
use argil_field::{Additions, CELLS_PER_BATCH, IncrementalProgram, PartGrid, Program};
use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use web_time::Instant;

/// Blocks along the side of a part that shares a program. With many brushes, its program should not contain all of
/// them.
const PART_SIDE: u32 = 4;
const SMALL_PART_SIDE: u32 = 2;
/// More brushes or instructions than this are many.
const MANY: usize = 500;

/// What edits did to bricks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EditStats {
    /// Bricks that were sampled.
    pub filled: u64,
    /// Bricks that were added.
    pub added: u64,
    /// Bricks that were removed.
    pub removed: u64,
    /// Cells that were measured.
    pub cells: u64,
}

impl std::ops::AddAssign for EditStats {
    fn add_assign(&mut self, other: Self) {
        self.filled += other.filled;
        self.added += other.added;
        self.removed += other.removed;
        self.cells += other.cells;
    }
}

/// A block to rebuild.
enum EditJob {
    /// Some cells, with the whole block's program.
    Listed(u64, BlockProgram),
    /// Cells in which something can have changed, with their program.
    Reached(ReachedBlock),
}

impl EditJob {
    /// Rebuilds the block. If it is late, returns the block's first cell and the cells that remain.
    fn run<T: Texel>(
        self,
        edit: &BlockEditor<'_>,
        worker: &mut BlockWorker<'_>,
        index: usize,
        bricks: &Bricks,
    ) -> Result<BakedBlock<T>, (IVec3, u64)> {
        // The first one begins however late it is, so that each call gets on.
        let is_late = index > 0 && edit.is_late(worker.slowest_block);
        match self {
            Self::Listed(cells, lists) if is_late => Err((lists.first, cells)),
            Self::Reached(block) if is_late => Err((block.first, block.cells)),
            Self::Listed(cells, lists) => Ok(edit.make(worker, &lists, cells, bricks)),
            Self::Reached(block) => {
                let lists = block.list(&edit.layout, edit.live);
                Ok(edit.make(worker, &lists, block.cells, bricks))
            }
        }
    }
}

impl BrickLayout {
    /// Returns the grid of parts for an [`IncrementalProgram`] of these bricks.
    pub fn parts(&self, program: &Program) -> PartGrid {
        let blocks = if program.brush_count() > MANY {
            SMALL_PART_SIDE
        } else {
            PART_SIDE
        };
        let side = blocks * BLOCK_SIDE;
        PartGrid {
            corner: self.voxel_grid.corner,
            edge: side as f32 * self.cell_length(),
            far: self.margins(program)[1],
            base: self.base_length(),
        }
    }

    /// Returns the margins that dirty boxes must have: the stored band, and the distance up to which empty cells
    /// store bounds.
    pub fn margins(&self, program: &Program) -> [f32; 2] {
        self.min_margins(program).map(|band| 1.1 * band)
    }

    /// Returns the smallest margins that suffice. A world that grows needs a little more over time, and
    /// [`BrickLayout::margins`] includes it.
    pub fn min_margins(&self, program: &Program) -> [f32; 2] {
        let region = self.region();
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        let rounding = program.rounding_at(self.base_length(), farthest);
        let near = program.lipschitz() * self.half_diagonal(1) + rounding;
        let range = self.encoding.band_width(&self.voxel_grid, 0);
        [near.max(range), (self.far_length() + rounding).max(near)]
    }
}

impl Bricks {
    /// Processes remaining edits on rayon's current threads, all of them or until a point in time, and at least a
    /// little.
    ///
    /// # Errors
    /// If the bricks would exceed `budget` bytes. The batch in progress is lost then.
    pub fn edit(
        &mut self,
        live: &IncrementalProgram,
        work: &mut EditQueue,
        budget: Option<u64>,
        until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        let mut done = EditStats::default();
        // What remains may be as steep as before.
        let lipschitz = live.program().lipschitz();
        self.lipschitz = self.lipschitz.max(lipschitz);
        let mut count = if until.is_some() {
            rayon::current_num_threads()
        } else {
            usize::MAX
        };
        while !work.is_done() {
            let start = Instant::now();
            let units = work.next(count);
            let processed = match self.layout.encoding.format {
                SampleFormat::Snorm8 => {
                    self.process_batches::<i8>(live, work, units, (budget, until))
                }
                SampleFormat::Snorm16 => {
                    self.process_batches::<i16>(live, work, units, (budget, until))
                }
            };
            let (some, late) = processed?;
            done += some;
            work.put_back(&self.layout, live, &late);
            if let Some(until) = until {
                let now = Instant::now();
                let left = until.saturating_duration_since(now).as_secs_f64();
                if left == 0.0 {
                    break;
                }
                // Half of what seems to fit, because the next blocks may cost more.
                let fits = 0.5 * left / (now - start).as_secs_f64().max(1e-6);
                count = ((count as f64 * fits.min(4.0)) as usize).max(1);
            }
        }
        if work.is_done() {
            self.lipschitz = lipschitz;
        }
        Ok(done)
    }

    /// Rebuilds the blocks of batches. Returns what it did, and the blocks that ran out of time with their remaining cells.
    fn process_batches<T: Texel>(
        &mut self,
        live: &IncrementalProgram,
        work: &EditQueue,
        units: Vec<EditBatch>,
        (budget, until): (Option<u64>, Option<Instant>),
    ) -> Result<(EditStats, Vec<(IVec3, u64)>), BricksError> {
        let bounds = CellBounds::new(live.program(), &self.layout);
        let encoding = &self.layout.encoding;
        let fill = encoding.fill_uniform(live.program(), &self.layout.voxel_grid, 0);
        let touched = work.touched(live);
        let added = touched.and_then(|_| live.added());
        let jobs = self.jobs::<T>(live, work, units, (added.as_ref(), &bounds, &fill));
        let edit = BlockEditor {
            layout: self.layout,
            live,
            touched,
            hard: added.as_ref().map(hard_brushes).unwrap_or_default(),
            added,
            bounds,
            fill,
            places: SampleOffsets::new(&self.layout),
            work,
            until,
        };
        let bricks = &*self;
        // Each thread takes the next job, because a few blocks hold most of the work.
        let jobs = jobs.into_iter().enumerate().par_bridge();
        let mut results: Vec<_> = jobs
            .map_init(
                || edit.worker(),
                |worker, (index, job)| (index, job.run::<T>(&edit, worker, index, bricks)),
            )
            .collect();
        results.sort_unstable_by_key(|(index, _)| *index);
        let (mut made, mut late) = (Vec::with_capacity(results.len()), Vec::new());
        for (_, result) in results {
            match result {
                Ok(block) => made.push(block),
                Err(left) => late.push(left),
            }
        }
        let parts = made.iter().filter(|own| own.late != 0);
        late.extend(parts.map(|own| (own.first, own.late)));
        self.check_budget(&made, budget)?;
        Ok((self.commit(&made, live), late))
    }

    /// Returns the blocks that batches rebuild.
    fn jobs<T: Texel>(
        &self,
        live: &IncrementalProgram,
        work: &EditQueue,
        units: Vec<EditBatch>,
        (added, bounds, fill): (Option<&Additions<'_>>, &CellBounds<'_>, &FillUniform),
    ) -> Vec<EditJob> {
        let Some(added) = added else {
            let lists = work.lists(&self.layout, live, units).into_iter();
            let all = lists.map(|list| EditJob::Listed(work.remaining_cells(list.first), list));
            return all.collect();
        };
        let reached = self.reached::<T>(added, work, &units, (bounds, fill));
        // Boxes are less precise than pruning: with few brushes, a pruned program is shorter.
        let are_many = live.instruction_count() > MANY;
        let is_near = |block: &ReachedBlock| are_many && block.is_near(&self.layout);
        let (near, others): (Vec<_>, Vec<_>) = reached.into_iter().partition(is_near);
        let mut jobs: Vec<EditJob> = near.into_iter().map(EditJob::Reached).collect();
        let lists = work.lists(&self.layout, live, ReachedBlock::units(&others));
        let cells: FxHashMap<IVec3, u64> = others
            .iter()
            .map(|block| (block.first, block.cells))
            .collect();
        let listed = |list: BlockProgram| EditJob::Listed(cells[&list.first], list);
        jobs.extend(lists.into_iter().map(listed));
        jobs
    }

    /// Commits rebuilt blocks to the pool.
    fn commit<T: Texel>(&mut self, made: &[BakedBlock<T>], live: &IncrementalProgram) -> EditStats {
        let mut result = EditStats::default();
        let before = self.store.cell_of_brick.len() as u64;
        let samples = self.layout.brick_samples() as usize;
        // Blocks first, so that their bricks have words. The order does not depend on the number of threads.
        let slots: Vec<usize> = made.iter().map(|own| self.slot_for(own)).collect();
        let mut pool = Pool::<T>::open(&mut self.store, &self.layout);
        // Then what is freed can be reused.
        for (own, &slot) in made.iter().zip(&slots) {
            let first = slot * CELLS_PER_BATCH;
            for (i, &word) in own.words.iter().enumerate() {
                if !is_brick(word) && slot >= FAR_SLOTS as usize {
                    let old = pool.word(first + i);
                    result.removed += u64::from(is_brick(old));
                    pool.clear((first + i) as u32, word);
                }
            }
            result.cells += CELLS_PER_BATCH as u64;
        }
        for (own, &slot) in made.iter().zip(&slots) {
            let mut mixed = own.mixed.chunks_exact(PLACES);
            let texels = own.texels.chunks_exact(samples);
            for (&(i, material), texels) in own.bricks.iter().zip(texels) {
                let own_mixed = if material & argil_abi::BRICK_MIXED != 0 {
                    mixed.next().expect("places of each mixed brick")
                } else {
                    &[]
                };
                pool.put(
                    (slot * CELLS_PER_BATCH) as u32 + u32::from(i),
                    texels,
                    material,
                    own_mixed,
                );
            }
            result.filled += own.sampled;
        }
        pool.close();
        self.finish_blocks(made, &slots, live);
        result.added = (self.store.cell_of_brick.len() as u64 + result.removed) - before;
        result
    }

    /// Updates which cells have bricks in committed blocks, and releases blocks that are far from everything now.
    fn finish_blocks<T>(
        &mut self,
        made: &[BakedBlock<T>],
        slots: &[usize],
        live: &IncrementalProgram,
    ) {
        let mut gone = Vec::new();
        for (own, &slot) in made.iter().zip(slots) {
            self.store.changes.slot(slot as u32);
            let words = &mut self.store.words[slot * CELLS_PER_BATCH..(slot + 1) * CELLS_PER_BATCH];
            match own.far {
                None => self.masks[slot] = empty_cells_of(words),
                Some(inside) => {
                    if slot >= FAR_SLOTS as usize {
                        self.masks[slot] = 0;
                    }
                    gone.push((own.first / BLOCK_SIDE as i32, inside));
                }
            }
        }
        if !gone.is_empty() {
            gone.extend(emptied_around(&self.table, &self.layout, live, &gone));
        }
        for (block, inside) in gone {
            self.store.changes.blocks();
            self.table.set_far(block, block + 1, inside);
        }
    }

    /// Returns the slot of a block, and inserts one if needed.
    fn slot_for<T>(&mut self, made: &BakedBlock<T>) -> usize {
        let block = made.first / BLOCK_SIDE as i32;
        if made.far.is_some() {
            return self.table.slot(block) as usize;
        }
        if self.table.find(block).is_none() {
            self.store.changes.blocks();
        }
        let slot = self.table.insert(block) as usize;
        if slot >= self.masks.len() {
            self.masks.resize(slot + 1, 0);
            self.store
                .words
                .resize((slot + 1) * CELLS_PER_BATCH, empty_word(0.0));
        }
        slot
    }

    fn check_budget<T>(
        &self,
        made: &[BakedBlock<T>],
        budget: Option<u64>,
    ) -> Result<(), BricksError> {
        let budget = budget.unwrap_or(u64::MAX);
        let mut bricks = self.store.cell_of_brick.len() as u64;
        let (mut mixed, mut slots) = (0, self.table.slots() as u64);
        for own in made {
            let slot = self.table.slot(own.first / BLOCK_SIDE as i32);
            let old = self.masks[slot as usize].count_ones();
            slots += u64::from(slot < FAR_SLOTS && own.far.is_none());
            let new = own.words.iter().filter(|&&word| is_brick(word)).count();
            bricks = bricks + new as u64 - u64::from(old);
            mixed += size_of_val(&own.mixed[..]) as u64;
        }
        self.layout.check_count(bricks)?;
        let of_each = self.layout.brick_bytes() + 8;
        let needed =
            SLOT_BYTES * slots + bricks * of_each + size_of_val(&self.store.mixed[..]) as u64;
        if needed + mixed > budget && needed + mixed > self.memory_bytes() {
            return Err(BricksError::Budget {
                bricks,
                needed: needed + mixed,
                budget,
            });
        }
        Ok(())
    }
}
