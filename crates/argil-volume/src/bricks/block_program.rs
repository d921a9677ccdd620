//! Pruned programs of the blocks that edits touch.

use super::bounds::CellBounds;
use super::edit_queue::{EditBatch, EditQueue};
use super::{BLOCK_SIDE, BlockTable, BrickLayout};
use argil_abi::Instruction;
use argil_field::{CELLS_PER_BATCH, ChangeSet, IncrementalProgram, Pruner};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// The pruned program of a block, before and after an edit.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockProgram {
    /// Its first cell.
    pub first: IVec3,
    /// Whether the block is farther from the surface now than cells store, and then whether it is inside.
    pub far: Option<bool>,
    /// The block's instructions after the edit.
    pub current: Vec<Instruction>,
    /// The block's instructions before the edit. `None` if the edited instructions are unknown, or if a covering
    /// brush removed one of them. Empty if none of them existed.
    pub previous: Option<Vec<Instruction>>,
}

impl EditQueue {
    /// Returns what can have changed, if it is known.
    pub(crate) fn touched<'a>(&self, live: &'a IncrementalProgram) -> Option<&'a ChangeSet> {
        live.changes().filter(|_| self.is_latest())
    }

    /// Returns the blocks of batches that edits can have changed, with their programs. Blocks whose programs
    /// contain no touched instruction, before or after, are skipped: their distances are unchanged. Runs on rayon's
    /// current threads.
    pub fn lists(
        &self,
        layout: &BrickLayout,
        live: &IncrementalProgram,
        units: Vec<EditBatch>,
    ) -> Vec<BlockProgram> {
        units
            .into_par_iter()
            .with_max_len(1)
            .flat_map_iter(|unit| self.lists_of(layout, live, &unit))
            .collect()
    }

    fn lists_of(
        &self,
        layout: &BrickLayout,
        live: &IncrementalProgram,
        unit: &EditBatch,
    ) -> Vec<BlockProgram> {
        let centers: Vec<Vec3> = unit
            .blocks
            .iter()
            .map(|&cell| layout.center(cell, BLOCK_SIDE))
            .collect();
        let count = centers.len();
        let mut whole = Vec::new();
        live.part_program(unit.part, &mut whole);
        let radius = layout.half_diagonal(BLOCK_SIDE);
        let half = 0.5 * layout.cell_length() * BLOCK_SIDE as f32;
        let mut d = [0.0; CELLS_PER_BATCH];
        let d = &mut d[..count];
        let cut = |pruner: &mut Pruner<'_>, instructions: &[Instruction], i: usize| {
            let mut list = Vec::new();
            pruner.prune_into(instructions, i, &mut list);
            list
        };
        let bounds = CellBounds::new(live.program(), layout);
        let far = |i: usize, d: f32| {
            let own = bounds.about(centers[i], half);
            own.is_far(d, radius).then_some(d < 0.0)
        };
        let mut pruner = Pruner::new(live.program());
        let Some(touched) = self.touched(live) else {
            pruner.classify_cells(&whole, &centers, radius, d);
            let lists = (0..count).map(|i| BlockProgram {
                first: unit.blocks[i],
                far: far(i, d[i]),
                current: cut(&mut pruner, &whole, i),
                previous: None,
            });
            return lists.collect();
        };
        let mut before = Vec::new();
        live.previous_part_program(unit.part, &mut before);
        let loosened = (0..count).fold(0u64, |bits, i| {
            bits | u64::from(self.is_loosened(layout, unit.blocks[i])) << i
        });
        if loosened == 0 && !touched.intersects(&whole) && !touched.intersects(&before) {
            return Vec::new();
        }
        // If nothing touched was there before, the previous program is not needed.
        if !touched.intersects(&before) {
            before.clear();
        }
        let mut old_pruner = Pruner::new(live.program());
        old_pruner.classify_cells(&before, &centers, radius, d);
        pruner.classify_cells(&whole, &centers, radius, d);
        let is_one = |instr: &Instruction| touched.contains(instr);
        let needed =
            pruner.affected_cells(&whole, is_one) | old_pruner.affected_cells(&before, is_one);
        let needed = needed | loosened;
        (0..count)
            .filter(|i| needed >> i & 1 != 0)
            .map(|i| {
                let now = cut(&mut pruner, &whole, i);
                let then = cut(&mut old_pruner, &before, i);
                let are_there = touched.count_in(&now) >= pruner.affected_count(&whole, i, is_one)
                    && touched.count_in(&then) >= old_pruner.affected_count(&before, i, is_one);
                BlockProgram {
                    first: unit.blocks[i],
                    far: far(i, d[i]),
                    current: now,
                    previous: (are_there && loosened >> i & 1 == 0).then_some(then),
                }
            })
            .collect()
    }
}

/// Returns the blocks around newly empty ones that are far from everything now, with their side. The boxes of edits
/// end where cells store nothing, and a block may extend beyond.
pub fn emptied_around(
    table: &BlockTable,
    layout: &BrickLayout,
    live: &IncrementalProgram,
    gone: &[(IVec3, bool)],
) -> Vec<(IVec3, bool)> {
    let mut seen: FxHashSet<IVec3> = gone.iter().map(|(block, _)| *block).collect();
    let mut open: Vec<IVec3> = seen.iter().copied().collect();
    let side = live.parts().edge / (layout.cell_length() * BLOCK_SIDE as f32);
    let side = IVec3::splat((side.round() as i32).max(1));
    let bounds = CellBounds::new(live.program(), layout);
    let radius = layout.half_diagonal(BLOCK_SIDE);
    let half = 0.5 * layout.cell_length() * BLOCK_SIDE as f32;
    let mut pruner = Pruner::new(live.program());
    let (mut found, mut list) = (Vec::new(), Vec::new());
    while !open.is_empty() {
        let mut parts: BTreeMap<[i32; 3], Vec<IVec3>> = BTreeMap::new();
        for block in open.drain(..) {
            for index in 0..27 {
                let beside = block + IVec3::new(index % 3, index / 3 % 3, index / 9) - 1;
                if table.find(beside).is_some() && seen.insert(beside) {
                    let part = beside.div_euclid(side).to_array();
                    parts.entry(part).or_default().push(beside);
                }
            }
        }
        for (part, blocks) in parts {
            list.clear();
            live.part_program(part.into(), &mut list);
            for blocks in blocks.chunks(CELLS_PER_BATCH) {
                let mut d = [0.0; CELLS_PER_BATCH];
                let middle = |block: &IVec3| layout.center(*block * BLOCK_SIDE as i32, BLOCK_SIDE);
                let centers: Vec<Vec3> = blocks.iter().map(middle).collect();
                let d = &mut d[..blocks.len()];
                pruner.classify_cells(&list, &centers, radius, d);
                for ((block, center), d) in blocks.iter().zip(centers).zip(d) {
                    if bounds.about(center, half).is_far(*d, radius) {
                        found.push((*block, *d < 0.0));
                        open.push(*block);
                    }
                }
            }
        }
    }
    found
}
