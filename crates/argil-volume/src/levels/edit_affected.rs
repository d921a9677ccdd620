//! Finds and bakes the cells in which an edit can have changed a distance.
//!
//! *Theory.* The program of a page before the edit and the one after differ in the edited instructions only. Where a
//! pruner drops these in both, the distances in a cell are the same, to the bit, and so they are in all finer cells
//! within it: the search ends there.

use super::bake::{BakedPage, PageContext, PageJob};
use super::kept_list::{PageCells, PageList};
use super::page::{NO_PAGE, Page, is_page};
use super::tree::Levels;
use crate::{EditStats, Texel};
use argil_abi::Instruction;
use argil_field::{ChangeSet, Pruner};
use rayon::prelude::*;
use std::sync::Arc;

/// Fewer pages than this are not worth another thread.
const MIN_PAGES: usize = 4;

/// Cells with their programs, after an edit and before it.
type CellLists<'a> = Vec<(u32, [PageList<'a>; 2])>;

/// A page that an edit may have changed, with its program before and after.
struct EditedPage<'a> {
    slot: u32,
    now: PageList<'a>,
    then: PageList<'a>,
}

/// The cells of a page in which an edit can matter, one bit each, and what is known of their programs.
#[derive(Default)]
struct AffectedCells<'a> {
    cells: u8,
    /// The programs of those that have pages below.
    lists: CellLists<'a>,
    kept: Option<Arc<PageCells>>,
}

impl Levels {
    /// Bakes again the cells in which a touched instruction can matter, in the program after an edit or before it.
    pub(super) fn edit_affected<T: Texel>(
        &mut self,
        context: &PageContext<'_>,
        touched: &ChangeSet,
        [now, then]: [&[Instruction]; 2],
        done: &mut EditStats,
    ) {
        let (now, then) = (PageList::Whole(now), PageList::Whole(then));
        let roots = self.roots.iter().filter(|&&slot| slot != NO_PAGE);
        let mut open: Vec<EditedPage<'_>> = roots
            .map(|&slot| EditedPage {
                slot,
                now: now.clone(),
                then: then.clone(),
            })
            .collect();
        // All pages, coarser levels first, before any is baked: then all threads have work.
        let mut pruners = [context.pruner(), context.pruner()];
        let mut edited: Vec<(u8, PageJob<'_>)> = Vec::new();
        let mut slots = Vec::new();
        while !open.is_empty() {
            let mut next = Vec::new();
            for page in open {
                let AffectedCells { cells, lists, kept } =
                    self.affected(context, &page, touched, &mut pruners);
                if cells == 0 {
                    continue;
                }
                next.extend(lists.into_iter().map(|(cell, [now, then])| EditedPage {
                    slot: self.children[cell as usize],
                    now,
                    then,
                }));
                let job = PageJob {
                    page: self.pages[page.slot as usize],
                    list: page.now,
                    cells: cells & self.known_cells(page.slot),
                    kept,
                };
                slots.push(page.slot);
                edited.push((cells, job));
            }
            open = next;
        }
        let baked: Vec<BakedPage<T>> = edited
            .par_iter()
            .with_min_len(MIN_PAGES)
            .map_init(|| context.baker(), |baker, (_, job)| baker.page(job))
            .collect();
        let all: Vec<(u32, u8, BakedPage<T>)> = slots
            .into_iter()
            .zip(baked)
            .zip(&edited)
            .map(|((slot, page), (cells, _))| (slot, *cells, page))
            .collect();
        let mut rest = all.into_iter().peekable();
        while let Some(&(first, ..)) = rest.peek() {
            let level = self.pages[first as usize].level;
            let (mut slots, mut renewed, mut baked) = (Vec::new(), Vec::new(), Vec::new());
            while let Some((slot, cells, page)) =
                rest.next_if(|own| self.pages[own.0 as usize].level == level)
            {
                // What has no cell above any more is gone.
                if self.is_resident(slot) {
                    slots.push(slot);
                    renewed.push(cells);
                    baked.push(page);
                }
            }
            self.replace_cells(&slots, &baked, &renewed, done);
        }
    }

    /// Returns the cells of a page in which a touched instruction can matter.
    fn affected<'a>(
        &self,
        context: &PageContext<'_>,
        page: &EditedPage<'a>,
        touched: &ChangeSet,
        pruners: &mut [Pruner<'_>; 2],
    ) -> AffectedCells<'a> {
        let own: &Page = &self.pages[page.slot as usize];
        let is_one = |instr: &Instruction| touched.contains(instr);
        let [of_now, of_then] = pruners;
        let has_then = touched.intersects(&page.then);
        if !has_then && !touched.intersects(&page.now) {
            return AffectedCells::default();
        }
        let distances = context.classify(own, &page.now, of_now);
        let mut cells = of_now.affected_cells(&page.now, is_one) as u8;
        if has_then {
            context.classify(own, &page.then, of_then);
            cells |= of_then.affected_cells(&page.then, is_one) as u8;
        }
        let cut = |list: &PageList<'a>, pruner: &mut Pruner<'_>, i: usize| {
            let mut own = Vec::new();
            pruner.prune_into(list, i, &mut own);
            // An instruction that matters can be missing, because another one covers it.
            let count = pruner.affected_count(list, i, is_one);
            if touched.count_in(&own) >= count {
                PageList::Pruned(own.into())
            } else {
                list.clone()
            }
        };
        let below = (0..8u32).filter(|i| {
            let child = self.children[(8 * page.slot + i) as usize];
            cells >> i & 1 != 0 && is_page(child)
        });
        let programs = below.map(|i| {
            let now = cut(&page.now, of_now, i as usize);
            let then = if has_then {
                cut(&page.then, of_then, i as usize)
            } else {
                PageList::Whole(&[])
            };
            (8 * page.slot + i, [now, then])
        });
        AffectedCells {
            cells,
            lists: programs.collect(),
            kept: (cells != 0).then(|| {
                Arc::new(PageCells {
                    distances,
                    marks: of_now.cell_marks(),
                })
            }),
        }
    }
}
