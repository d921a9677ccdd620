//! Bakes what rays asked for, and evicts what no ray used for the longest time.

use super::bake::{BakedPage, PageContext, PageJob};
use super::layout::LevelsLayout;
use super::page::{FLAT_CELL, NO_PAGE, Page, UNKNOWN_CELL, is_page, octant_place};
use super::requests::PageRequest;
use super::tree::{Levels, PAGE_BYTES};
use crate::MISSING_BRICK;
use crate::bricks::{PLACES, Pool};
use crate::{BricksError, SampleFormat, Texel, is_brick};
use argil_abi::BRICK_MIXED;
use argil_field::Program;
use argil_math::morton;
use glam::{IVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::atomic::{AtomicU32, Ordering};
use web_time::Instant;

/// Bricks that are baked at once, before time and memory are looked at.
const CHUNK: usize = 4096;
/// The same, where time is short.
const SHORT_CHUNK: usize = 128;
/// Bytes of programs that are in memory at once, about.
const BATCH_LIST_BYTES: u64 = 32 << 20;
/// Chunks in whose requests neighbors come one after another, because they share programs.
const SORTED_CHUNKS: usize = 8;

/// What a fill did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FillStats {
    /// Requests that were answered, with those for finer bricks that follow from them. A cell can turn out to have no
    /// surface, and then gets no brick.
    pub answered: u64,
    /// Bricks that were sampled.
    pub bricks: u64,
    /// Bricks that were evicted.
    pub evicted: u64,
    /// Requests that were not answered.
    pub remaining: u64,
    /// Requests whose tiles are on their way from a store.
    pub pending: u64,
    /// Requests whose tiles the store lacks, or has damaged. Rays see what is coarser there.
    pub missing: u64,
    /// Whether memory was the reason: the last frame used all of it.
    pub is_full: bool,
}

impl std::ops::AddAssign for FillStats {
    fn add_assign(&mut self, other: Self) {
        self.answered += other.answered;
        self.bricks += other.bricks;
        self.evicted += other.evicted;
        self.remaining = other.remaining;
        self.pending = other.pending;
        self.missing = other.missing;
        self.is_full = other.is_full;
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

impl<T> BakedPage<T> {
    /// Returns the bytes that the page's bricks need.
    fn brick_bytes(&self, layout: &LevelsLayout) -> u64 {
        let each = layout.level(0).brick_bytes() + 8;
        self.bricks() * each + size_of_val(&self.mixed[..]) as u64
    }
}

impl Levels {
    /// Bakes the coarsest level of a program. It is always resident, and covers everything. Finer bricks come with
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
            .filter(|&place| self.root_slot(place).is_none())
            .collect();
        let baked: Vec<BakedPage<T>> = missing
            .par_iter()
            .map_init(
                || context.baker(),
                |baker, &place| {
                    let job = PageJob {
                        page: Page::new(level, place, NO_PAGE),
                        list: context.whole(),
                        cells: u8::MAX,
                        kept: None,
                    };
                    baker.page(&job)
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
                bricks: baked.iter().map(BakedPage::bricks).sum(),
                needed,
                budget: self.budget,
            });
        }
        let slots: Vec<u32> = missing
            .iter()
            .map(|&place| {
                let slot = self.new_page(Page::new(level, place, NO_PAGE));
                let at = place - self.root_low;
                let index = at.x + self.root_size.x * (at.y + self.root_size.y * at.z);
                self.roots[index as usize] = slot;
                slot
            })
            .collect();
        self.commit(&slots, &baked, |_| u8::MAX);
        Ok(())
    }

