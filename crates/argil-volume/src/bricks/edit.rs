//! Changing bricks in place.
//!
//! *Practice.* An edit tells two boxes: outside of the first nothing changed within the stored band, outside of the
//! second nothing within what empty cells tell. Blocks that the second touches are pruned and measured again, from the
//! operands that can matter near them; of their cells, those that the first touches are sampled again. Where it is known
//! which instructions were touched, a cell is left alone in whose pruned lists, as they are and as they were, there is none
//! of those: it has the same distances, to the bit. That is far less than the boxes hold where blends are wide. Any number of
//! edits go in one pass. What was made is put into the pool at the end, so that nothing is changed if it does not fit.

use super::build::{Bounds, Candidates, near_block, settle};
use super::filler::Filler;
use super::material::PLACES;
use super::pool::Pool;
use super::words::{center_of, empty_word, is_brick};
use super::{BLOCK_SIDE, BrickLayout, Bricks, BricksError};
use crate::{Bits, Texel};
use argil_abi::{Fill, Instr};
use argil_field::{CELLS, LiveProgram, Parts, Program, Pruner};
use argil_math::Aabb;
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Blocks along the side of a part that shares a list: where brushes are many, its list should not be of all of them.
const PART_SIDE: u32 = 4;
const SMALL_PART_SIDE: u32 = 2;
/// More brushes than this are many.
const MANY: usize = 500;

/// What an edit of bricks did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BrickEdit {
    /// Bricks that were sampled again or anew.
    pub filled: u64,
    /// Bricks that there were not before.
    pub added: u64,
    /// Bricks that there are no more.
    pub removed: u64,
    /// Cells that were measured again.
    pub cells: u64,
}

/// A block's new words and bricks.
struct Made<T> {
    block: usize,
    words: [u32; CELLS],
    /// Cells with a brick: which, and what it looks like.
    bricks: Vec<(u8, u32)>,
    texels: Vec<T>,
    mixed: Vec<[u32; 2]>,
}

impl BrickLayout {
    /// The parts in which a [`LiveProgram`] of these bricks tells lists.
    pub fn parts(&self, program: &Program) -> Parts {
        let blocks = if program.brush_count() > MANY {
            SMALL_PART_SIDE
        } else {
            PART_SIDE
        };
        let side = blocks * BLOCK_SIDE;
        Parts {
            corner: self.lattice.corner,
            edge: side as f32 * self.cell_length(),
            count: UVec3::from_array(self.grid.to_array().map(|n| n.div_ceil(side))),
            far: self.bands(program)[1],
            region: self.region(),
        }
    }

    /// The distances up to which edits must tell their boxes: what bricks hold, and what empty cells tell.
    pub fn bands(&self, program: &Program) -> [f32; 2] {
        let slack = program.bounds_slack(self.region());
        let near = program.lipschitz() * self.half_diagonal(1) + slack;
        let range = self.encoding.range_length(&self.lattice, 0);
        [
            1.1 * near.max(range),
            1.1 * (self.far_length() + slack).max(near),
        ]
    }
}

impl Bricks {
    /// Follow edits, whose boxes are told for this layout's [bands](BrickLayout::bands), of each that for the first and that
    /// for the second. On rayon's current threads.
    ///
    /// # Errors
    /// If the bricks would take more than `budget` bytes; they are then as they were.
    pub fn edit(
        &mut self,
        live: &LiveProgram,
        boxes: &[[Aabb; 2]],
        budget: Option<u64>,
    ) -> Result<BrickEdit, BricksError> {
        match self.layout.encoding.bits {
            Bits::Eight => self.edit_as::<i8>(live, boxes, budget),
            Bits::Sixteen => self.edit_as::<i16>(live, boxes, budget),
        }
    }

