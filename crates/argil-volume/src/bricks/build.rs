//! Bakes bricks on the CPU.
//!
//! *Practice.* The plan lists the blocks with their programs (`plan.rs`). One run of the interpreter measures the
//! 64 cells of a block. In cells that the surface can pass through, the samples are evaluated brick by brick,
//! straight into the pool. Cells of a block with a long program are pruned one at a time, so that their programs are
//! never in memory together.

use super::bounds::{CellBounds, SLOT_BYTES};
use super::brick_baker::BrickBaker;
use super::candidates::{CandidateBlock, StoredPrograms, candidates, empty_cells_of};
use super::cell_programs::CellPrograms;
use super::inner_cell;
use super::layout::{BrickLayout, BricksError};
use super::plan::BlockPlan;
use super::pool::owners_of_mixed;
use super::sample_offsets::SampleOffsets;
use super::store::BrickStore;
use super::store::PLACES;
use super::table::{BlockTable, FAR_SLOTS};
use super::tables::Bricks;
use crate::{SampleFormat, Texel, Texels};
use argil_abi::{BRICK_MIXED, Instruction};
use argil_field::{Program, Pruner};
use argil_math::Control;
use rayon::prelude::*;
use web_time::Instant;

/// Durations of the stages of a build, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BrickTimings {
    /// Pruning, and selecting cells.
    pub prune: f64,
    /// Sampling bricks.
    pub fill: f64,
    /// Removing dropped bricks, and marking empty blocks.
    pub release: f64,
}

pub(super) fn bake(
    program: &Program,
    layout: BrickLayout,
    budget: Option<u64>,
    (stored, control): (StoredPrograms, &Control),
) -> Result<(Bricks, CellPrograms, BrickTimings), BricksError> {
    let start = Instant::now();
    let refuse = |bricks: usize, needed: u64| match budget {
        Some(budget) if needed > budget => Err(BricksError::Budget {
            bricks: bricks as u64,
            needed,
            budget,
        }),
        _ => Ok(()),
    };
    let bounds = CellBounds::new(program, &layout);
    let plan = BlockPlan::of(program, &layout, budget, control)?;
    check(control)?;
    let slots = u64::from(FAR_SLOTS) + plan.blocks.len() as u64;
    refuse(0, SLOT_BYTES * slots)?;
    let table = BlockTable::of(&layout, &plan);
    let tables = table.memory_bytes() + (SLOT_BYTES - 12) * slots;

    control.begin("blocks", plan.blocks.len() as u64);
    let (candidates, mut words) = candidates(program, &layout, &bounds, (&plan, stored), control);
    check(control)?;
    let needs_plan = candidates.iter().any(|block| block.long.is_some());
    let long = if needs_plan {
        plan.instructions
    } else {
        Vec::new()
    };
    let count: usize = candidates.iter().map(|c| c.cells.len()).sum();
    let needed = tables + count as u64 * (layout.brick_bytes() + 8);
    refuse(count, needed)?;
    layout.check_count(count as u64)?;
    let pruned = start.elapsed();
    // Fill the bricks, drop clear ones, and close the gaps.
    control.begin("bricks", count as u64);
    let (filled, at) = match layout.encoding.format {
        SampleFormat::Snorm8 => fill::<i8>(
            program,
            &layout,
            &bounds,
            (&candidates, &long, &table, control),
            count,
            &mut words,
        ),
        SampleFormat::Snorm16 => fill::<i16>(
            program,
            &layout,
            &bounds,
            (&candidates, &long, &table, control),
            count,
            &mut words,
        ),
    };
    check(control)?;
    let masks: Vec<u64> = words
        .par_chunks_mut(64)
        .with_min_len(256)
        .map(empty_cells_of)
        .collect();
    let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
    let stages = BrickTimings {
        prune: ms(pruned),
        fill: ms(at.duration_since(start) - pruned),
        release: ms(at.elapsed()),
    };
    let store = BrickStore {
        words,
        cell_of_brick: filled.owners,
        brick_of_mixed: owners_of_mixed(&filled.materials, &filled.mixed),
        changes: Default::default(),
        materials: filled.materials,
        mixed: filled.mixed,
        pool: filled.pool,
    };
    let bricks = Bricks {
        layout,
        lipschitz: program.lipschitz(),
        table: table.clone(),
        masks,
        store,
    };
    // The number of mixed bricks was not known before.
    refuse(bricks.len(), bricks.memory_bytes())?;
    Ok((bricks, CellPrograms::new(layout, table, candidates), stages))
}