    /// Adds a page whose cells are unknown. Its parent does not know it yet.
    fn new_page(&mut self, page: Page) -> u32 {
        let frame = self.frame.load(Ordering::Relaxed);
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                self.pages.push(page);
                self.lists.push();
                self.marks.push();
                let cells = 8 * self.pages.len();
                self.children.resize(cells, UNKNOWN_CELL);
                self.store
                    .words
                    .resize(cells, crate::bricks::empty_word(0.0));
                self.used.resize_with(cells, AtomicU32::default);
                self.pages.len() as u32 - 1
            }
        };
        self.pages[slot as usize] = page;
        self.forget_lists(slot);
        let cells = 8 * slot as usize..8 * slot as usize + 8;
        self.children[cells.clone()].fill(UNKNOWN_CELL);
        self.store.words[cells.clone()].fill(crate::bricks::empty_word(0.0));
        self.used[cells]
            .iter_mut()
            .for_each(|used| *used.get_mut() = frame);
        slot
    }

    /// Writes baked pages into their slots: the sampled cells, and the words of others that `renewed` selects for each
    /// page, one bit each.
    pub(super) fn commit<T: Texel>(
        &mut self,
        slots: &[u32],
        baked: &[BakedPage<T>],
        renewed: impl Fn(usize) -> u8,
    ) {
        let layout = self.layout.level(0);
        let samples = layout.brick_samples() as usize;
        let mut pool = Pool::<T>::open(&mut self.store, &layout);
        for (index, (page, &slot)) in baked.iter().zip(slots).enumerate() {
            let renewed = renewed(index);
            for (i, &word) in (0..).zip(&page.words) {
                let is_sampled = page.cells.iter().any(|own| own.cell == i);
                if !is_sampled && renewed >> i & 1 != 0 {
                    pool.clear(8 * slot + i, word);
                }
            }
            for own in page.cells.iter().filter(|own| own.brick.is_none()) {
                pool.clear(8 * slot + own.cell, page.clear[own.cell as usize]);
            }
        }
        for (page, &slot) in baked.iter().zip(slots) {
            let mut mixed = page.mixed.chunks_exact(PLACES);
            let mut texels = page.texels.chunks_exact(samples);
            for own in &page.cells {
                let Some((material, _)) = own.brick else {
                    continue;
                };
                let own_mixed = if material & BRICK_MIXED != 0 {
                    mixed.next().expect("materials of each mixed brick")
                } else {
                    &[]
                };
                let texels = texels.next().expect("samples of each brick");
                pool.put(8 * slot + own.cell, texels, material, own_mixed);
            }
        }
        pool.close();
        for (page, &slot) in baked.iter().zip(slots) {
            for own in &page.cells {
                let child = &mut self.children[(8 * slot + own.cell) as usize];
                *child = match own.brick {
                    None => UNKNOWN_CELL,
                    Some((_, true)) => FLAT_CELL,
                    Some(_) if is_page(*child) => *child,
                    Some(_) => NO_PAGE,
                };
            }
        }
    }

    /// Bakes what frames asked for since the last call, the most urgent first, on rayon's current threads. Then it bakes
    /// what is finer at the same points. It stops when `until` has passed or memory is full. The next frame asks again
    /// for what remains.
    pub fn fill(&mut self, program: &Program, until: Option<Instant>) -> FillStats {
        by_format!(self, fill_pages(program, until))
    }

    fn fill_pages<T: Texel>(&mut self, program: &Program, until: Option<Instant>) -> FillStats {
        let mut done = FillStats::default();
        let mut asked = self.requests.take();
        let context = PageContext::new(program, &self.layout);
        let chunk = if until.is_some() { SHORT_CHUNK } else { CHUNK };
        let mixed = if program.materials().len() > 1 {
            size_of::<[[u32; 2]; PLACES]>()
        } else {
            0
        };
        let each = self.layout.level(0).brick_bytes() + 8 + PAGE_BYTES + mixed as u64;
        let mut list_bytes = size_of_val(program.instructions()) as u64;
        let mut must_end = false;
        // Then what is finer, level after level.
        for _ in 0..self.layout.count() {
            if asked.is_empty() || must_end {
                break;
            }
            for some in asked.chunks_mut(SORTED_CHUNKS * chunk) {
                some.sort_by_cached_key(|request| self.place_code(request));
            }
            let mut rest = &asked[..];
            let mut finer = Vec::new();
            while !rest.is_empty() && !must_end {
                let chunk = chunk.min((BATCH_LIST_BYTES / list_bytes.max(1)) as usize + 1);
                let (evicted, fits) = self.make_room::<T>(each * chunk.min(rest.len()) as u64);
                done.evicted += evicted;
                let room = self.budget.saturating_sub(self.used_bytes()) / each;
                let count = chunk.min(rest.len()).min(room as usize);
                let (some, others) = rest.split_at(count);
                let some = &self.available(program, some, &mut done)[..];
                done.bricks += self.bake_requests::<T>(&context, some);
                list_bytes = self.mean_list_bytes;
                done.answered += some.len() as u64;
                finer.extend(
                    some.iter()
                        .filter_map(|request| self.finer_request(request)),
                );
                rest = others;
                done.is_full |= !fits;
                must_end = !fits || until.is_some_and(|until| Instant::now() >= until);
            }
            let remains = if must_end { finer.len() } else { 0 };
            done.remaining = (rest.len() + remains) as u64;
            finer.sort_unstable_by_key(|request| request.key);
            finer.dedup_by_key(|request| request.key);
            PageRequest::sort(&mut finer);
            asked = finer;
        }
        self.trim_lists();
        self.adapt(done.is_full);
        self.kept_since = self.frame.load(Ordering::Relaxed) + 1;
        done
    }

    /// Returns the request for the next finer cell at the point that a request came from, after it was answered.
    fn finer_request(&self, answered: &PageRequest) -> Option<PageRequest> {
        let aim = answered.aim?;
        let place = IVec3::from_array(aim.voxel) >> (3 + aim.level);
        let found = self.find(aim.level, place)?;
        let next = self.request_for((aim.level, place), found, answered.distance)?;
        // It must not be evicted before a frame uses it.
        self.mark_used(next.place().0, self.frame.load(Ordering::Relaxed));
        (next.key != answered.key).then_some(PageRequest {
            aim: answered.aim,
            ..next
        })
    }

    /// Returns the position of a request's page along the Morton curve.
    fn place_code(&self, request: &PageRequest) -> [u32; 3] {
        let origin = self.pages[request.place().0 as usize / 8].origin;
        let place = UVec3::from_array(origin.map(|c| (c as u32) ^ 1 << 31));
        // Ten bits at a time.
        [22, 12, 2].map(|bit| morton(place >> bit))
    }

    /// Bakes requests. Returns the number of bricks.
    fn bake_requests<T: Texel>(&mut self, context: &PageContext<'_>, some: &[PageRequest]) -> u64 {
        // The cells to sample of each page. New pages come first.
        let mut known: FxHashMap<u32, u8> = FxHashMap::default();
        let mut new: FxHashMap<u32, u8> = FxHashMap::default();
        for request in some {
            let (cell, child) = request.place();
            if !self.is_resident(cell / 8) {
                continue;
            }
            let word = self.store.words[cell as usize];
            match child {
                None if word == MISSING_BRICK => {
                    *known.entry(cell / 8).or_default() |= 1 << (cell % 8);
                }
                Some(child)
                    if is_brick(word)
                        && self.children[cell as usize] == NO_PAGE
                        && self.level_of(cell) > 0 =>
                {
                    *new.entry(cell).or_default() |= 1 << child;
                }
                _ => {}
            }
        }
        let mut slots = Vec::with_capacity(known.len() + new.len());
        let mut cells = Vec::with_capacity(slots.capacity());
        let mut created: Vec<(u32, u8)> = new.into_iter().collect();
        created.sort_unstable();
        for (cell, own) in created {
            let page = &self.pages[cell as usize / 8];
            let place = 2 * (2 * page.place() + octant_place(cell % 8));
            let slot = self.new_page(Page::new(page.level - 1, place >> 1, cell));
            self.children[cell as usize] = slot;
            slots.push(slot);
            cells.push(own);
        }
        let count = slots.len();
        let mut others: Vec<(u32, u8)> = known.into_iter().collect();
        others.sort_unstable();
        slots.extend(others.iter().map(|(slot, _)| slot));
        cells.extend(others.iter().map(|(_, cells)| cells));
        let baked = self.stored_or_baked_pages::<T>(context, &slots, &cells);
        self.commit(&slots[..count], &baked[..count], |_| u8::MAX);
        self.commit(&slots[count..], &baked[count..], |_| 0);
        baked.iter().map(BakedPage::bricks).sum()
    }

    /// Measures pages, and samples some of their cells.
    pub(super) fn bake_pages<T: Texel>(
        &mut self,
        context: &PageContext<'_>,
        slots: &[u32],
        cells: &[u8],
    ) -> Vec<BakedPage<T>> {
        let lists = self.lists_of(context, slots);
        let jobs: Vec<PageJob<'_>> = slots
            .iter()
            .zip(cells)
            .map(|(slot, &cells)| PageJob {
                page: self.pages[*slot as usize],
                list: lists[slot].clone(),
                cells,
                kept: self.marks.get(*slot).cloned(),
            })
            .collect();
        let baked: Vec<BakedPage<T>> = jobs
            .into_par_iter()
            .map_init(|| context.baker(), |baker, job| baker.page(&job))
            .collect();
        let made = slots.iter().zip(&baked);
        let made = made.filter_map(|(&slot, page)| Some((slot, page.marks.clone()?)));
        self.keep_marks(made.collect());
        baked
    }
}
