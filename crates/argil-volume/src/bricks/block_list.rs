//! What can matter in the blocks that edits touch.

use super::work::{EditWork, Unit};
use super::{BLOCK_SIDE, BrickLayout};
use argil_abi::Instr;
use argil_field::{CELLS, LiveProgram, Pruner, Touched};
use glam::Vec3;
use rayon::prelude::*;

/// What can matter in a block.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockList {
    /// Its place in the grid.
    pub block: usize,
    /// The instructions.
    pub now: Vec<Instr>,
    /// As they were, if it is known what was touched, and what of that may matter in the block is in these lists: what takes
    /// the place of all before it takes that out of a list too.
    pub before: Option<Vec<Instr>>,
}

impl EditWork {
    /// What can have changed, where that is known.
    pub(crate) fn touched<'a>(&self, live: &'a LiveProgram) -> Option<&'a Touched> {
        live.touched().filter(|_| self.is_latest())
    }

    /// The blocks of units that edits can have changed, each with its list, and with what that was before where it is known
    /// what was touched: where nothing of that is in either list, distances are what they were. On rayon's current threads.
    pub fn lists(
        &self,
        layout: &BrickLayout,
        live: &LiveProgram,
        units: Vec<Unit>,
    ) -> Vec<BlockList> {
        units
            .into_par_iter()
            .flat_map_iter(|unit| self.lists_of(layout, live, &unit))
            .collect()
    }

    fn lists_of(&self, layout: &BrickLayout, live: &LiveProgram, unit: &Unit) -> Vec<BlockList> {
        let centers: Vec<Vec3> = unit
            .blocks
            .iter()
            .map(|&cell| layout.middle(cell, BLOCK_SIDE))
            .collect();
        let count = centers.len();
        let mut whole = Vec::new();
        live.list(unit.part, &mut whole);
        let radius = layout.half_diagonal(BLOCK_SIDE);
        let mut d = [0.0; CELLS];
        let d = &mut d[..count];
        let cut = |pruner: &mut Pruner<'_>, instrs: &[Instr], i: usize| {
            let mut list = Vec::new();
            pruner.list(instrs, i, &mut list);
            list
        };
        let block = |i: usize| layout.word_index(unit.blocks[i]) / CELLS;
        let mut pruner = Pruner::new(live.program());
        let Some(touched) = self.touched(live) else {
            pruner.mark(&whole, &centers, radius, d);
            let lists = (0..count).map(|i| BlockList {
                block: block(i),
                now: cut(&mut pruner, &whole, i),
                before: None,
            });
            return lists.collect();
        };
        let mut before = Vec::new();
        live.list_before(unit.part, &mut before);
        if !touched.any(&whole) && !touched.any(&before) {
            return Vec::new();
        }
        let mut old_pruner = Pruner::new(live.program());
        pruner.mark(&whole, &centers, radius, d);
        old_pruner.mark(&before, &centers, radius, d);
        let is_one = |instr: &Instr| touched.has(instr);
        let needed = pruner.needed(&whole, is_one) | old_pruner.needed(&before, is_one);
        (0..count)
            .filter(|i| needed >> i & 1 != 0)
            .map(|i| {
                let now = cut(&mut pruner, &whole, i);
                let then = cut(&mut old_pruner, &before, i);
                let count = |list: &[Instr]| list.iter().filter(|instr| is_one(instr)).count();
                let are_there = count(&now) >= pruner.needed_in(&whole, i, is_one)
                    && count(&then) >= old_pruner.needed_in(&before, i, is_one);
                BlockList {
                    block: block(i),
                    now,
                    before: are_there.then_some(then),
                }
            })
            .collect()
    }
}