fn check(control: &Control) -> Result<(), BricksError> {
    if control.is_cancelled() {
        Err(BricksError::Cancelled)
    } else {
        Ok(())
    }
}

/// Samples the bricks of all candidates. If no surface can pass through one, its cell keeps a distance.
fn fill<T: Texel>(
    program: &Program,
    layout: &BrickLayout,
    bounds: &CellBounds<'_>,
    (candidates, long, table, control): (&[CandidateBlock], &[Instruction], &BlockTable, &Control),
    count: usize,
    words: &mut [u32],
) -> (Filled, Instant) {
    let samples = layout.brick_samples() as usize;
    let fill = layout.encoding.fill_uniform(program, &layout.voxel_grid, 0);
    let mut pool = vec![T::default(); count.max(1) * samples];
    let mut owners = vec![0u32; count];
    let mut materials = vec![0u32; count];

    // Each block's own parts of the pool and of the words.
    let (mut pool_left, mut words_left, mut done) = (&mut pool[..], &mut *words, 0);
    let mut owners_left = &mut owners[..];
    let mut materials_left = &mut materials[..];
    let mut brick = 0u32;
    let mut jobs = Vec::with_capacity(candidates.len());
    for found in candidates {
        let n = found.cells.len();
        let (own_pool, rest) = pool_left.split_at_mut(n * samples);
        pool_left = rest;
        let (own_owners, rest) = owners_left.split_at_mut(n);
        owners_left = rest;
        let (own_materials, rest) = materials_left.split_at_mut(n);
        materials_left = rest;
        let (_, rest) = words_left.split_at_mut((found.slot - done) * 64);
        let (own_words, rest) = rest.split_at_mut(64);
        (words_left, done) = (rest, found.slot + 1);
        jobs.push(FillJob {
            found,
            first: brick,
            pool: own_pool,
            owners: own_owners,
            materials: own_materials,
            words: own_words,
        });
        brick += n as u32;
    }
    let places = SampleOffsets::new(layout);
    let worker = || FillWorker {
        layout,
        bounds,
        table,
        long,
        baker: BrickBaker::new(program, layout, &fill, &places),
        pruner: Pruner::new(program),
        list: Vec::new(),
    };
    let mixed: Vec<Vec<[u32; 2]>> = jobs
        .into_par_iter()
        .map_init(worker, |worker, job| {
            control.advance(job.found.cells.len() as u64);
            match control.is_cancelled() {
                true => Vec::new(),
                false => worker.fill(job),
            }
        })
        .collect();

    // Each block has numbered its mixed bricks from 0.
    let (mut brick, mut before) = (0, 0);
    for (found, own) in candidates.iter().zip(&mixed) {
        for material in &mut materials[brick..brick + found.cells.len()] {
            if *material & BRICK_MIXED != 0 {
                *material += before;
            }
        }
        brick += found.cells.len();
        before += (own.len() / PLACES) as u32;
    }
    let at = Instant::now();
    close_gaps(&mut pool, &mut owners, &mut materials, samples, words);
    let filled = Filled {
        pool: Texels::from_vec(pool),
        owners,
        materials,
        mixed: mixed.concat(),
    };
    (filled, at)
}

/// A block's candidates, and its own parts of what is filled.
struct FillJob<'a, T> {
    found: &'a CandidateBlock,
    /// The number of its first brick.
    first: u32,
    pool: &'a mut [T],
    owners: &'a mut [u32],
    materials: &'a mut [u32],
    words: &'a mut [u32],
}

/// Samples the bricks of blocks, for one thread.
struct FillWorker<'a> {
    layout: &'a BrickLayout,
    bounds: &'a CellBounds<'a>,
    table: &'a BlockTable,
    /// The plan's programs, if some blocks have long ones.
    long: &'a [Instruction],
    baker: BrickBaker<'a>,
    pruner: Pruner<'a>,
    /// A cell's program, if the block's is long.
    list: Vec<Instruction>,
}

