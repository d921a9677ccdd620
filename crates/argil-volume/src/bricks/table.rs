//! Where blocks of cells are: a tree over space whose leaves are slots of blocks, in place of a word for each cell of a box.
//!
//! *Practice.* The top is a small array over the box of all blocks, whose entries are cubes of 8^levels blocks; below it are
//! nodes of 8³ entries. A scene of usual size has no level but the top, whose entries are blocks then. What has no block is
//! far from every surface; its entry names a slot of words that say so, and how large the empty cube is.
//! `bricks/words.wgsl` has the twin of the look-up.

use super::BLOCK_SIDE;
use super::cell::{block_empty_word, empty_word};
pub use argil_abi::{FAR_ENTRY, FAR_SLOTS};
use glam::{IVec3, UVec3};
use std::ops::Range;

/// Entries along a node's side, as a power of two.
const NODE_BITS: u32 = 3;
/// Entries of a node.
const NODE: usize = 1 << (3 * NODE_BITS);
/// Most entries of the top; with more there is another level.
const MAX_TOP: u64 = 1 << 16;
/// Most levels: enough for as many voxels as can be counted.
const MAX_LEVELS: u32 = 7;
/// In place of a block that a slot has not.
const NONE: IVec3 = IVec3::splat(i32::MIN / 64);
const _: () = assert!(FAR_SLOTS == 2 * (MAX_LEVELS + 1), "two for each level");

/// Where blocks are. See the module's page.
#[derive(Clone, Debug)]
pub struct BlockTable {
    /// The first entry of the top, in blocks.
    low: IVec3,
    /// Entries of the top.
    size: UVec3,
    levels: u32,
    /// The top, then nodes.
    entries: Vec<u32>,
    free_nodes: Vec<u32>,
    /// Of each slot: which block, and of one that is free, nothing that means anything.
    blocks: Vec<IVec3>,
    free: Vec<u32>,
    /// What was changed among the entries since it was last asked for.
    changed: Range<usize>,
}

impl PartialEq for BlockTable {
    fn eq(&self, other: &Self) -> bool {
        let own = (self.low, self.size, &self.entries, &self.blocks);
        own == (other.low, other.size, &other.entries, &other.blocks)
    }
}

/// What of a block a slot is for: far from everything, outside or inside.
fn far_entry(level: u32, inside: bool) -> u32 {
    FAR_ENTRY | (2 * level + u32::from(inside))
}

/// The words of the slots that no block has.
pub fn far_words(far: f32) -> Vec<u32> {
    let of_slot = |slot: u32| {
        let center = if slot & 1 == 0 { far } else { -far };
        [block_empty_word(empty_word(center)); 64]
    };
    (0..FAR_SLOTS).flat_map(of_slot).collect()
}

impl BlockTable {
    /// Without blocks, for those from `low` to before `high`.
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

    /// Levels below the top.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The first entry of the top, in blocks, and entries of the top along each axis.
    pub fn top(&self) -> (IVec3, UVec3) {
        (self.low, self.size)
    }

    /// The top, x fastest, then nodes of 8³. An entry is a slot or, above the last level, where a node begins; or a
    /// [`FAR_ENTRY`].
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// The entries that may have changed since this was last asked for.
    pub fn take_changed(&mut self) -> Range<usize> {
        std::mem::replace(&mut self.changed, 0..0)
    }

    /// Slots that there are, free ones and those of no block among them.
    pub fn slots(&self) -> usize {
        self.blocks.len()
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.blocks.len() - FAR_SLOTS as usize - self.free.len()
    }

    /// Whether there is no block.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of the tree and of what is known of slots.
    pub fn memory_bytes(&self) -> u64 {
        (size_of_val(&self.entries[..]) + size_of_val(&self.blocks[..])) as u64
    }

    /// The first cell of the block in a slot.
    pub fn cell(&self, slot: usize) -> IVec3 {
        self.blocks[slot] * BLOCK_SIDE as i32
    }

