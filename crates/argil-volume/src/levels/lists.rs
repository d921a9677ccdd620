//! The pruned programs of pages.

use super::bake::PageContext;
use super::kept_list::{PageCells, PageList};
use super::page::NO_PAGE;
use super::tree::Levels;
use argil_abi::Instruction;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::Arc;

/// Bytes of pages' programs that are kept, and the part of the budget that they may use.
const LIST_BYTES: u64 = 8 << 20;
const LIST_SHARE: u64 = 24;
/// The same for what is known of the programs of their cells. It is smaller, and saves more time.
const MARK_BYTES: u64 = 32 << 20;
const MARK_SHARE: u64 = 8;

impl Levels {
    /// Returns the programs of pages. Those that are kept come from there, and the others from the page above.
    pub(super) fn lists_of<'a>(
        &mut self,
        context: &PageContext<'a>,
        slots: &[u32],
    ) -> FxHashMap<u32, PageList<'a>> {
        let (mut found, mut unknown) = self.kept_lists(context, slots);
        unknown.sort_unstable_by_key(|&slot| {
            let page = &self.pages[slot as usize];
            (std::cmp::Reverse(page.level), page.parent, slot)
        });
        unknown.dedup();
        let asked: FxHashSet<u32> = slots.iter().copied().collect();
        let level = |slot: u32| self.pages[slot as usize].level;
        let levels: Vec<Vec<u32>> = unknown
            .chunk_by(|&a, &b| level(a) == level(b))
            .map(<[u32]>::to_vec)
            .collect();
        for same in levels {
            self.derive_lists(context, &same, &mut found);
            // Programs near the root are long.
            for slot in same {
                let above = self.pages[slot as usize].parent / 8;
                if !asked.contains(&above) {
                    found.remove(&above);
                }
            }
        }
        let bytes: usize = found.values().map(|list| size_of_val(&list[..])).sum();
        self.mean_list_bytes = (bytes / found.len().max(1)) as u64;
        found
    }

    /// Finds the programs of pages of a level, given those of the pages above, and keeps them as far as there is room.
    fn derive_lists<'a>(
        &mut self,
        context: &PageContext<'a>,
        same: &[u32],
        found: &mut FxHashMap<u32, PageList<'a>>,
    ) {
        let (pages, marks) = (&self.pages, &self.marks);
        let above = |slot: u32| pages[slot as usize].parent / 8;
        let families: Vec<&[u32]> = same.chunk_by(|&a, &b| above(a) == above(b)).collect();
        let own: Vec<FamilyLists> = families
            .par_iter()
            .map_init(
                || context.baker(),
                |baker, family| {
                    let above = above(family[0]);
                    let cell_of = |slot: &u32| pages[*slot as usize].parent % 8;
                    let cells = family.iter().map(cell_of);
                    let cells = cells.fold(0, |all, cell| all | 1u8 << cell);
                    let page = &pages[above as usize];
                    let kept = marks.get(above).map(|kept| &**kept);
                    let (mut lists, measured) = baker.cell_lists(page, &found[&above], cells, kept);
                    let own = family.iter().map(|slot| {
                        let list = std::mem::take(&mut lists[cell_of(slot) as usize]);
                        (*slot, list)
                    });
                    (own.collect(), measured.map(|measured| (above, measured)))
                },
            )
            .collect();
        let (lists, measured): (Vec<_>, Vec<_>) = own.into_iter().unzip();
        self.keep_marks(measured.into_iter().flatten().collect());
        let lists: Vec<(u32, Arc<[Instruction]>)> = lists.into_iter().flatten().collect();
        for (slot, list) in &lists {
            found.insert(*slot, PageList::Pruned(list.clone()));
        }
        let limit = self.list_limit();
        self.lists.keep(lists, limit, self.list_clock);
    }

    /// Returns the kept programs of pages or, where they are not, of the nearest pages above, and the pages on the way
    /// whose programs are unknown.
    fn kept_lists<'a>(
        &mut self,
        context: &PageContext<'a>,
        slots: &[u32],
    ) -> (FxHashMap<u32, PageList<'a>>, Vec<u32>) {
        self.program_bytes = size_of_val(&context.whole()[..]) as u64;
        self.list_clock += 1;
        let now = self.list_clock;
        let mut found: FxHashMap<u32, PageList<'a>> = FxHashMap::default();
        let mut unknown: Vec<u32> = Vec::new();
        for &slot in slots {
            let mut at = slot;
            loop {
                if found.contains_key(&at) {
                    break;
                }
                if let Some(list) = self.lists.get(at) {
                    found.insert(at, PageList::Pruned(list.clone()));
                    self.touch_lists(at, now);
                    break;
                }
                match self.pages[at as usize].parent {
                    NO_PAGE => {
                        found.insert(at, context.whole());
                        break;
                    }
                    parent => {
                        unknown.push(at);
                        at = parent / 8;
                    }
                }
            }
        }
        (found, unknown)
    }

    /// Keeps what was found of the programs of pages' cells, as far as there is room.
    pub(super) fn keep_marks(&mut self, made: Vec<(u32, Arc<PageCells>)>) {
        let limit = self.mark_limit();
        self.marks.keep(made, limit, self.list_clock);
    }

    /// Forgets what is kept of a page.
    pub(super) fn forget_lists(&mut self, slot: u32) {
        self.lists.forget(slot);
        self.marks.forget(slot);
    }

    /// Returns the bytes of what is kept of all pages.
    pub(super) fn list_bytes(&self) -> u64 {
        self.lists.bytes() + self.marks.bytes()
    }

    /// Forgets programs, and what is known of them, if all together exceed the budget.
    pub(super) fn trim_lists(&mut self) {
        for is_list in [true, false] {
            let over = self.used_bytes().saturating_sub(self.budget);
            if is_list {
                self.lists
                    .shrink(self.lists.bytes().saturating_sub(over), u32::MAX);
            } else {
                self.marks
                    .shrink(self.marks.bytes().saturating_sub(over), u32::MAX);
            }
        }
    }

    /// Returns the bytes of the budget that kept programs, and what is known of them, may use.
    pub(super) fn list_share(&self) -> u64 {
        LIST_BYTES.min(self.budget / LIST_SHARE) + MARK_BYTES.min(self.budget / MARK_SHARE)
    }

    /// Returns the most bytes of kept programs: more than their share, if the scene's program is itself longer.
    fn list_limit(&self) -> u64 {
        let share = LIST_BYTES.min(self.budget / LIST_SHARE);
        share.max(self.program_bytes / 4)
    }

    /// Returns the most bytes of what is known of programs.
    fn mark_limit(&self) -> u64 {
        let share = MARK_BYTES.min(self.budget / MARK_SHARE);
        share.max(self.program_bytes / 2)
    }

    /// Marks what is kept of a page and of those above it as used: it is the shortest way to others near them.
    fn touch_lists(&mut self, mut slot: u32, now: u32) {
        loop {
            let was_touched = self.lists.touch(slot, now);
            if self.marks.touch(slot, now) || was_touched {
                return;
            }
            match self.pages[slot as usize].parent {
                NO_PAGE => return,
                parent => slot = parent / 8,
            }
        }
    }
}

/// The programs of pages with the same page above, and what was measured for that: the page, and its cells.
type FamilyLists = (
    Vec<(u32, Arc<[Instruction]>)>,
    Option<(u32, Arc<PageCells>)>,
);
