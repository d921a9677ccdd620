//! Finds blocks: a tree over space whose leaves are slots of blocks.
//!
//! *Practice.* The top is a small array over the box of all blocks. Its entries are cubes of 8^levels blocks. Below
//! it are nodes of 8³ entries. Typical scenes have only the top, and its entries are blocks. A missing block is far
//! from every surface: its entry names a slot of words that say so, and how large the empty cube is.
//! `bricks/cell.wgsl` has the twin of the look-up.

use super::BLOCK_SIDE;
use super::cell::{block_empty_word, empty_word};
pub use argil_abi::{FAR_ENTRY, FAR_SLOTS};
use glam::{IVec3, UVec3};
use std::ops::Range;

/// Entries along a node's side, as a power of two.
const NODE_BITS: u32 = 3;
/// Entries of a node.
const NODE: usize = 1 << (3 * NODE_BITS);
/// Maximum entries of the top. More entries add a level.
const MAX_TOP: u64 = 1 << 16;
/// Maximum levels: enough for all voxels that can be counted.
const MAX_LEVELS: u32 = 7;
/// Farthest block from the grid's corner, along an axis. All voxels that can be counted are nearer.
const MAX_BLOCK: i32 = 1 << 20;
/// Maximum entries, and maximum slots: words are numbered with 32 bits.
const MAX_ENTRIES: usize = 1 << 30;
const MAX_SLOTS: usize = 1 << 26;
/// The block of a slot that has none.
const NONE: IVec3 = IVec3::splat(i32::MIN / 64);
const _: () = assert!(FAR_SLOTS == 2 * (MAX_LEVELS + 1), "two for each level");

/// A map from block positions to slots. A slot has 64 words, one per cell.
#[derive(Clone, Debug)]
pub struct BlockTable {
    /// The first entry of the top, in blocks.
    low: IVec3,
    /// Entries of the top.
    size: UVec3,
    levels: u32,
    /// The top, and then nodes.
    entries: Vec<u32>,
    free_nodes: Vec<u32>,
    /// The block of each slot. Arbitrary for free slots.
    blocks: Vec<IVec3>,
    free: Vec<u32>,
    /// The range of entries that changed since it was last taken.
    changed: Range<usize>,
}

impl PartialEq for BlockTable {
    fn eq(&self, other: &Self) -> bool {
        let own = (self.low, self.size, &self.entries, &self.blocks);
        own == (other.low, other.size, &other.entries, &other.blocks)
    }
}

/// Returns the entry of a far cube on a level, outside or inside the solid.
fn far_entry(level: u32, inside: bool) -> u32 {
    FAR_ENTRY | (2 * level + u32::from(inside))
}

/// Returns the words of the slots that no block has.
pub fn far_words(far: f32) -> Vec<u32> {
    let of_slot = |slot: u32| {
        let center = if slot & 1 == 0 { far } else { -far };
        [block_empty_word(empty_word(center)); 64]
    };
    (0..FAR_SLOTS).flat_map(of_slot).collect()
}

impl BlockTable {
    /// Creates a table without blocks, for blocks from `low` to before `high`.
    ///
    /// # Panics
    /// If one of them is a million blocks away from the grid's corner.
    pub fn new(low: IVec3, high: IVec3) -> Self {
        let mut table = Self {
            low,
            size: UVec3::ONE,
            levels: 0,
            entries: vec![far_entry(0, false)],
            free_nodes: Vec::new(),
            blocks: vec![NONE; FAR_SLOTS as usize],
            free: Vec::new(),
            changed: 0..0,
        };
        table.reroot(low, high);
        table
    }

    /// Returns the number of levels below the top.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Returns the first entry of the top, in blocks, and the number of its entries along each axis.
    pub fn top(&self) -> (IVec3, UVec3) {
        (self.low, self.size)
    }

    /// Returns the top, x fastest, and then nodes of 8³. An entry is a slot, the start of a node, or a
    /// [`FAR_ENTRY`].
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// Takes the range of entries that may have changed since the last call.
    pub fn take_changed(&mut self) -> Range<usize> {
        std::mem::replace(&mut self.changed, 0..0)
    }

    /// Returns the number of slots, including free ones and the far slots.
    pub fn slots(&self) -> usize {
        self.blocks.len()
    }

    /// Returns the number of blocks.
    pub fn len(&self) -> usize {
        self.blocks.len() - FAR_SLOTS as usize - self.free.len()
    }