    /// All blocks and their slots.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, IVec3)> + '_ {
        let all = self.blocks.iter().copied().enumerate();
        all.filter(|(_, block)| *block != NONE)
    }

    /// The slot in which to look for a block's words: its own, or one of far words.
    #[inline]
    pub fn slot(&self, block: IVec3) -> u32 {
        let at = block - self.low;
        let top = (at >> (NODE_BITS * self.levels)).as_uvec3();
        // What is below wraps around.
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

    /// The slot of a block that is there.
    pub fn find(&self, block: IVec3) -> Option<u32> {
        Some(self.slot(block)).filter(|&slot| slot >= FAR_SLOTS)
    }

    /// Put a block in; its slot. The box of blocks grows to hold it.
    pub fn insert(&mut self, block: IVec3) -> u32 {
        self.cover(block, block + 1);
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
                self.blocks.push(NONE);
                self.blocks.len() as u32 - 1
            }
        };
        self.blocks[slot as usize] = block;
        self.set(place, slot);
        slot
    }

    /// Take a block out that is far from everything now, on one side.
    pub fn remove(&mut self, block: IVec3, inside: bool) {
        if self.find(block).is_some() {
            self.set_far(block, block + 1, inside);
        }
    }

    /// Say of the blocks from `low` to before `high` that they are far from everything, on one side; those that are there are
    /// taken out.
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

    /// The same within an entry of a level.
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
        // A node without anything is an entry again.
        if self.entries[node..node + NODE].iter().all(|&e| is_so(e)) {
            self.free_nodes.push(node as u32);
            self.set(place, far);
        }
    }

    /// Give back what an entry of a level holds.
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

    /// Where the node of an entry begins, which is made if there is none.
    fn node_at(&mut self, place: usize) -> usize {
        let entry = self.entries[place];
        if entry & FAR_ENTRY == 0 {
            return entry as usize;
        }
        // Of the level above: the words of what is around tell the same, of a smaller cube.
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

    /// Have room for the blocks from `low` to before `high`.
    pub fn cover(&mut self, low: IVec3, high: IVec3) {
        let end = self.low + (self.size.as_ivec3() << (NODE_BITS * self.levels));
        if low.cmplt(self.low).any() || high.cmpgt(end).any() {
            // What is inside stays inside: only solids without end reach beyond the box, and that is cut.
            self.reroot(self.low.min(low), end.max(high));
        }
    }

    /// Make the tree again, over another box that holds this one.
    fn reroot(&mut self, low: IVec3, high: IVec3) {
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
        // Cubes lie where those of any other box lie.
        self.low = (low >> (NODE_BITS * levels)) << (NODE_BITS * levels);
        self.size = ((high - self.low + (edge - 1)) >> (NODE_BITS * levels)).as_uvec3();
        self.levels = levels;
        self.entries.clear();
        let top = self.size.element_product() as usize;
        self.entries.resize(top, far_entry(levels, false));
        self.free_nodes.clear();
        self.changed = 0..top;
        old.each_inside(|low, high| self.set_far(low, high, true));
        for (slot, block) in old.blocks() {
            let at = block - self.low;
            let mut place = self.top_place(at);
            for level in (0..self.levels).rev() {
                place = self.node_at(place) + child(at, level);
            }
            self.set(place, slot as u32);
        }
    }

    /// The cubes of blocks that are not there, as they are far inside: from one block to before another.
    pub fn each_inside(&self, mut tell: impl FnMut(IVec3, IVec3)) {
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

    /// Cells along the side of the empty cube that a slot of far words is for.
    #[inline]
    pub fn far_cells(slot: u32) -> u32 {
        BLOCK_SIDE << (NODE_BITS * (slot / 2))
    }
}

/// Which of a node's entries a block is in, counted from the tree's first block.
#[inline(always)]
fn child(at: IVec3, level: u32) -> usize {
    let inner = (at >> (NODE_BITS * level)) & 7;
    (inner.x + 8 * inner.y + 64 * inner.z) as usize
}

/// All places from one to another, x fastest.
pub(super) fn places(first: IVec3, last: IVec3) -> impl Iterator<Item = IVec3> {
    (first.z..=last.z).flat_map(move |z| {
        (first.y..=last.y).flat_map(move |y| (first.x..=last.x).map(move |x| IVec3::new(x, y, z)))
    })
}

#[cfg(test)]
mod tests;
