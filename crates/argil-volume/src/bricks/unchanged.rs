//! Decides which cells of a block, and which octants of their bricks, edits leave as they were. The samples from before an edit tell
//! more than bounds around centers.

use super::block_editor::BlockEditor;
use super::block_program::BlockProgram;
use super::bounds::CellBounds;
use super::brick_baker::only_material;
use super::candidates::CandidateBlock;
use super::cell::{center_of, is_brick};
use super::octants::{self, OCTANTS};
use super::{Bricks, inner_cell};
use crate::Texel;
use argil_abi::Instruction;
use argil_field::{Additions, CELLS_PER_BATCH, Pruner};
use glam::IVec3;
use std::ops::Range;

/// From this many instructions in a block's program on, octants are tested with the programs of their cells.
const LONG_LIST: usize = 64;

impl BlockEditor<'_> {
    /// Returns the octants that edits can have changed, for some cells of a block that have a brick and are near
    /// the surface. Other cells return all octants.
    pub(super) fn octants<T: Texel>(
        &self,
        first: IVec3,
        (lists, lipschitz): (&BlockProgram, f32),
        some: u64,
        (found, bricks, old): (&CandidateBlock, &Bricks, &[u32]),
        pruner: &mut Pruner<'_>,
    ) -> [u8; CELLS_PER_BATCH] {
        let mut octants = [u8::MAX; CELLS_PER_BATCH];
        let has_brick = |i: u8| some >> i & 1 != 0 && is_brick(old[usize::from(i)]);
        let mut near: Vec<(usize, IVec3, &Range<usize>)> = found
            .cells
            .iter()
            .filter(|(i, _)| has_brick(*i))
            .map(|(i, range)| (usize::from(*i), first + inner_cell(usize::from(*i)), range))
            .collect();
        if let Some(added) = self.added_in(first) {
            let fill = (&self.fill, lipschitz);
            near.retain(|&(i, cell, _)| {
                let samples = bricks.samples_of::<T>(old[i]);
                octants[i] = octants::reached(&self.layout, added, fill, cell, samples);
                octants[i] != 0
            });
        }
        let (Some(before), Some(touched)) = (&lists.previous, self.touched) else {
            return octants;
        };
        if !self.hard.is_empty() {
            return octants;
        }
        let in_block = touched.count_in(&lists.current);
        let had_any = touched.intersects(before);
        for near in near.chunks(octants::CELLS_AT_ONCE) {
            let cells: Vec<IVec3> = near.iter().map(|&(_, cell, _)| cell).collect();
            let mut changed = |list: &[Instruction], cells: &[IVec3]| {
                octants::changed(&self.layout, pruner, touched, list, cells)
            };
            let mut bits = if had_any { changed(before, &cells) } else { 0 };
            if lists.current.len() > LONG_LIST {
                for (index, (.., range)) in near.iter().enumerate() {
                    let own = &found.instructions[(*range).clone()];
                    // An instruction that matters in the cell can be missing from its program, because another
                    // covers it.
                    let is_whole = touched.count_in(own) == in_block;
                    let list = if is_whole { own } else { &lists.current[..] };
                    bits |= changed(list, &cells[index..=index]) << (index * OCTANTS);
                }
            } else if in_block > 0 {
                bits |= changed(&lists.current, &cells);
            }
            for (index, &(i, ..)) in near.iter().enumerate() {
                octants[i] &= (bits >> (index * OCTANTS)) as u8;
            }
        }
        octants
    }

    /// Returns the appended brushes, if a block's samples tell where they can matter.
    pub(super) fn added_in(&self, first: IVec3) -> Option<&Additions<'_>> {
        let added = self.added.as_ref();
        added.filter(|_| !self.work.is_loosened(&self.layout, first))
    }

    /// Whether appended brushes leave a cell clear whose samples were clear before.
    pub(super) fn stays_clear(
        &self,
        added: &Additions<'_>,
        bounds: &CellBounds<'_>,
        (cell, old): (IVec3, u32),
    ) -> bool {
        let center = center_of(old);
        let voxel = self.layout.voxel_grid.voxel_size;
        // As for a brick's samples.
        let least = bounds.unclear_length(0.5 * 3f32.sqrt() * voxel);
        let region = self.layout.cell_box(cell).grown(0.01 * voxel);
        // Other centers were enough to tell that no surface is there, and nothing is known of samples.
        let was_sampled = center.abs() < 0.999 * bounds.lipschitz() * self.layout.half_diagonal(1);
        was_sampled && center != 0.0 && added.keep_clear(region, center < 0.0, least)
    }

    /// Whether a brick whose samples cannot have changed keeps its material. A program of one material gives it;
    /// otherwise the stored materials tell.
    pub(super) fn has_same_material(&self, list: &[Instruction], look: u32) -> bool {
        match only_material(list, self.live.program().materials()) {
            Some(only) => only == look,
            None => look & argil_abi::BRICK_MIXED != 0,
        }
    }
}
