//! The blocks that edits left to rebuild, and which of their cells to sample.

use super::plan::searched;
use super::{BLOCK_SIDE, BrickLayout, inner_cell};
use argil_field::{CELLS_PER_BATCH, IncrementalProgram};
use argil_math::Aabb;
use glam::{IVec3, Vec3};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum blocks in the boxes of edits. Larger edits are baked instead.
const MAX_BLOCKS: f32 = 262_144.0;
/// Maximum boxes in which a larger layout has something new, before they are joined.
const MAX_NEW_BOXES: usize = 256;
/// Maximum blocks per batch, if the work has a time budget.
const SHORT_UNIT: usize = 4;

/// Blocks of one part that are rebuilt together.
#[derive(Clone, Debug, PartialEq)]
pub struct EditBatch {
    /// Their part of an [`IncrementalProgram`].
    pub part: IVec3,
    /// The first cell of each block.
    pub blocks: Vec<IVec3>,
}

/// The blocks that edits left to rebuild. Interrupted work can continue later.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditQueue {
    /// For each edit, its dirty box and its influence box.
    boxes: Vec<[Aabb; 2]>,
    units: Vec<EditBatch>,
    /// Whether all work comes from the program's last update, so that its change set is complete.
    is_latest: bool,
    /// Boxes in which more than distances changed: facts about jumps, or whether blocks are examined at all.
    loosened: Vec<Aabb>,
    /// Of blocks that ran out of time, the cells that are rebuilt already, one bit each.
    rebuilt: FxHashMap<IVec3, u64>,
}

impl EditQueue {
    /// Creates the work for edits that `incremental` has just applied, whose boxes have a layout's
    /// [margins](BrickLayout::margins). `before` is the layout before them, whose box may be smaller. Returns `None` if a
    /// rebuild is as fast.
    pub fn new(
        layout: &BrickLayout,
        before: &BrickLayout,
        incremental: &IncrementalProgram,
        boxes: &[[Aabb; 2]],
    ) -> Option<Self> {
        // Cells account for jumps as far as they store distances.
        let far = layout.far_length() + layout.cell_length();
        let loosened = incremental.jumps_added().iter().map(|held| held.grown(far));
        let loosened: Vec<Aabb> = loosened
            .chain(newly_searched(layout, before, incremental))
            .collect();
        let mut work = Self {
            boxes: joined(boxes),
            units: Vec::new(),
            is_latest: true,
            loosened: loosened.clone(),
            rebuilt: FxHashMap::default(),
        };
        work.boxes
            .extend(loosened.into_iter().map(|held| [held; 2]));
        let blocks = work.touched_blocks(layout)?;
        work.units = units(layout, incremental, blocks);
        Some(work)
    }

    /// Adds the work of earlier edits.
    pub fn merge(
        &mut self,
        layout: &BrickLayout,
        incremental: &IncrementalProgram,
        remaining: Self,
    ) {
        if remaining.units.is_empty() {
            return;
        }
        let all = self.units.iter().chain(&remaining.units);
        let blocks = all.flat_map(|unit| unit.blocks.iter().map(|block| block.to_array()));
        let blocks = blocks.collect();
        // What the new edits touch is rebuilt whole.
        let touched = self.units.iter().flat_map(|unit| &unit.blocks);
        let mut rebuilt = remaining.rebuilt;
        touched.for_each(|block| _ = rebuilt.remove(block));
        self.rebuilt = rebuilt;
        self.units = units(layout, incremental, blocks);
        self.boxes.extend(remaining.boxes);
        self.loosened.extend(remaining.loosened);
        self.is_latest = false;
    }

    /// Cuts batches small, and sorts them by their distance to a point.
    pub fn sort_by_distance(&mut self, layout: &BrickLayout, priority_point: Vec3) {
        let cut = |unit: &EditBatch| -> Vec<EditBatch> {
            let few = unit.blocks.chunks(SHORT_UNIT);
            let blocks = few.map(<[IVec3]>::to_vec);
            let part = unit.part;
            blocks.map(|blocks| EditBatch { part, blocks }).collect()
        };
        self.units = self.units.iter().flat_map(cut).collect();
        let nearest = |unit: &EditBatch| {
            let distances = unit.blocks.iter().map(|&block| {
                let middle = layout.center(block, BLOCK_SIDE);
                middle.distance_squared(priority_point)
            });
            distances.fold(f32::INFINITY, f32::min)
        };
        self.units
            .sort_by_cached_key(|unit| nearest(unit).max(0.0).to_bits());
    }

    /// Takes the first batches.
    pub fn next(&mut self, count: usize) -> Vec<EditBatch> {
        self.units.drain(..count.min(self.units.len())).collect()
    }

    /// Puts blocks back that ran out of time, each with its cells that remain.
    pub(super) fn put_back(
        &mut self,
        layout: &BrickLayout,
        incremental: &IncrementalProgram,
        blocks: &[(IVec3, u64)],
    ) {
        self.rebuilt
            .extend(blocks.iter().map(|&(block, cells)| (block, !cells)));
        let blocks = blocks.iter().map(|(block, _)| block.to_array());
        let mut all = units(layout, incremental, blocks.collect());
        all.append(&mut self.units);
        self.units = all;
    }

    /// Returns the cells of a block that remain to be rebuilt, one bit each.
    pub(super) fn remaining_cells(&self, block: IVec3) -> u64 {
        !self.rebuilt.get(&block).copied().unwrap_or(0)
    }

    /// Whether nothing remains.
    pub fn is_done(&self) -> bool {
        self.units.is_empty()
    }

    /// Returns the number of remaining blocks.
    pub fn blocks(&self) -> u64 {
        self.units.iter().map(|unit| unit.blocks.len() as u64).sum()
    }