    fn edit_as<T: Texel>(
        &mut self,
        live: &LiveProgram,
        boxes: &[[Aabb; 2]],
        budget: Option<u64>,
    ) -> Result<BrickEdit, BricksError> {
        let boxes = joined(boxes);
        let edit = Editing {
            layout: self.layout,
            live,
            bounds: Bounds::new(live.program(), &self.layout),
            fill: self
                .layout
                .encoding
                .fill(live.program(), &self.layout.lattice, 0),
            boxes: &boxes,
        };
        let made: Vec<Made<T>> = edit
            .parts()
            .into_par_iter()
            .flat_map_iter(|(part, blocks)| edit.lists(part, &blocks))
            .collect::<Vec<_>>()
            .into_par_iter()
            .map_init(
                || edit.worker(),
                |worker, lists| edit.make(worker, &lists, &self.words),
            )
            .collect();
        self.check_budget(&made, budget)?;

        let mut result = BrickEdit::default();
        let samples = self.layout.brick_samples() as usize;
        let before = self.owners.len() as u64;
        let mut pool = Pool::<T>::open(self);
        // What is freed can then be taken.
        for own in &made {
            let first = own.block * CELLS;
            for (i, &word) in own.words.iter().enumerate() {
                if !is_brick(word) {
                    let old = pool.bricks().words[first + i];
                    result.removed += u64::from(is_brick(old));
                    pool.clear((first + i) as u32, word);
                }
            }
            result.cells += CELLS as u64;
        }
        for own in &made {
            let mut mixed = own.mixed.chunks_exact(PLACES);
            for (&(i, material), texels) in own.bricks.iter().zip(own.texels.chunks_exact(samples))
            {
                let own_mixed = if material & argil_abi::BRICK_MIXED != 0 {
                    mixed.next().unwrap_or_default()
                } else {
                    &[]
                };
                pool.put(
                    (own.block * CELLS) as u32 + u32::from(i),
                    texels,
                    material,
                    own_mixed,
                );
            }
            result.filled += own.bricks.len() as u64;
        }
        pool.close();
        for own in &made {
            let words = &mut self.words[own.block * CELLS..(own.block + 1) * CELLS];
            self.masks[own.block] = settle(words);
        }
        result.added = (self.owners.len() as u64 + result.removed) - before;
        Ok(result)
    }

    fn check_budget<T>(&self, made: &[Made<T>], budget: Option<u64>) -> Result<(), BricksError> {
        let budget = budget.unwrap_or(u64::MAX);
        let mut bricks = self.owners.len() as u64;
        let mut mixed = 0;
        for own in made {
            let old = self.masks[own.block].count_ones();
            let new = own.words.iter().filter(|&&word| is_brick(word)).count();
            bricks = bricks + new as u64 - u64::from(old);
            mixed += size_of_val(&own.mixed[..]) as u64;
        }
        self.layout.check_count(bricks)?;
        let of_each = self.layout.brick_bytes() + 8;
        let needed =
            self.layout.table_bytes() + bricks * of_each + size_of_val(&self.mixed[..]) as u64;
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

/// Boxes of edits one after the other, as one where that is hardly larger: those of a drag.
fn joined(boxes: &[[Aabb; 2]]) -> Vec<[Aabb; 2]> {
    let volume = |b: Aabb| {
        if b.is_empty() {
            0.0
        } else {
            b.size().element_product()
        }
    };
    let mut all: Vec<[Aabb; 2]> = Vec::new();
    for &[dirty, far] in boxes {
        if let Some([last_dirty, last_far]) = all.last_mut() {
            let both = [last_dirty.union(dirty), last_far.union(far)];
            if volume(both[1]) <= 1.1 * volume(*last_far).max(volume(far)) {
                [*last_dirty, *last_far] = both;
                continue;
            }
        }
        all.push([dirty, far]);
    }
    all
}

/// What all blocks of an edit share.
struct Editing<'a> {
    layout: BrickLayout,
    live: &'a LiveProgram,
    bounds: Bounds,
    fill: Fill,
    boxes: &'a [[Aabb; 2]],
}

/// What can matter in a block.
struct Lists {
    block: usize,
    now: Vec<Instr>,
    /// As it was, if it is known what was touched.
    before: Option<Vec<Instr>>,
}

/// What a thread keeps.
struct Worker<'a> {
    pruner: Pruner<'a>,
    filler: Filler<'a>,
}