impl FillWorker<'_> {
    /// Samples a block's bricks. Returns its mixed materials.
    fn fill<T: Texel>(&mut self, job: FillJob<'_, T>) -> Vec<[u32; 2]> {
        let FillJob {
            found, words, pool, ..
        } = job;
        let layout = self.layout;
        let mut mixed = Vec::new();
        let corner = self.table.cell(found.slot);
        let bounds = self.bounds.of_block(layout, corner);
        let long = found.long.clone().map(|range| &self.long[range]);
        if let Some(long) = long {
            CandidateBlock::classify_again(layout, corner, long, &mut self.pruner);
        }
        let bricks = pool.chunks_exact_mut(layout.brick_samples() as usize);
        let bricks = bricks.zip(job.owners).zip(job.materials);
        for ((k, (inner, range)), ((out, owner), material)) in (0..).zip(&found.cells).zip(bricks) {
            let cell = corner + inner_cell(usize::from(*inner));
            let mut own = &found.instructions[range.clone()];
            if let Some(long) = long {
                self.list.clear();
                self.pruner
                    .prune_into(long, usize::from(*inner), &mut self.list);
                own = &self.list;
            }
            let least = self.baker.brick(own, cell, out);
            // At most half of a voxel's diagonal from a sample.
            let reach = 0.5 * 3f32.sqrt() * layout.voxel_grid.voxel_size;
            *owner = u32::MAX;
            if !bounds.is_clear(least, reach) {
                *owner = (found.slot * 64) as u32 + u32::from(*inner);
                words[usize::from(*inner)] = job.first + k;
                *material = self
                    .baker
                    .material(own, (cell, bounds.lipschitz()), &mut mixed);
            }
        }
        mixed
    }
}

/// Filled bricks.
struct Filled {
    pool: Texels,
    owners: Vec<u32>,
    materials: Vec<u32>,
    mixed: Vec<[u32; 2]>,
}

/// Moves the last bricks into the places of dropped ones.
fn close_gaps<T: Texel>(
    pool: &mut Vec<T>,
    owners: &mut Vec<u32>,
    materials: &mut Vec<u32>,
    samples: usize,
    words: &mut [u32],
) {
    let mut gap = 0;
    while gap < owners.len() {
        if owners[gap] != u32::MAX {
            gap += 1;
            continue;
        }
        let last = owners.len() - 1;
        if last > gap && owners[last] != u32::MAX {
            pool.copy_within(last * samples..(last + 1) * samples, gap * samples);
            owners[gap] = owners[last];
            materials[gap] = materials[last];
            words[owners[gap] as usize] = gap as u32;
            gap += 1;
        }
        owners.truncate(last);
    }
    pool.truncate(owners.len().max(1) * samples);
    pool.shrink_to_fit();
    owners.shrink_to_fit();
    materials.truncate(owners.len());
    materials.shrink_to_fit();
}

impl Bricks {
    /// Bakes a field on rayon's current threads. Returns the bricks and the timings.
    ///
    /// # Errors
    /// If the bricks and tables would exceed `budget` bytes.
    pub fn bake(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, BrickTimings), BricksError> {
        Self::bake_with_control(program, layout, budget, &Control::default())
    }

    /// Bakes as [`Bricks::bake`] does, reports progress as the stages "blocks" and "bricks", and can be canceled.
    ///
    /// # Errors
    /// If the bricks and tables would exceed `budget` bytes, or if it was canceled.
    pub fn bake_with_control(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<(Self, BrickTimings), BricksError> {
        let baked = bake(program, layout, budget, (StoredPrograms::Short, control));
        baked.map(|(bricks, _, stages)| (bricks, stages))
    }

    /// Bakes as [`Bricks::bake`] does, and also returns the pruned programs of cells near the surface.
    ///
    /// # Errors
    /// If the bricks and tables would exceed `budget` bytes.
    pub fn bake_with_programs(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, CellPrograms, BrickTimings), BricksError> {
        bake(
            program,
            layout,
            budget,
            (StoredPrograms::All, &Control::default()),
        )
    }

    /// Bakes as [`Bricks::bake_with_programs`] does, reports progress, and can be canceled.
    ///
    /// # Errors
    /// If the bricks and tables would exceed `budget` bytes, or if it was canceled.
    pub fn bake_with_programs_and_control(
        program: &Program,
        layout: BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<(Self, CellPrograms, BrickTimings), BricksError> {
        bake(program, layout, budget, (StoredPrograms::All, control))
    }
}
