//! The pruned programs of pages.

use super::bake::PageContext;
use super::kept_list::KeptList;
use super::page::NO_PAGE;
use super::tree::Levels;
use argil_abi::Instruction;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Bytes of pages' programs that are kept.
const LIST_BYTES: u64 = 32 << 20;

impl Levels {
    /// Returns the programs of pages. Those that are kept come from there, and the others from the page above.
    pub(super) fn lists_of(
        &mut self,
        context: &PageContext<'_>,
        slots: &[u32],
    ) -> FxHashMap<u32, Arc<[Instruction]>> {
        let frame = self.frame.load(Ordering::Relaxed);
        // All pages on the way to the first known program, coarsest first.
        let mut found: FxHashMap<u32, Arc<[Instruction]>> = FxHashMap::default();
        let mut unknown: Vec<u32> = Vec::new();
        for &slot in slots {
            let mut at = slot;
            loop {
                if found.contains_key(&at) {
                    break;
                }
                if let Some(list) = &self.lists[at as usize] {
                    found.insert(at, list.instructions.clone());
                    self.touch_lists(at, frame);
                    break;
                }
                unknown.push(at);
                match self.pages[at as usize].parent {
                    NO_PAGE => break,
                    parent => at = parent / 8,
                }
            }
        }
        let order = |slot: u32| {
            let page = &self.pages[slot as usize];
            (std::cmp::Reverse(page.level), page.parent, slot)
        };
        unknown.sort_unstable_by_key(|&slot| order(slot));
        unknown.dedup();
        let pages = &self.pages;
        for same in unknown.chunk_by(|&a, &b| pages[a as usize].level == pages[b as usize].level) {
            let page_above = |slot: u32| pages[slot as usize].parent / 8;
            let families: Vec<&[u32]> = same
                .chunk_by(|&a, &b| page_above(a) == page_above(b))
                .collect();
            let own: Vec<Vec<(u32, Arc<[Instruction]>)>> = families
                .par_iter()
                .map_init(
                    || context.baker(),
                    |baker, family| {
                        let first = &pages[family[0] as usize];
                        if first.parent == NO_PAGE {
                            let list = |&slot: &u32| {
                                let place = pages[slot as usize].place();
                                (slot, baker.root_list(place))
                            };
                            return family.iter().map(list).collect();
                        }
                        let above = first.parent / 8;
                        let cell_of = |slot: &u32| pages[*slot as usize].parent % 8;
                        let cells = family.iter().map(cell_of);
                        let cells = cells.fold(0, |all, cell| all | 1u8 << cell);
                        let page = &pages[above as usize];
                        let mut lists = baker.cell_lists(page, &found[&above], cells);
                        let own = family.iter().map(|&slot| {
                            let cell = pages[slot as usize].parent % 8;
                            (slot, std::mem::take(&mut lists[cell as usize]))
                        });
                        own.collect()
                    },
                )
                .collect();
            found.extend(own.into_iter().flatten());
        }
        let bytes = |list: &Arc<[Instruction]>| size_of_val(&list[..]) as u64;
        let limit = LIST_BYTES.min(self.budget / 8);
        let needed: u64 = unknown.iter().map(|slot| bytes(&found[slot])).sum();
        let mut room = self.drop_lists(limit, needed);
        for slot in unknown {
            let instructions = found[&slot].clone();
            if bytes(&instructions) <= room {
                room -= bytes(&instructions);
                self.lists[slot as usize] = Some(KeptList {
                    instructions,
                    frame,
                });
            }
        }
        found
    }

    /// Marks the programs of a page and of those above it as used: they are the shortest way to others near them.
    fn touch_lists(&mut self, mut slot: u32, frame: u32) {
        loop {
            if let Some(list) = &mut self.lists[slot as usize] {
                if list.frame == frame {
                    return;
                }
                list.frame = frame;
            }
            match self.pages[slot as usize].parent {
                NO_PAGE => return,
                parent => slot = parent / 8,
            }
        }
    }

    /// Drops programs that were not used for the longest time, until some more bytes fit. Returns how many do.
    fn drop_lists(&mut self, limit: u64, needed: u64) -> u64 {
        let frame = self.frame.load(Ordering::Relaxed);
        let mut kept: Vec<(u32, u32, u64)> = (0u32..)
            .zip(&self.lists)
            .filter_map(|(slot, list)| {
                let list = list.as_ref()?;
                Some((list.frame, slot, size_of_val(&list.instructions[..]) as u64))
            })
            .collect();
        let mut room = limit.saturating_sub(kept.iter().map(|own| own.2).sum());
        kept.retain(|own| own.0 < frame);
        kept.sort_unstable();
        for (_, slot, bytes) in kept {
            if room >= needed.min(limit) {
                break;
            }
            self.lists[slot as usize] = None;
            room += bytes;
        }
        room
    }
}
