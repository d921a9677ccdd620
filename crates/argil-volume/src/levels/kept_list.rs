//! What is kept of pages, so that the pages below them get their programs at little cost.

use argil_abi::Instruction;
use argil_field::CellMarks;
use std::sync::Arc;

/// The program of a page.
#[derive(Clone, Debug)]
pub enum PageList<'a> {
    /// That of the whole scene, in pages of the coarsest level.
    Whole(&'a [Instruction]),
    /// What can matter in the page.
    Pruned(Arc<[Instruction]>),
}

impl std::ops::Deref for PageList<'_> {
    type Target = [Instruction];

    fn deref(&self) -> &[Instruction] {
        match self {
            PageList::Whole(all) => all,
            PageList::Pruned(list) => list,
        }
    }
}

/// The measured cells of a page.
#[derive(Debug)]
pub(super) struct PageCells {
    /// The distances at the cells' centers.
    pub distances: [f32; 8],
    /// What each drops of the page's program.
    pub marks: CellMarks,
}

/// What is kept of a page, and counts against a limit.
pub(super) trait Kept {
    /// Returns the bytes in memory.
    fn bytes(&self) -> u64;
}

impl Kept for Arc<[Instruction]> {
    fn bytes(&self) -> u64 {
        size_of_val(&self[..]) as u64
    }
}

impl Kept for Arc<PageCells> {
    fn bytes(&self) -> u64 {
        (size_of_val(&self.distances) + self.marks.memory_bytes()) as u64
    }
}

/// What is kept of pages, by slot. What was not used for the longest time goes first.
#[derive(Clone, Debug)]
pub(super) struct KeptBySlot<T> {
    /// When each was used last, and what it is.
    slots: Vec<Option<(u32, T)>>,
    bytes: u64,
}

impl<T> Default for KeptBySlot<T> {
    fn default() -> Self {
        Self {
            slots: Vec::new(),
            bytes: 0,
        }
    }
}

impl<T: Kept> KeptBySlot<T> {
    /// The bytes of a slot.
    pub(super) const SLOT_BYTES: u64 = size_of::<Option<(u32, T)>>() as u64;

    /// Adds an empty slot.
    pub(super) fn push(&mut self) {
        self.slots.push(None);
    }

    /// Returns the bytes of all that is kept.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(super) fn get(&self, slot: u32) -> Option<&T> {
        self.slots[slot as usize].as_ref().map(|(_, kept)| kept)
    }

    /// Marks a slot as used. Returns whether it was already.
    pub(super) fn touch(&mut self, slot: u32, now: u32) -> bool {
        match &mut self.slots[slot as usize] {
            Some((used, _)) => std::mem::replace(used, now) == now,
            None => false,
        }
    }

    pub(super) fn forget(&mut self, slot: u32) {
        if let Some((_, kept)) = self.slots[slot as usize].take() {
            self.bytes -= kept.bytes();
        }
    }

    pub(super) fn forget_all(&mut self) {
        self.slots.fill_with(|| None);
        self.bytes = 0;
    }

    /// Keeps more, as far as there is room within a limit without what was used now.
    pub(super) fn keep(&mut self, made: Vec<(u32, T)>, limit: u64, now: u32) {
        let needed: u64 = made.iter().map(|(_, kept)| kept.bytes()).sum();
        self.shrink(limit.saturating_sub(needed), now);
        for (slot, kept) in made {
            self.forget(slot);
            if self.bytes + kept.bytes() <= limit {
                self.bytes += kept.bytes();
                self.slots[slot as usize] = Some((now, kept));
            }
        }
    }

    /// Forgets what was used before a time, the longest unused first, until no more than some bytes are kept.
    pub(super) fn shrink(&mut self, limit: u64, before: u32) {
        if self.bytes <= limit {
            return;
        }
        let used =
            |(slot, kept): (u32, &Option<(u32, T)>)| kept.as_ref().map(|(used, _)| (*used, slot));
        let mut old: Vec<(u32, u32)> = (0u32..).zip(&self.slots).filter_map(used).collect();
        old.retain(|own| own.0 < before);
        old.sort_unstable();
        for (_, slot) in old {
            if self.bytes <= limit {
                break;
            }
            self.forget(slot);
        }
    }
}
