//! The pruned programs of pages.

use super::bake::PageContext;
use super::kept_list::{KeptList, KeptMarks, PageCells, PageList};
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
                    let kept = marks[above as usize].as_ref();
                    let kept = kept.map(|kept| &*kept.cells);
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
        let bytes = |list: &Arc<[Instruction]>| size_of_val(&list[..]) as u64;
        let needed = lists.iter().flatten().map(|(_, list)| bytes(list)).sum();
        let mut room = self.drop_lists(needed);
        for (slot, instructions) in lists.into_iter().flatten() {
            if bytes(&instructions) <= room {
                room -= bytes(&instructions);
                self.lists[slot as usize] = Some(KeptList {
                    instructions: instructions.clone(),
                    used: self.list_clock,
                });
            }
            found.insert(slot, PageList::Pruned(instructions));
        }
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
                if let Some(list) = &self.lists[at as usize] {
                    found.insert(at, PageList::Pruned(list.instructions.clone()));
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

    /// Returns what is known of the programs of a page's cells.
    pub(super) fn marks_of(&self, slot: u32) -> Option<Arc<PageCells>> {
        let kept = self.marks[slot as usize].as_ref();
        kept.map(|kept| kept.cells.clone())
    }

    /// Keeps what was found of the programs of pages' cells, as far as there is room.
    pub(super) fn keep_marks(&mut self, made: Vec<(u32, Arc<PageCells>)>) {
        let used = self.list_clock;
        let mut room = self.drop_marks(made.iter().map(|(_, cells)| cells.bytes()).sum());
        for (slot, cells) in made {
            if cells.bytes() <= room {
                room -= cells.bytes();
                self.marks[slot as usize] = Some(KeptMarks { cells, used });
            }
        }
    }

    /// Forgets what is kept of a page.
    pub(super) fn forget_lists(&mut self, slot: u32) {
        self.lists[slot as usize] = None;
        self.marks[slot as usize] = None;
    }

    /// Returns the bytes of what is kept of all pages.
    pub(super) fn list_bytes(&self) -> u64 {
        let lists = self.lists.iter().flatten();
        let lists = lists.map(|list| size_of_val(&list.instructions[..]) as u64);
        let marks = self.marks.iter().flatten().map(|kept| kept.cells.bytes());
        lists.sum::<u64>() + marks.sum::<u64>()
    }

    /// Drops programs, and what is known of them, if all together exceed the budget.
    pub(super) fn trim_lists(&mut self) {
        let over = self.used_bytes().saturating_sub(self.budget);
        if over == 0 {
            return;
        }
        let bytes = |slot: usize| {
            let list = self.lists[slot].as_ref();
            let list = list.map_or(0, |list| size_of_val(&list.instructions[..]) as u64);
            let marks = self.marks[slot].as_ref();
            list + marks.map_or(0, |kept| kept.cells.bytes())
        };
        let used = |slot: usize| {
            let list = self.lists[slot].as_ref().map(|list| list.used);
            list.max(self.marks[slot].as_ref().map(|kept| kept.used))
        };
        let mut kept: Vec<(u32, usize)> = (0..self.lists.len())
            .filter_map(|slot| Some((used(slot)?, slot)))
            .collect();
        kept.sort_unstable();
        let mut freed = 0;
        let gone = kept.iter().take_while(|own| {
            let is_short = freed < over;
            freed += bytes(own.1);
            is_short
        });
        let gone: Vec<u32> = gone.map(|own| own.1 as u32).collect();
        for slot in gone {
            self.forget_lists(slot);
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
            let (list, marks) = (
                &mut self.lists[slot as usize],
                &mut self.marks[slot as usize],
            );
            let stamps = list.as_mut().map(|list| &mut list.used);
            let stamps = stamps
                .into_iter()
                .chain(marks.as_mut().map(|kept| &mut kept.used));
            let mut is_touched = false;
            for stamp in stamps {
                is_touched |= *stamp == now;
                *stamp = now;
            }
            if is_touched {
                return;
            }
            match self.pages[slot as usize].parent {
                NO_PAGE => return,
                parent => slot = parent / 8,
            }
        }
    }

    /// Drops programs that were not used for the longest time, until some more bytes fit. Returns how many do.
    fn drop_lists(&mut self, needed: u64) -> u64 {
        let limit = self.list_limit();
        let kept = (0u32..).zip(&self.lists).filter_map(|(slot, list)| {
            let list = list.as_ref()?;
            Some((list.used, slot, size_of_val(&list.instructions[..]) as u64))
        });
        let (gone, room) = self.oldest(kept, limit, needed);
        for slot in gone {
            self.lists[slot as usize] = None;
        }
        room
    }

    /// Drops what is known of cells and was not used for the longest time, until some more bytes fit. Returns how many
    /// do.
    fn drop_marks(&mut self, needed: u64) -> u64 {
        let limit = self.mark_limit();
        let kept = (0u32..).zip(&self.marks).filter_map(|(slot, kept)| {
            let kept = kept.as_ref()?;
            Some((kept.used, slot, kept.cells.bytes()))
        });
        let (gone, room) = self.oldest(kept, limit, needed);
        for slot in gone {
            self.marks[slot as usize] = None;
        }
        room
    }

    /// Returns which of the kept must go, so that some more bytes fit within a limit, and how many bytes fit then. Each
    /// is when it was used last, its slot, and its bytes.
    fn oldest(
        &self,
        kept: impl Iterator<Item = (u32, u32, u64)>,
        limit: u64,
        needed: u64,
    ) -> (Vec<u32>, u64) {
        let mut kept: Vec<(u32, u32, u64)> = kept.collect();
        let mut room = limit.saturating_sub(kept.iter().map(|own| own.2).sum());
        kept.retain(|own| own.0 < self.list_clock);
        kept.sort_unstable();
        let gone = kept.iter().take_while(|own| {
            let is_short = room < needed.min(limit);
            room += if is_short { own.2 } else { 0 };
            is_short
        });
        let gone = gone.map(|own| own.1).collect();
        (gone, room)
    }
}

/// The programs of pages with the same page above, and what was measured for that: the page, and its cells.
type FamilyLists = (
    Vec<(u32, Arc<[Instruction]>)>,
    Option<(u32, Arc<PageCells>)>,
);
