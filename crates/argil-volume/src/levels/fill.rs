//! Fills pages that rays asked for, and evicts the least recently used.

use super::bake::PageContext;
use super::layout::LevelsLayout;
use super::page::{NO_PAGE, Page};
use super::requests::PageRequest;
use super::tree::{Levels, PAGE_BYTES};
use crate::bricks::{BakedBlock, PLACES, Pool, empty_cells_of};
use crate::{BricksError, SampleFormat, Texel, is_brick};
use argil_abi::{BRICK_MIXED, Instruction};
use argil_field::{CELLS_PER_BATCH, Program};
use glam::IVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::atomic::{AtomicU32, Ordering};
use web_time::Instant;

/// Pages that are baked at once, before time and memory are looked at.
const CHUNK: usize = 256;
/// The same, where time is short.
const SHORT_CHUNK: usize = 16;
/// Programs of this many instructions at most are kept per page, and this many in all.
const LIST_BYTES: u64 = 16 << 20;

/// What a fill did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FillStats {
    /// Pages that were baked.
    pub pages: u64,
    /// Bricks that were sampled.
    pub bricks: u64,
    /// Pages that were evicted.
    pub evicted: u64,
    /// Pages that were asked for and not baked.
    pub remaining: u64,
    /// Whether memory was the reason: all of it holds pages that the last frame used.
    pub is_full: bool,
}

impl std::ops::AddAssign for FillStats {
    fn add_assign(&mut self, other: Self) {
        self.pages += other.pages;
        self.bricks += other.bricks;
        self.evicted += other.evicted;
        self.remaining = other.remaining;
        self.is_full = other.is_full;
    }
}

/// A page to bake: where it goes, and its program.
pub(super) struct PageJob {
    pub level: u32,
    pub block: IVec3,
    pub list: Vec<Instruction>,
}

/// A baked page.
pub(super) struct BakedPage<T> {
    pub job: PageJob,
    pub made: BakedBlock<T>,
}

impl<T> BakedPage<T> {
    /// Returns the bytes that the page's bricks need.
    fn brick_bytes(&self, layout: &LevelsLayout) -> u64 {
        let each = layout.level(0).brick_bytes() + 8;
        self.made.bricks.len() as u64 * each + size_of_val(&self.made.mixed[..]) as u64
    }
}

/// Calls a function for the format of a volume's samples.
macro_rules! by_format {
    ($levels:expr, $name:ident($($argument:expr),*)) => {
        match $levels.layout.level(0).encoding.format {
            SampleFormat::Snorm8 => $levels.$name::<i8>($($argument),*),
            SampleFormat::Snorm16 => $levels.$name::<i16>($($argument),*),
        }
    };
}
pub(super) use by_format;

impl Levels {
    /// Bakes the coarsest level of a program. It is always resident, and covers everything. Finer pages come with
    /// [`Levels::fill`].
    ///
    /// # Errors
    /// If the coarsest level alone exceeds `budget` bytes.
    pub fn bake(program: &Program, layout: LevelsLayout, budget: u64) -> Result<Self, BricksError> {
        let mut levels = Self::empty(layout, program.lipschitz(), budget);
        by_format!(levels, bake_roots(program))?;
        Ok(levels)
    }

    /// Bakes the pages of the coarsest level that are missing.
    pub(super) fn bake_roots<T: Texel>(&mut self, program: &Program) -> Result<(), BricksError> {
        let context = PageContext::new(program, &self.layout);
        let level = self.layout.root();
        let missing: Vec<IVec3> = self
            .root_places()
            .filter(|&block| self.root_slot(block).is_none())
            .collect();
        let baked: Vec<BakedPage<T>> = missing
            .into_par_iter()
            .map_init(
                || context.baker(),
                |baker, block| {
                    let list = baker.root_list(block);
                    let made = baker.page(level, block, &list);
                    BakedPage {
                        job: PageJob { level, block, list },
                        made,
                    }
                },
            )
            .collect();
        let needed: u64 = baked
            .iter()
            .map(|page| page.brick_bytes(&self.layout))
            .sum();
        let needed = self.memory_bytes() + needed + PAGE_BYTES * baked.len() as u64;
        if needed > self.budget {
            return Err(BricksError::Budget {
                bricks: baked.iter().map(|page| page.made.bricks.len() as u64).sum(),
                needed,
                budget: self.budget,
            });
        }
        for page in &baked {
            let slot = self.new_page(level, page.job.block, NO_PAGE);
            let at = page.job.block - self.root_low;
            let place = at.x + self.root_size.x * (at.y + self.root_size.y * at.z);
            self.roots[place as usize] = slot;
        }
        self.commit(&baked);
        Ok(())
    }

