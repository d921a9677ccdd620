//! Finds the cells where appended brushes can matter, from the bricks themselves. With many brushes, that is faster
//! than pruning.

use super::block_program::BlockProgram;
use super::bounds::CellBounds;
use super::cell::{center_of, is_brick};
use super::edit_queue::{EditBatch, EditQueue};
use super::{BLOCK_SIDE, BrickLayout, Bricks, inner_cell};
use crate::Texel;
use crate::texels::OF_THIS_TYPE;
use argil_abi::FillUniform;
use argil_field::{Additions, CELLS_PER_BATCH, HardBrush, IncrementalProgram};
use glam::IVec3;
use rayon::prelude::*;

/// A block in which something can have changed.
pub(super) struct ReachedBlock {
    part: IVec3,
    /// Its first cell.
    pub first: IVec3,
    /// A bit for each of its cells.
    pub cells: u64,
    /// The largest distance in those cells now. Infinite if it is unknown.
    reach: f32,
}

/// More brushes than this are not joined with existing bricks.
const FEW_BRUSHES: usize = 8;
/// Blocks that one thread examines.
const FEW: usize = 64;

impl ReachedBlock {
    /// Whether a program for the distances that cells store is enough.
    pub(super) fn is_near(&self, layout: &BrickLayout) -> bool {
        self.reach < layout.far_length()
    }

    /// Returns what can matter in those cells, if they are near the surface.
    pub(super) fn list(&self, layout: &BrickLayout, live: &IncrementalProgram) -> BlockProgram {
        let mut now = Vec::new();
        let cells = layout.box_of_cells(self.first, self.cells);
        live.part_program_in(self.part, cells, self.reach, &mut now);
        BlockProgram {
            first: self.first,
            // It has cells that are near.
            far: None,
            current: now,
            previous: Some(Vec::new()),
        }
    }

    /// Returns the blocks of each part as a batch.
    pub(super) fn units(all: &[Self]) -> Vec<EditBatch> {
        let parts = all.chunk_by(|a, b| a.part == b.part);
        let unit = |own: &[Self]| EditBatch {
            part: own[0].part,
            blocks: own.iter().map(|block| block.first).collect(),
        };
        parts.map(unit).collect()
    }
}

/// Returns appended brushes, the first one first, if they alone determine how bricks change.
pub(super) fn hard_brushes(added: &Additions<'_>) -> Vec<HardBrush> {
    let mut hard = added.hard_brushes().unwrap_or_default();
    // Of many brushes, most are not in a cell.
    if hard.len() > FEW_BRUSHES {
        hard.clear();
    }
    hard.reverse();
    hard
}

impl Bricks {
    /// Returns the blocks of batches in which appended brushes can have changed something.
    pub(super) fn reached<T: Texel>(
        &self,
        added: &Additions<'_>,
        work: &EditQueue,
        units: &[EditBatch],
        (bounds, fill): (&CellBounds<'_>, &FillUniform),
    ) -> Vec<ReachedBlock> {
        let all: Vec<(IVec3, IVec3)> = units
            .iter()
            .flat_map(|unit| unit.blocks.iter().map(|&first| (unit.part, first)))
            .collect();
        let reached = all.into_par_iter().with_min_len(FEW).map(|(part, first)| {
            let (cells, reach) = if work.is_loosened(&self.layout, first) {
                (u64::MAX, f32::INFINITY)
            } else {
                self.reached_in::<T>(added, first, bounds, fill)
            };
            ReachedBlock {
                part,
                first,
                cells: cells & work.remaining_cells(first),
                reach,
            }
        });
        reached.filter(|block| block.cells != 0).collect()
    }

    /// Returns the samples of a brick.
    pub(super) fn samples_of<T: Texel>(&self, brick: u32) -> &[T] {
        let samples = self.layout.brick_samples() as usize;
        let pool = self.store.pool.of::<T>().expect(OF_THIS_TYPE);
        &pool[brick as usize * samples..][..samples]
    }

    fn reached_in<T: Texel>(
        &self,
        added: &Additions<'_>,
        first: IVec3,
        bounds: &CellBounds<'_>,
        fill: &FillUniform,
    ) -> (u64, f32) {
        let layout = &self.layout;
        let bounds = bounds.of_block(layout, first);
        let slot = self.table.slot(first / BLOCK_SIDE as i32) as usize;
        let words = &self.store.words[slot * CELLS_PER_BATCH..(slot + 1) * CELLS_PER_BATCH];
        let side = layout.brick_size_voxels as usize + 1;
        let middle = (side / 2) * (1 + side + side * side);
        let scale = fill.spacing_scale[3];
        let radius = layout.half_diagonal(1);
        let (mut cells, mut greatest) = (0, 0.0f32);
        for (i, &word) in words.iter().enumerate() {
            let (side, lengths) = if is_brick(word) {
                let stored = self.samples_of::<T>(word)[middle].code();
                let least = (stored.abs() - 1.0).max(0.0) / scale;
                // Distances beyond the band are stored as its end.
                let most = if stored.abs() < fill.max_code as f32 {
                    (stored.abs() + 1.0) / scale
                } else {
                    bounds.unclear_length(radius)
                };
                (stored, [least, most])
            } else {
                let center = center_of(word);
                (center, bounds.lengths(center))
            };
            let center = layout.center(first + inner_cell(i), 1);
            if added.can_matter(center, radius, signed(side, lengths)) {
                cells |= 1 << i;
                greatest = greatest.max(lengths[1]);
            }
        }
        let reach = added
            .max_distance_after(greatest)
            .max(bounds.near_length(layout));
        (cells, reach)
    }
}

/// Returns signed distances of a side for a range of lengths, or of both sides if the range begins at 0.
fn signed(side: f32, [least, most]: [f32; 2]) -> [f32; 2] {
    if least == 0.0 {
        [-most, most]
    } else if side < 0.0 {
        [-most, -least]
    } else {
        [least, most]
    }
}