impl Editing<'_> {
    fn worker(&self) -> Worker<'_> {
        Worker {
            pruner: Pruner::new(self.live.program()),
            filler: Filler::new(self.live.program(), &self.layout, &self.fill),
        }
    }

    /// The blocks that a box touches.
    fn touched(&self, region: Aabb) -> [UVec3; 2] {
        let edge = self.layout.cell_length() * BLOCK_SIDE as f32;
        let last = self.layout.blocks.as_vec3() - 1.0;
        let first = ((region.min - self.layout.lattice.corner) / edge).floor();
        let end = ((region.max - self.layout.lattice.corner) / edge).floor();
        let is_in = !region.is_empty() && first.cmple(last).all() && end.cmpge(Vec3::ZERO).all();
        if !is_in {
            return [UVec3::ZERO; 2];
        }
        [
            first.clamp(Vec3::ZERO, last).as_uvec3(),
            end.clamp(Vec3::ZERO, last).as_uvec3() + 1,
        ]
    }

    /// The parts that are touched, each with the first cells of its touched blocks.
    fn parts(&self) -> Vec<(UVec3, Vec<UVec3>)> {
        let edge = self.layout.cell_length() * BLOCK_SIDE as f32;
        let side = (self.live.parts().edge / edge).round() as u32;
        let mut parts: BTreeMap<[u32; 3], BTreeSet<[u32; 3]>> = BTreeMap::new();
        for [_, far] in self.boxes {
            let [first, end] = self.touched(*far);
            for z in first.z..end.z {
                for y in first.y..end.y {
                    for x in first.x..end.x {
                        let block = uvec3(x, y, z);
                        let part = (block / side).to_array();
                        parts.entry(part).or_default().insert(block.to_array());
                    }
                }
            }
        }
        let first_cell = |block: [u32; 3]| UVec3::from_array(block) * BLOCK_SIDE;
        parts
            .into_iter()
            .map(|(part, blocks)| {
                let cells = blocks.into_iter().map(first_cell).collect();
                (UVec3::from_array(part), cells)
            })
            .collect()
    }

    /// The blocks of a part that edits can have changed, each with its list, and with what that was before where it is known
    /// what was touched: where nothing of that is in either list, distances are what they were.
    fn lists(&self, part: UVec3, cells: &[UVec3]) -> Vec<Lists> {
        let centers: Vec<Vec3> = cells
            .iter()
            .map(|&cell| self.layout.middle(cell, BLOCK_SIDE))
            .collect();
        let block = |cell: UVec3| self.layout.word_index(cell) / CELLS;
        let touched = self.live.touched();
        let mut whole = Vec::new();
        self.live.list(part, &mut whole);
        let radius = self.layout.half_diagonal(BLOCK_SIDE);
        let mut d = [0.0; CELLS];
        let d = &mut d[..cells.len()];
        let cut = |pruner: &mut Pruner<'_>, instrs: &[Instr], i: usize| {
            let mut list = Vec::new();
            pruner.list(instrs, i, &mut list);
            list
        };
        let mut pruner = Pruner::new(self.live.program());
        let Some(touched) = touched else {
            pruner.mark(&whole, &centers, radius, d);
            let lists = (0..cells.len()).map(|i| Lists {
                block: block(cells[i]),
                now: cut(&mut pruner, &whole, i),
                before: None,
            });
            return lists.collect();
        };
        let mut before = Vec::new();
        self.live.list_before(part, &mut before);
        if !touched.any(&whole) && !touched.any(&before) {
            return Vec::new();
        }
        let mut old_pruner = Pruner::new(self.live.program());
        pruner.mark(&whole, &centers, radius, d);
        old_pruner.mark(&before, &centers, radius, d);
        let is_one = |instr: &Instr| touched.has(instr);
        let needed = pruner.needed(&whole, is_one) | old_pruner.needed(&before, is_one);
        (0..cells.len())
            .filter(|i| needed >> i & 1 != 0)
            .map(|i| Lists {
                block: block(cells[i]),
                now: cut(&mut pruner, &whole, i),
                before: Some(cut(&mut old_pruner, &before, i)),
            })
            .collect()
    }

    /// Which of a block's cells edits can have changed: a bit for each. The pruner has marked the cells by `lists.now`.
    fn changed(&self, first: UVec3, lists: &Lists, pruner: &mut Pruner<'_>) -> u64 {
        let (Some(before), Some(touched)) = (&lists.before, self.live.touched()) else {
            return u64::MAX;
        };
        let is_one = |instr: &Instr| touched.has(instr);
        let mut changed = pruner.needed(&lists.now, is_one);
        if touched.any(before) {
            let centers: [Vec3; CELLS] = std::array::from_fn(|i| {
                let i = i as u32;
                self.layout
                    .middle(first + uvec3(i % 4, i / 4 % 4, i / 16), 1)
            });
            let mut d = [0.0; CELLS];
            pruner.mark(before, &centers, self.layout.half_diagonal(1), &mut d);
            changed |= pruner.needed(before, is_one);
        }
        changed
    }

    /// Measure a block's cells, and sample what is dirty.
    fn make<T: Texel>(&self, worker: &mut Worker<'_>, lists: &Lists, old: &[u32]) -> Made<T> {
        let (block, instrs) = (lists.block, &lists.now);
        let first = self.layout.cell_at(block * CELLS);
        let mut words = [0; CELLS];
        let Worker { pruner, filler } = worker;
        let found: Candidates = near_block(
            &self.layout,
            &self.bounds,
            first,
            instrs,
            pruner,
            &mut words,
        );
        let changed = self.changed(first, lists, pruner);
        let mut made = Made {
            block,
            words,
            bricks: Vec::new(),
            texels: Vec::new(),
            mixed: Vec::new(),
        };
        let reach = 0.5 * 3f32.sqrt() * self.layout.lattice.voxel;
        let samples = self.layout.brick_samples() as usize;
        let old = &old[block * CELLS..(block + 1) * CELLS];
        let last = self.layout.cell_box(first + (BLOCK_SIDE - 1));
        let held = Aabb::new(self.layout.cell_box(first).min, last.max);
        let held = held.grown(self.layout.lattice.voxel);
        let near = self.boxes.iter().map(|[dirty, _]| *dirty);
        let dirty: Vec<Aabb> = near
            .filter(|dirty| !held.intersection(*dirty).is_empty())
            .collect();
        let mut next = found.cells.iter().peekable();
        for (i, &old) in old.iter().enumerate() {
            let is_changed = changed >> i & 1 != 0;
            let list: Option<Range<usize>> = next
                .next_if(|&&(inner, _)| usize::from(inner) == i)
                .map(|(_, range)| range.clone());
            let place = i as u32;
            let cell = first + uvec3(place % 4, place / 4 % 4, place / 16);
            if !is_changed {
                // Whether the block is empty is found out anew.
                made.words[i] = if is_brick(old) {
                    old
                } else {
                    empty_word(center_of(old))
                };
                continue;
            }
            // What lies on a cell's side is in both.
            let held = self
                .layout
                .cell_box(cell)
                .grown(0.01 * self.layout.lattice.voxel);
            if dirty
                .iter()
                .all(|dirty| held.intersection(*dirty).is_empty())
            {
                // Nothing changed that a brick holds.
                if is_brick(old) {
                    made.words[i] = old;
                }
                continue;
            }
            let Some(list) = list else { continue };
            let list = &found.instrs[list];
            let begin = made.texels.len();
            made.texels.resize(begin + samples, T::default());
            let least = filler.brick(list, cell, &mut made.texels[begin..]);
            if self.bounds.is_clear(least, reach) {
                made.texels.truncate(begin);
                continue;
            }
            let material = filler.material(list, cell, &mut made.mixed);
            made.bricks.push((i as u8, material));
            // Any brick: which one is known when it is put into the pool.
            made.words[i] = 0;
        }
        made
    }
}