    /// Adds a page without bricks. Its parent does not know it yet.
    fn new_page(&mut self, level: u32, block: IVec3, parent: u32) -> u32 {
        let page = Page::new(level, block, parent);
        let frame = self.frame.load(Ordering::Relaxed);
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                let slot = self.pages.len() as u32;
                self.pages.push(page);
                self.masks.push(0);
                self.open.push(0);
                self.lists.push(None);
                self.used.push(AtomicU32::new(0));
                let words = (slot as usize + 1) * CELLS_PER_BATCH;
                self.store
                    .words
                    .resize(words, crate::bricks::empty_word(0.0));
                slot
            }
        };
        self.pages[slot as usize] = page;
        self.masks[slot as usize] = 0;
        self.open[slot as usize] = 0;
        self.lists[slot as usize] = None;
        *self.used[slot as usize].get_mut() = frame;
        slot
    }

    /// Writes baked pages into their slots, over what is there.
    pub(super) fn commit<T: Texel>(&mut self, baked: &[BakedPage<T>]) {
        let layout = self.layout.level(0);
        let samples = layout.brick_samples() as usize;
        let slots: Vec<u32> = baked
            .iter()
            .map(|page| {
                let slot = self.find(page.job.level, page.job.block);
                slot.expect("a page has its slot before its contents")
            })
            .collect();
        let mut pool = Pool::<T>::open(&mut self.store, &layout);
        for (page, &slot) in baked.iter().zip(&slots) {
            let first = slot as usize * CELLS_PER_BATCH;
            for (i, &word) in page.made.words.iter().enumerate() {
                if !is_brick(word) {
                    pool.clear((first + i) as u32, word);
                }
            }
        }
        for (page, &slot) in baked.iter().zip(&slots) {
            let mut mixed = page.made.mixed.chunks_exact(PLACES);
            let texels = page.made.texels.chunks_exact(samples);
            for (&(i, material), texels) in page.made.bricks.iter().zip(texels) {
                let own_mixed = if material & BRICK_MIXED != 0 {
                    mixed.next().expect("materials of each mixed brick")
                } else {
                    &[]
                };
                let at = slot * CELLS_PER_BATCH as u32 + u32::from(i);
                pool.put(at, texels, material, own_mixed);
            }
        }
        pool.close();
        for (page, &slot) in baked.iter().zip(&slots) {
            let slot = slot as usize;
            let words = &mut self.store.words[slot * CELLS_PER_BATCH..(slot + 1) * CELLS_PER_BATCH];
            self.masks[slot] = empty_cells_of(words);
            self.open[slot] = self.masks[slot] & !page.made.flat;
        }
    }

    /// Removes pages without children, and their bricks.
    pub(super) fn remove<T: Texel>(&mut self, slots: &[u32]) {
        let layout = self.layout.level(0);
        let mut pool = Pool::<T>::open(&mut self.store, &layout);
        for &slot in slots {
            for at in slot * 64..(slot + 1) * 64 {
                pool.clear(at, crate::bricks::empty_word(0.0));
            }
        }
        pool.close();
        for &slot in slots {
            let parent = self.pages[slot as usize].parent;
            if let Some(parent) = self.pages.get_mut(parent as usize) {
                for child in &mut parent.children {
                    if *child == slot {
                        *child = NO_PAGE;
                    }
                }
            }
            self.masks[slot as usize] = 0;
            self.open[slot as usize] = 0;
            self.lists[slot as usize] = None;
            self.free.push(slot);
        }
    }

    /// Returns the bytes that bricks and pages in use need.
    fn used_bytes(&self) -> u64 {
        let free = self.free.len() as u64;
        self.memory_bytes() - PAGE_BYTES * free
    }

    /// Returns pages without children that the last frames did not use, the least recently used last.
    fn candidates(&self) -> Vec<u32> {
        let stamp = |slot: u32| self.used[slot as usize].load(Ordering::Relaxed);
        let mut all: Vec<u32> = self
            .resident()
            .filter(|&slot| {
                let page = &self.pages[slot as usize];
                page.parent != NO_PAGE && !page.has_children() && stamp(slot) < self.kept_since
            })
            .collect();
        all.sort_unstable_by_key(|&slot| std::cmp::Reverse((stamp(slot), slot)));
        all
    }

    /// Evicts pages until some more bytes fit. Returns how many, and whether they fit now.
    fn make_room<T: Texel>(&mut self, bytes: u64) -> (u64, bool) {
        let mut evicted = 0;
        loop {
            let used = self.used_bytes();
            if used + bytes <= self.budget {
                return (evicted, true);
            }
            let mut over = (used + bytes - self.budget) as i64;
            let each = self.layout.level(0).brick_bytes() + 8;
            let mut gone = Vec::new();
            for slot in self.candidates().into_iter().rev() {
                if over <= 0 {
                    break;
                }
                let bricks = u64::from(self.masks[slot as usize].count_ones());
                over -= (bricks * each + PAGE_BYTES) as i64;
                gone.push(slot);
            }
            if gone.is_empty() {
                return (evicted, false);
            }
            evicted += gone.len() as u64;
            self.remove::<T>(&gone);
        }
    }

    /// Bakes pages that frames asked for since the last call, the most urgent first, on rayon's current threads. It
    /// stops when `until` has passed or memory is full. What remains is asked for again by the next frame.
    pub fn fill(&mut self, program: &Program, until: Option<Instant>) -> FillStats {
        by_format!(self, fill_pages(program, until))
    }

    fn fill_pages<T: Texel>(&mut self, program: &Program, until: Option<Instant>) -> FillStats {
        let mut done = FillStats::default();
        let mut asked = self.requests.take();
        asked.retain(|request| self.is_open(request));
        let context = PageContext::new(program, &self.layout);
        let mut rest = &asked[..];
        let chunk = if until.is_some() { SHORT_CHUNK } else { CHUNK };
        while !rest.is_empty() {
            let (some, others) = rest.split_at(chunk.min(rest.len()));
            let (evicted, fits) = self.make_room::<T>(PAGE_BYTES * some.len() as u64);
            done.evicted += evicted;
            if !fits {
                done.is_full = true;
                break;
            }
            let baked = self.bake_children::<T>(&context, some);
            let needed: u64 = baked
                .iter()
                .map(|page| page.brick_bytes(&self.layout))
                .sum();
            let (evicted, fits) = self.make_room::<T>(needed + PAGE_BYTES * baked.len() as u64);
            done.evicted += evicted;
            // The most urgent of them may still fit.
            let mut room = self.budget.saturating_sub(self.used_bytes());
            let kept: Vec<BakedPage<T>> = baked
                .into_iter()
                .take_while(|page| {
                    let bytes = page.brick_bytes(&self.layout) + PAGE_BYTES;
                    let is_room = bytes <= room;
                    room = room.saturating_sub(bytes);
                    is_room
                })
                .collect();
            for (page, request) in kept.iter().zip(some) {
                let (parent, octant) = request.place();
                let slot = self.new_page(page.job.level, page.job.block, parent);
                self.pages[parent as usize].children[octant as usize] = slot;
            }
            self.commit(&kept);
            done.pages += kept.len() as u64;
            done.bricks += kept.iter().map(|page| page.made.sampled).sum::<u64>();
            rest = &rest[kept.len()..];
            if !fits {
                done.is_full = true;
                break;
            }
            debug_assert_eq!(rest.len(), others.len());
            if until.is_some_and(|until| Instant::now() >= until) {
                break;
            }
        }
        done.remaining = rest.len() as u64;
        self.kept_since = self.frame.load(Ordering::Relaxed) + 1;
        done
    }

    /// Whether a request names a page that is missing and can be there.
    fn is_open(&self, request: &PageRequest) -> bool {
        let (slot, octant) = request.place();
        let page = self.pages.get(slot as usize);
        page.is_some_and(|page| {
            page.level > 0
                && self.is_resident(slot)
                && page.children[octant as usize] == NO_PAGE
                && self.open_octants(slot) >> octant & 1 != 0
        })
    }

    /// Bakes octants of resident pages.
    fn bake_children<T: Texel>(
        &mut self,
        context: &PageContext<'_>,
        some: &[PageRequest],
    ) -> Vec<BakedPage<T>> {
        let mut parents: Vec<u32> = some.iter().map(|request| request.place().0).collect();
        parents.sort_unstable();
        parents.dedup();
        let lists = self.lists_of(context, &parents);
        let mut octants: FxHashMap<u32, u8> = FxHashMap::default();
        for request in some {
            let (slot, octant) = request.place();
            *octants.entry(slot).or_default() |= 1 << octant;
        }
        // Programs of the children first: those of a page are made together.
        let made: Vec<(u32, [Vec<Instruction>; 8])> = parents
            .par_iter()
            .map_init(
                || context.baker(),
                |baker, &slot| {
                    let page = &self.pages[slot as usize];
                    let list = &lists[&slot];
                    (
                        slot,
                        baker.octant_lists(page.level, page.block(), list, octants[&slot]),
                    )
                },
            )
            .collect();
        let mut made: FxHashMap<u32, [Vec<Instruction>; 8]> = made.into_iter().collect();
        let jobs: Vec<PageJob> = some
            .iter()
            .map(|request| {
                let (slot, octant) = request.place();
                let list = made
                    .get_mut(&slot)
                    .map(|all| std::mem::take(&mut all[octant as usize]));
                PageJob {
                    level: self.pages[slot as usize].level - 1,
                    block: self.child_block(slot, octant),
                    list: list.unwrap_or_default(),
                }
            })
            .collect();
        bake_all(context, jobs)
    }

    /// Returns the programs of resident pages. Those that are kept come from there, and the others from the page
    /// above.
    pub(super) fn lists_of(
        &mut self,
        context: &PageContext<'_>,
        slots: &[u32],
    ) -> FxHashMap<u32, Vec<Instruction>> {
        // All pages on the way to the first known program, coarsest first.
        let mut found: FxHashMap<u32, Vec<Instruction>> = FxHashMap::default();
        let mut unknown: Vec<u32> = Vec::new();
        for &slot in slots {
            let mut at = slot;
            while at != NO_PAGE && !found.contains_key(&at) {
                if let Some(list) = &self.lists[at as usize] {
                    found.insert(at, list.to_vec());
                    break;
                }
                unknown.push(at);
                at = self.pages[at as usize].parent;
            }
        }
        unknown.sort_unstable_by_key(|&slot| {
            (std::cmp::Reverse(self.pages[slot as usize].level), slot)
        });
        unknown.dedup();
        let pages = &self.pages;
        for same in unknown.chunk_by(|&a, &b| pages[a as usize].level == pages[b as usize].level) {
            let own: Vec<(u32, Vec<Instruction>)> = same
                .par_iter()
                .map_init(
                    || context.baker(),
                    |baker, &slot| {
                        let page = &pages[slot as usize];
                        let Some(above) = found.get(&page.parent) else {
                            return (slot, baker.root_list(page.block()));
                        };
                        let block = page.block();
                        let inner = block & 1;
                        let octant = (inner.x + 2 * inner.y + 4 * inner.z) as usize;
                        let mut lists =
                            baker.octant_lists(page.level + 1, block >> 1, above, 1 << octant);
                        (slot, std::mem::take(&mut lists[octant]))
                    },
                )
                .collect();
            found.extend(own);
        }
        let kept: usize = self
            .lists
            .iter()
            .flatten()
            .map(|l| size_of_val(&l[..]))
            .sum();
        let mut room = LIST_BYTES.min(self.budget / 16).saturating_sub(kept as u64);
        for slot in unknown {
            let bytes = size_of_val(&found[&slot][..]) as u64;
            if bytes <= room {
                room -= bytes;
                self.lists[slot as usize] = Some(found[&slot].as_slice().into());
            }
        }
        found
    }
}

/// Bakes pages in parallel.
pub(super) fn bake_all<T: Texel>(
    context: &PageContext<'_>,
    jobs: Vec<PageJob>,
) -> Vec<BakedPage<T>> {
    jobs.into_par_iter()
        .map_init(
            || context.baker(),
            |baker, job| {
                let made = baker.page(job.level, job.block, &job.list);
                BakedPage { job, made }
            },
        )
        .collect()
}