    /// Whether there is no block.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the bytes of the tree and the slots' positions.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&self.entries[..]) + size_of_val(&self.blocks[..])) as u64
    }

    /// Returns the first cell of the block in a slot.
    pub fn cell(&self, slot: usize) -> IVec3 {
        self.blocks[slot] * BLOCK_SIDE as i32
    }

    /// Iterates over all blocks and their slots.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, IVec3)> + '_ {
        let all = self.blocks.iter().copied().enumerate();
        all.filter(|(_, block)| *block != NONE)
    }

    /// Returns the slot with a block's words: its own, or a far slot.
    #[inline]
    pub fn slot(&self, block: IVec3) -> u32 {
        let at = block - self.low;
        let top = (at >> (NODE_BITS * self.levels)).as_uvec3();
        // Coordinates below the first entry wrap around.
        if !top.cmplt(self.size).all() {
            return far_entry(self.levels, false) & !FAR_ENTRY;
        }
        let place = top.x + self.size.x * (top.y + self.size.y * top.z);
        let mut entry = self.entries[place as usize];
        let mut level = self.levels;
        while level > 0 && entry & FAR_ENTRY == 0 {
            level -= 1;
            entry = self.entries[entry as usize + child(at, level)];
        }
        entry & !FAR_ENTRY
    }

    /// Returns the slot of a block, or `None` if it is missing.
    pub fn find(&self, block: IVec3) -> Option<u32> {
        Some(self.slot(block)).filter(|&slot| slot >= FAR_SLOTS)
    }

    /// Inserts a block and returns its slot. The box of blocks grows to contain it.
    ///
    /// # Panics
    /// If the block is a million blocks away from the grid's corner. If there would be more than 2²⁶ blocks or 2³⁰ entries.
    pub fn insert(&mut self, block: IVec3) -> u32 {
        self.grow_to(block, block.saturating_add(IVec3::ONE));
        let at = block - self.low;
        let mut place = self.top_place(at);
        for level in (0..self.levels).rev() {
            place = self.node_at(place) + child(at, level);
        }
        let entry = self.entries[place];
        if entry & FAR_ENTRY == 0 {
            return entry;
        }
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                assert!(self.blocks.len() < MAX_SLOTS, "at most {MAX_SLOTS} blocks");
                self.blocks.push(NONE);
                self.blocks.len() as u32 - 1
            }
        };
        self.blocks[slot as usize] = block;
        self.set(place, slot);
        slot
    }

    /// Removes a block that is far from everything now, on one side.
    pub fn remove(&mut self, block: IVec3, inside: bool) {
        if self.find(block).is_some() {
            self.set_far(block, block + 1, inside);
        }
    }

    /// Marks the blocks from `low` to before `high` as far from everything, on one side, and removes existing ones.
    ///
    /// # Panics
    /// If the table would have more than 2³⁰ entries.
    pub fn set_far(&mut self, low: IVec3, high: IVec3, inside: bool) {
        let end = self.low + (self.size.as_ivec3() << (NODE_BITS * self.levels));
        let (low, high) = (low.max(self.low), high.min(end));
        if low.cmpge(high).any() {
            return;
        }
        let edge = 1 << (NODE_BITS * self.levels);
        let (first, last) = ((low - self.low) / edge, (high - 1 - self.low) / edge);
        for place in places(first, last) {
            let corner = self.low + place * edge;
            let at = place.as_uvec3();
            let at = at.x + self.size.x * (at.y + self.size.y * at.z);
            self.set_far_in(at as usize, corner, self.levels, (low, high), inside);
        }
    }

    /// Marks blocks within an entry of a level.
    fn set_far_in(
        &mut self,
        place: usize,
        corner: IVec3,
        level: u32,
        (low, high): (IVec3, IVec3),
        inside: bool,
    ) {
        let edge = 1 << (NODE_BITS * level);
        let all = corner.cmpge(low).all() && (corner + edge).cmple(high).all();
        let far = far_entry(level, inside);
        let is_so = |entry: u32| entry & FAR_ENTRY != 0 && entry & 1 == far & 1;
        if all || level == 0 {
            self.release_node(place, level);
            self.set(place, far);
            return;
        }
        if is_so(self.entries[place]) {
            return;
        }
        let node = self.node_at(place);
        let part = edge >> NODE_BITS;
        let (first, last) = (
            (low.max(corner) - corner) / part,
            (high.min(corner + edge) - 1 - corner) / part,
        );
        for inner in places(first, last) {
            let corner = corner + inner * part;
            let to = node + (inner.x + 8 * inner.y + 64 * inner.z) as usize;
            self.set_far_in(to, corner, level - 1, (low, high), inside);
        }
        // A node with nothing in it becomes an entry again.
        if self.entries[node..node + NODE].iter().all(|&e| is_so(e)) {
            self.free_nodes.push(node as u32);
            self.set(place, far);
        }
    }

    /// Releases what an entry of a level contains.
    fn release_node(&mut self, place: usize, level: u32) {
        let entry = self.entries[place];
        if entry & FAR_ENTRY != 0 {
            return;
        }
        if level == 0 {
            self.blocks[entry as usize] = NONE;
            self.free.push(entry);
            return;
        }
        for inner in 0..NODE {
            self.release_node(entry as usize + inner, level - 1);
        }
        self.free_nodes.push(entry);
    }

    /// Returns the start of an entry's node, and creates one if needed.
    fn node_at(&mut self, place: usize) -> usize {
        let entry = self.entries[place];
        if entry & FAR_ENTRY == 0 {
            return entry as usize;
        }
        // An entry of the level above: its words hold for smaller cubes too.
        let below = FAR_ENTRY | (entry & !FAR_ENTRY).saturating_sub(2);
        let node = match self.free_nodes.pop() {
            Some(node) => {
                let node = node as usize;
                self.entries[node..node + NODE].fill(below);
                self.note(node..node + NODE);
                node
            }
            None => {
                let node = self.entries.len();
                assert!(node + NODE <= MAX_ENTRIES, "at most {MAX_ENTRIES} entries");
                self.entries.resize(node + NODE, below);
                self.note(node..node + NODE);
                node
            }
        };
        self.set(place, node as u32);
        node
    }

    fn set(&mut self, place: usize, entry: u32) {
        self.entries[place] = entry;
        self.note(place..place + 1);
    }

    fn note(&mut self, some: Range<usize>) {
        self.changed = if self.changed.is_empty() {
            some
        } else {
            self.changed.start.min(some.start)..self.changed.end.max(some.end)
        };
    }

    fn top_place(&self, at: IVec3) -> usize {
        let top = (at >> (NODE_BITS * self.levels)).as_uvec3();
        (top.x + self.size.x * (top.y + self.size.y * top.z)) as usize
    }

    /// Grows to contain the blocks from `low` to before `high`.
    ///
    /// # Panics
    /// If one of them is a million blocks away from the grid's corner.
    pub fn grow_to(&mut self, low: IVec3, high: IVec3) {
        let end = self.low + (self.size.as_ivec3() << (NODE_BITS * self.levels));
        if low.cmplt(self.low).any() || high.cmpgt(end).any() {
            // What is inside stays inside: only infinite solids extend beyond the box, and they are clipped.
            self.reroot(self.low.min(low), end.max(high));
        }
    }

    /// Builds the tree again over a larger box.
    fn reroot(&mut self, low: IVec3, high: IVec3) {
        assert!(
            low.min_element() >= -MAX_BLOCK && high.max_element() <= MAX_BLOCK,
            "blocks from {low} to {high}"
        );
        let old = self.clone();
        let extent = (high - low).max(IVec3::ONE).as_uvec3();
        let mut levels = 0;
        let entries_at = |levels: u32| {
            let size = extent
                .to_array()
                .map(|n| u64::from(n >> (NODE_BITS * levels)) + 2);
            size.iter().product::<u64>()
        };
        while levels < MAX_LEVELS && entries_at(levels) > MAX_TOP {
            levels += 1;
        }
        let edge = 1 << (NODE_BITS * levels);
        // Cubes have the same positions in any box.
        self.low = (low >> (NODE_BITS * levels)) << (NODE_BITS * levels);
        self.size = ((high - self.low + (edge - 1)) >> (NODE_BITS * levels)).as_uvec3();
        self.levels = levels;
        self.entries.clear();
        let top = self.size.element_product() as usize;
        self.entries.resize(top, far_entry(levels, false));
        self.free_nodes.clear();
        self.changed = 0..top;
        old.for_each_far_inside(|low, high| self.set_far(low, high, true));
        for (slot, block) in old.blocks() {
            let at = block - self.low;
            let mut place = self.top_place(at);
            for level in (0..self.levels).rev() {
                place = self.node_at(place) + child(at, level);
            }
            self.set(place, slot as u32);
        }
    }

    /// Calls `tell` for each cube of missing blocks far inside the solid, from one block to before another.
    pub fn for_each_far_inside(&self, mut tell: impl FnMut(IVec3, IVec3)) {
        let edge = 1 << (NODE_BITS * self.levels);
        let mut open: Vec<(u32, IVec3, u32)> = Vec::new();
        for place in places(IVec3::ZERO, self.size.as_ivec3() - 1) {
            let entry = self.entries[self.top_place(place * edge)];
            open.push((entry, self.low + place * edge, self.levels));
        }
        while let Some((entry, corner, level)) = open.pop() {
            let edge = 1 << (NODE_BITS * level);
            if entry & FAR_ENTRY != 0 {
                if entry & 1 != 0 {
                    tell(corner, corner + edge);
                }
            } else if level > 0 {
                for inner in places(IVec3::ZERO, IVec3::splat(7)) {
                    let corner = corner + inner * (edge >> NODE_BITS);
                    let at = entry as usize + (inner.x + 8 * inner.y + 64 * inner.z) as usize;
                    open.push((self.entries[at], corner, level - 1));
                }
            }
        }
    }

    /// Returns the cells along the side of the empty cube that a far slot means.
    #[inline]
    pub fn far_cells(slot: u32) -> u32 {
        BLOCK_SIDE << (NODE_BITS * (slot / 2))
    }
}

/// Returns the index of a block within a node, counted from the tree's first block.
#[inline(always)]
fn child(at: IVec3, level: u32) -> usize {
    let inner = (at >> (NODE_BITS * level)) & 7;
    (inner.x + 8 * inner.y + 64 * inner.z) as usize
}

/// Iterates over all positions from one to another, x fastest.
pub(crate) fn places(first: IVec3, last: IVec3) -> impl Iterator<Item = IVec3> {
    (first.z..=last.z).flat_map(move |z| {
        (first.y..=last.y).flat_map(move |y| (first.x..=last.x).map(move |x| IVec3::new(x, y, z)))
    })
}

#[cfg(test)]
mod tests;
