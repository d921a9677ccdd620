//! What can matter in the blocks that edits touch.

use super::bounds::Bounds;
use super::work::{EditWork, Unit};
use super::{BLOCK_SIDE, BlockTable, BrickLayout};
use argil_abi::Instr;
use argil_field::{CELLS, LiveProgram, Pruner, Touched};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// What can matter in a block.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockList {
    /// Its first cell.
    pub first: IVec3,
    /// Whether all of it is farther from the surface now than cells tell, and then whether it is inside.
    pub far: Option<bool>,
    /// The instructions.
    pub now: Vec<Instr>,
    /// As they were, if it is known what was touched, and what of that may matter in the block is in these lists: what takes
    /// the place of all before it takes that out of a list too. Nothing, where nothing of that was there.
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
        let half = 0.5 * layout.cell_length() * BLOCK_SIDE as f32;
        let mut d = [0.0; CELLS];
        let d = &mut d[..count];
        let cut = |pruner: &mut Pruner<'_>, instrs: &[Instr], i: usize| {
            let mut list = Vec::new();
            pruner.list(instrs, i, &mut list);
            list
        };
        let bounds = Bounds::new(live.program(), layout);
        let far = |i: usize, d: f32| {
            let own = bounds.about(centers[i], half);
            own.is_far(d, radius).then_some(d < 0.0)
        };
        let mut pruner = Pruner::new(live.program());
        let Some(touched) = self.touched(live) else {
            pruner.mark(&whole, &centers, radius, d);
            let lists = (0..count).map(|i| BlockList {
                first: unit.blocks[i],
                far: far(i, d[i]),
                now: cut(&mut pruner, &whole, i),
                before: None,
            });
            return lists.collect();
        };
        let mut before = Vec::new();
        live.list_before(unit.part, &mut before);
        let loosened = (0..count).fold(0u64, |bits, i| {
            bits | u64::from(self.is_loosened(layout, unit.blocks[i])) << i
        });
        if loosened == 0 && !touched.any(&whole) && !touched.any(&before) {
            return Vec::new();
        }
        // Where nothing that was touched was before, nobody asks what was.
        if !touched.any(&before) {
            before.clear();
        }
        let mut old_pruner = Pruner::new(live.program());
        old_pruner.mark(&before, &centers, radius, d);
        pruner.mark(&whole, &centers, radius, d);
        let is_one = |instr: &Instr| touched.has(instr);
        let needed = pruner.needed(&whole, is_one) | old_pruner.needed(&before, is_one);
        let needed = needed | loosened;
        (0..count)
            .filter(|i| needed >> i & 1 != 0)
            .map(|i| {
                let now = cut(&mut pruner, &whole, i);
                let then = cut(&mut old_pruner, &before, i);
                let are_there = touched.count(&now) >= pruner.needed_in(&whole, i, is_one)
                    && touched.count(&then) >= old_pruner.needed_in(&before, i, is_one);
                BlockList {
                    first: unit.blocks[i],
                    far: far(i, d[i]),
                    now,
                    before: (are_there && loosened >> i & 1 == 0).then_some(then),
                }
            })
            .collect()
    }
}

/// Blocks that `live` knows to be far from everything now, around some that have become so, with the side that they are on: the
/// boxes of edits end where cells tell nothing, and a block may reach beyond.
pub fn emptied_around(
    table: &BlockTable,
    layout: &BrickLayout,
    live: &LiveProgram,
    gone: &[(IVec3, bool)],
) -> Vec<(IVec3, bool)> {
    let mut seen: FxHashSet<IVec3> = gone.iter().map(|(block, _)| *block).collect();
    let mut open: Vec<IVec3> = seen.iter().copied().collect();
    let side = live.parts().edge / (layout.cell_length() * BLOCK_SIDE as f32);
    let side = IVec3::splat((side.round() as i32).max(1));
    let bounds = Bounds::new(live.program(), layout);
    let radius = layout.half_diagonal(BLOCK_SIDE);
    let half = 0.5 * layout.cell_length() * BLOCK_SIDE as f32;
    let mut pruner = Pruner::new(live.program());
    let (mut found, mut list) = (Vec::new(), Vec::new());
    while !open.is_empty() {
        let mut parts: BTreeMap<[i32; 3], Vec<IVec3>> = BTreeMap::new();
        for block in open.drain(..) {
            for nth in 0..27 {
                let beside = block + IVec3::new(nth % 3, nth / 3 % 3, nth / 9) - 1;
                if table.find(beside).is_some() && seen.insert(beside) {
                    let part = beside.div_euclid(side).to_array();
                    parts.entry(part).or_default().push(beside);
                }
            }
        }
        for (part, blocks) in parts {
            list.clear();
            live.list(part.into(), &mut list);
            for blocks in blocks.chunks(CELLS) {
                let mut d = [0.0; CELLS];
                let middle = |block: &IVec3| layout.middle(*block * BLOCK_SIDE as i32, BLOCK_SIDE);
                let centers: Vec<Vec3> = blocks.iter().map(middle).collect();
                let d = &mut d[..blocks.len()];
                pruner.mark(&list, &centers, radius, d);
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
