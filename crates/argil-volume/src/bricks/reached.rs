//! Which cells brushes can matter in that edits have put behind all else, by what bricks hold: where brushes are many, that is
//! known sooner than by lists of them.

use super::build::Bounds;
use super::words::{center_of, is_brick};
use super::work::{EditWork, Unit};
use super::{BLOCK_SIDE, Bricks, inner_cell};
use crate::Texel;
use crate::texels::OF_THIS_TYPE;
use argil_abi::Fill;
use argil_field::{Added, CELLS, LiveProgram};
use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Cells of blocks, by their blocks' first cells: a bit for each.
pub(super) type Reached = FxHashMap<IVec3, u64>;

impl Bricks {
    /// Keep the blocks of units that have such cells, if nothing else was touched; the others are as they were.
    pub(super) fn keep_reached<T: Texel>(
        &self,
        live: &LiveProgram,
        work: &EditWork,
        units: Vec<Unit>,
        (bounds, fill): (&Bounds<'_>, &Fill),
    ) -> (Vec<Unit>, Option<Reached>) {
        let added = work.touched(live).and_then(|_| live.added());
        let Some(added) = added else {
            return (units, None);
        };
        let kept = units.into_par_iter().map(|unit| {
            let cells = unit.blocks.into_iter().map(|first| {
                let cells = if work.is_loosened(&self.layout, first) {
                    u64::MAX
                } else {
                    self.reached::<T>(&added, first, bounds, fill)
                };
                (first, cells)
            });
            let cells: Vec<(IVec3, u64)> = cells.filter(|&(_, cells)| cells != 0).collect();
            (unit.part, cells)
        });
        let kept: Vec<(IVec3, Vec<(IVec3, u64)>)> = kept.collect();
        let mut reached = Reached::default();
        let mut units = Vec::new();
        for (part, cells) in kept.into_iter().filter(|(_, cells)| !cells.is_empty()) {
            let blocks = cells.iter().map(|&(first, _)| first).collect();
            units.push(Unit { part, blocks });
            reached.extend(cells);
        }
        (units, Some(reached))
    }

    fn reached<T: Texel>(
        &self,
        added: &Added<'_>,
        first: IVec3,
        bounds: &Bounds<'_>,
        fill: &Fill,
    ) -> u64 {
        let layout = &self.layout;
        let bounds = bounds.of_block(layout, first);
        let slot = self.table.slot(first / BLOCK_SIDE as i32) as usize;
        let words = &self.words[slot * CELLS..(slot + 1) * CELLS];
        let pool = self.pool.of::<T>().expect(OF_THIS_TYPE);
        let samples = layout.brick_samples() as usize;
        let side = layout.brick as usize + 1;
        let middle = (side / 2) * (1 + side + side * side);
        let scale = fill.spacing_scale[3];
        let radius = layout.half_diagonal(1);
        let mut cells = 0;
        for (i, &word) in words.iter().enumerate() {
            let known = if is_brick(word) {
                let stored = pool[word as usize * samples + middle].integer();
                let least = (stored.abs() - 1.0).max(0.0) / scale;
                // What is beyond the range is stored as its end.
                let most = if stored.abs() < fill.quanta as f32 {
                    (stored.abs() + 1.0) / scale
                } else {
                    f32::MAX
                };
                signed(stored, [least, most])
            } else {
                let center = center_of(word);
                signed(center, bounds.lengths(center))
            };
            let center = layout.middle(first + inner_cell(i), 1);
            cells |= u64::from(added.can_matter(center, radius, known)) << i;
        }
        cells
    }
}

/// Distances of a side, of lengths from one to another; of both, where they begin at 0.
fn signed(side: f32, [least, most]: [f32; 2]) -> [f32; 2] {
    if least == 0.0 {
        [-most, most]
    } else if side < 0.0 {
        [-most, -least]
    } else {
        [least, most]
    }
}