    /// Whether the change set of the program's last update is complete.
    pub(crate) fn is_latest(&self) -> bool {
        self.is_latest
    }

    /// Whether more than distances can have changed in a block.
    pub(crate) fn is_loosened(&self, layout: &BrickLayout, first: IVec3) -> bool {
        let last = layout.cell_box(first + (BLOCK_SIDE as i32 - 1));
        let block = Aabb::new(layout.cell_box(first).min, last.max);
        let mut loosened = self.loosened.iter();
        loosened.any(|held| !held.intersection(block).is_empty())
    }

    /// Returns the cells of a block whose samples can have changed, one bit each. Jumps are considered as far as
    /// cells store distances.
    pub fn dirty_cells(
        &self,
        layout: &BrickLayout,
        incremental: &IncrementalProgram,
        first: IVec3,
    ) -> u64 {
        let last = layout.cell_box(first + (BLOCK_SIDE as i32 - 1));
        let block = Aabb::new(layout.cell_box(first).min, last.max);
        // Jumps are decided for a whole block, wherever in it they are.
        let jumps = incremental
            .program()
            .jumps_near(block, layout.cell_length());
        if jumps.gap < f32::MAX || self.is_loosened(layout, first) {
            return u64::MAX;
        }
        let block = block.grown(layout.voxel_grid.voxel_size);
        let touches = |held: Aabb, dirty: &Aabb| !held.intersection(*dirty).is_empty();
        let mut cells = 0;
        for [dirty, _] in &self.boxes {
            if !touches(block, dirty) || cells == u64::MAX {
                continue;
            }
            for i in 0..CELLS_PER_BATCH {
                let cell = first + inner_cell(i);
                // A point on a cell's side belongs to both cells.
                let held = layout
                    .cell_box(cell)
                    .grown(0.01 * layout.voxel_grid.voxel_size);
                cells |= u64::from(touches(held, dirty)) << i;
            }
        }
        cells
    }

    fn touched_blocks(&self, layout: &BrickLayout) -> Option<BTreeSet<[i32; 3]>> {
        let edge = layout.cell_length() * BLOCK_SIDE as f32;
        let mut blocks = BTreeSet::new();
        let [low, high] = searched(layout).map(|block| block.as_vec3());
        let high = high - 1.0;
        let mut count = 0.0;
        for [_, far] in &self.boxes {
            let first = ((far.min - layout.voxel_grid.corner) / edge).floor();
            let end = ((far.max - layout.voxel_grid.corner) / edge).floor();
            // No surface is elsewhere: the box has grown for what was inserted outside it.
            if far.is_empty() || !first.cmple(high).all() || !end.cmpge(low).all() {
                continue;
            }
            let (first, end) = (first.clamp(low, high), end.clamp(low, high));
            count += (end - first + 1.0).element_product();
            if count > MAX_BLOCKS {
                return None;
            }
            let (first, end) = (first.as_ivec3(), end.as_ivec3());
            for z in first.z..=end.z {
                for y in first.y..=end.y {
                    for x in first.x..=end.x {
                        let block = IVec3::new(x, y, z) * BLOCK_SIDE as i32;
                        blocks.insert(block.to_array());
                    }
                }
            }
        }
        Some(blocks)
    }
}

/// Returns boxes of the blocks that a larger layout examines and the one before did not, where distances are small enough to be
/// stored: those that a modifier divides are small far outside the solid's box.
fn newly_searched(
    layout: &BrickLayout,
    before: &BrickLayout,
    incremental: &IncrementalProgram,
) -> Vec<Aabb> {
    let (outer, inner) = (searched(layout), searched(before));
    if outer == inner {
        return Vec::new();
    }
    let edge = layout.cell_length() * BLOCK_SIDE as f32;
    let corner = layout.voxel_grid.corner;
    let slab = |side: usize| {
        let ([mut first, mut end], axis) = (outer, side / 2);
        if side % 2 == 1 {
            first[axis] = inner[1][axis];
        } else {
            end[axis] = inner[0][axis];
        }
        let place = |block: IVec3| corner + edge * block.as_vec3();
        let is_new = first.cmplt(end).all();
        is_new.then(|| Aabb::new(place(first), place(end)))
    };
    let slabs: Vec<Aabb> = (0..6).filter_map(slab).collect();
    let near = incremental.near_boxes();
    let beyond = near.flat_map(|near| slabs.iter().map(move |slab| slab.intersection(near)));
    let found: Vec<Aabb> = beyond.filter(|held| !held.is_empty()).collect();
    if found.len() <= MAX_NEW_BOXES {
        return found;
    }
    let whole = |slab: &Aabb| {
        let held = found.iter().map(|held| held.intersection(*slab));
        held.fold(Aabb::EMPTY, Aabb::union)
    };
    slabs.iter().map(whole).collect()
}

/// Groups blocks by part.
fn units(
    layout: &BrickLayout,
    incremental: &IncrementalProgram,
    blocks: BTreeSet<[i32; 3]>,
) -> Vec<EditBatch> {
    let side = (incremental.parts().edge / layout.cell_length()).round() as i32;
    let mut parts: BTreeMap<[i32; 3], Vec<IVec3>> = BTreeMap::new();
    for block in blocks {
        let block = IVec3::from_array(block);
        parts
            .entry(block.div_euclid(IVec3::splat(side)).to_array())
            .or_default()
            .push(block);
    }
    let unit = |(part, blocks)| EditBatch {
        part: IVec3::from_array(part),
        blocks,
    };
    parts.into_iter().map(unit).collect()
}

/// Merges boxes of consecutive edits if the union is hardly larger, as for a drag.
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
