//! The pruned programs of pages.

use super::bake::PageContext;
use super::page::NO_PAGE;
use super::tree::Levels;
use argil_abi::Instruction;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Bytes of pages' programs that are kept.
const LIST_BYTES: u64 = 32 << 20;

impl Levels {
    /// Returns the programs of pages. Those that are kept come from there, and the others from the page above.
    pub(super) fn lists_of(
        &mut self,
        context: &PageContext<'_>,
        slots: &[u32],
    ) -> FxHashMap<u32, Arc<[Instruction]>> {
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
                    found.insert(at, list.clone());
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
        let kept: usize = self
            .lists
            .iter()
            .flatten()
            .map(|l| size_of_val(&l[..]))
            .sum();
        let mut room = LIST_BYTES.min(self.budget / 8).saturating_sub(kept as u64);
        for slot in unknown {
            let list = &found[&slot];
            let bytes = size_of_val(&list[..]) as u64;
            if bytes <= room {
                room -= bytes;
                self.lists[slot as usize] = Some(list.clone());
            }
        }
        found
    }
}
