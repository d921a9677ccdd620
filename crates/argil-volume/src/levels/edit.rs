//! Follows edits: what is resident where they reach is baked again, on all levels.

use super::bake::{BakedPage, PageContext};
use super::fill::by_format;
use super::layout::LevelsLayout;
use super::page::{NO_PAGE, UNKNOWN_CELL, is_page};
use super::pending::LevelsPendingEdits;
use super::tree::Levels;
use crate::{BricksError, EditStats, PendingEdits, SampleFormat, Texel};
use argil_field::IncrementalProgram;
use argil_math::Aabb;
use glam::IVec3;
use web_time::Instant;

impl Levels {
    /// Grows to another box of the same voxels. Samples nothing.
    pub(super) fn grow_to(&mut self, layout: LevelsLayout) {
        let [low, high] = layout.root_pages();
        let old = (self.root_low, self.root_size);
        let (low, high) = (low.min(old.0), high.max(old.0 + old.1));
        let size = high - low;
        let mut roots = vec![NO_PAGE; size.element_product() as usize];
        for place in self.root_places() {
            if let Some(slot) = self.root_slot(place) {
                let at = place - low;
                roots[(at.x + size.x * (at.y + size.y * at.z)) as usize] = slot;
            }
        }
        (self.root_low, self.root_size, self.roots) = (low, size, roots);
        self.layout = layout;
    }

    /// Shrinks the coarsest level to the pages that it has, after a growth that failed.
    fn drop_missing_roots(&mut self) {
        let places: Vec<IVec3> = self
            .root_places()
            .filter(|&place| self.root_slot(place).is_some())
            .collect();
        let low = places.iter().copied().reduce(IVec3::min);
        let high = places.iter().copied().reduce(IVec3::max);
        let (Some(low), Some(high)) = (low, high) else {
            return;
        };
        let slots = crate::bricks::places(low, high).map(|place| self.root_slot(place));
        let roots: Vec<u32> = slots.map(|slot| slot.unwrap_or(NO_PAGE)).collect();
        (self.root_low, self.root_size, self.roots) = (low, high - low + 1, roots);
    }

    /// Bakes again what is resident and an edit can have changed. What is not resident needs nothing: it is baked from
    /// the edited program when a ray asks for it. Coarse levels come first. It stops when `until` has passed, after a few pages at
    /// least; a later call goes on.
    ///
    /// # Errors
    /// If the coarsest level alone exceeds the budget.
    pub fn edit(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut LevelsPendingEdits,
        until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        // Parameters can move although no distance changes.
        if self.revision != live.revision() {
            self.revision = live.revision();
            self.lists.forget_all();
            self.marks.forget_all();
        }
        if edits.is_done() {
            return Ok(EditStats::default());
        }
        by_format!(self, edit_pages(live, edits, until))
    }

    fn edit_pages<T: Texel>(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut LevelsPendingEdits,
        until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        let program = live.to_program();
        if let Some(stored) = &mut self.stored {
            for level in 0..self.layout.count() {
                stored.note_edits(level, edits.boxes(level));
            }
        }
        // Requests name cells, whose pages may be freed now.
        self.requests.take();
        if let Err(error) = self.bake_roots::<T>(&program) {
            self.drop_missing_roots();
            return Err(error);
        }
        // What remains may be as steep as before.
        self.lipschitz = self.lipschitz.max(program.lipschitz());
        let before = self.brick_count();
        let context = PageContext::new(&program, &self.layout);
        let mut done = EditStats::default();
        let pages = until.map(|_| self.touched_pages(edits));
        let is_short = pages.is_none_or(|pages| pages <= edits.pages_within(until));
        let known = edits.has_known_changes() && is_short;
        match live.changes().filter(|_| known) {
            Some(touched) => {
                let mut previous = Vec::new();
                live.previous_instructions(&mut previous);
                let lists = [program.instructions(), &previous];
                let start = Instant::now();
                self.edit_affected::<T>(&context, touched, lists, &mut done);
                if let Some(pages) = pages {
                    edits.note_duration(start.elapsed(), pages);
                }
                edits.clear();
            }
            None => self.edit_boxes::<T>(&context, edits, until, &mut done),
        }
        if edits.is_done() {
            self.lipschitz = program.lipschitz();
        }
        // What edits added may be more than there is room for.
        self.make_room::<T>(0);
        let after = self.brick_count();
        done.added = after.saturating_sub(before);
        done.removed = before.saturating_sub(after);
        Ok(done)
    }

    /// Returns the number of pages that boxes reach.
    fn touched_pages(&self, edits: &LevelsPendingEdits) -> usize {
        let levels = 0..self.layout.count();
        let pages = levels.map(|level| self.touched(level, edits.boxes(level)).len());
        pages.sum()
    }

    /// Bakes again all resident pages that boxes reach, level by level, until a point in time.
    fn edit_boxes<T: Texel>(
        &mut self,
        context: &PageContext<'_>,
        edits: &mut LevelsPendingEdits,
        until: Option<Instant>,
        done: &mut EditStats,
    ) {
        let threads = rayon::current_num_threads();
        let mut has_baked = false;
        for level in (0..self.layout.count()).rev() {
            let mut slots = self.touched(level, edits.boxes(level));
            slots.retain(|&slot| !edits.has_baked(&self.pages[slot as usize]));
            let mut left = &slots[..];
            while !left.is_empty() {
                let fit = edits.pages_within(until);
                if has_baked && fit == 0 {
                    return;
                }
                has_baked = true;
                let start = Instant::now();
                let (slots, later) = left.split_at(left.len().min(fit.max(threads)));
                edits.note_baked(slots.iter().map(|&slot| self.pages[slot as usize]));
                let cells: Vec<u8> = slots.iter().map(|&slot| self.known_cells(slot)).collect();
                let baked = self.bake_pages::<T>(context, slots, &cells);
                self.replace_cells(slots, &baked, &vec![u8::MAX; slots.len()], done);
                edits.note_duration(start.elapsed(), slots.len());
                left = later;
            }
            edits.finish(level);
        }
    }

    /// Returns the cells of a page whose samples are known, one bit each: they must be found again.
    pub(super) fn known_cells(&self, slot: u32) -> u8 {
        let is_root = self.pages[slot as usize].level == self.layout.root();
        let is_known = |cell: u32| is_root || self.children[cell as usize] != UNKNOWN_CELL;
        let known = (0..8).filter(|i| is_known(8 * slot + i));
        known.fold(0, |all, i| all | 1 << i)
    }

    /// Replaces some cells of pages, one bit each, and removes pages below cells that no longer have any.
    pub(super) fn replace_cells<T: Texel>(
        &mut self,
        slots: &[u32],
        baked: &[BakedPage<T>],
        renewed: &[u8],
        done: &mut EditStats,
    ) {
        done.filled += baked.iter().map(BakedPage::bricks).sum::<u64>();
        let counts = renewed.iter().map(|cells| u64::from(cells.count_ones()));
        done.cells += counts.sum::<u64>();
        let cells = || {
            slots.iter().zip(renewed).flat_map(|(&slot, &renewed)| {
                let some = (0..8).filter(move |i| renewed >> i & 1 != 0);
                some.map(move |i| (8 * slot + i) as usize)
            })
        };
        let had_page: Vec<u32> = cells().map(|cell| self.children[cell]).collect();
        // Cells that are not sampled have no page.
        for cell in cells() {
            if !is_page(self.children[cell]) {
                self.children[cell] = UNKNOWN_CELL;
            }
        }
        self.commit(slots, baked, |index| renewed[index]);
        for ((slot, page), renewed) in slots.iter().zip(baked).zip(renewed) {
            for i in (0..8).filter(|i| renewed >> i & 1 != 0) {
                if page.cells.iter().all(|own| own.cell != i) {
                    self.children[(8 * slot + i) as usize] = UNKNOWN_CELL;
                }
            }
        }
        let gone: Vec<u32> = cells()
            .zip(&had_page)
            .filter(|&(cell, &was)| is_page(was) && self.children[cell] != was)
            .map(|(_, &was)| was)
            .collect();
        if !gone.is_empty() {
            let gone = self.all_below(gone);
            self.remove_pages::<T>(&gone);
        }
    }

    /// Returns pages and all pages below them.
    fn all_below(&self, mut slots: Vec<u32>) -> Vec<u32> {
        let mut at = 0;
        while at < slots.len() {
            let cells = 8 * slots[at] as usize..8 * slots[at] as usize + 8;
            let children = self.children[cells].iter().copied();
            slots.extend(children.filter(|&child| is_page(child)));
            at += 1;
        }
        slots
    }

    /// Returns the pages of a level that boxes reach, in the order of their slots.
    fn touched(&self, level: u32, boxes: &[Aabb]) -> Vec<u32> {
        let mut found = Vec::new();
        let roots = self.roots.iter().copied().filter(|&slot| slot != NO_PAGE);
        let mut open: Vec<u32> = roots.collect();
        while let Some(slot) = open.pop() {
            let page = &self.pages[slot as usize];
            let held = self.layout.edited_box(page);
            if !boxes.iter().any(|one| !one.intersection(held).is_empty()) {
                continue;
            }
            if page.level == level {
                found.push(slot);
            } else {
                let cells = 8 * slot as usize..8 * slot as usize + 8;
                let children = self.children[cells].iter().copied();
                open.extend(children.filter(|&child| is_page(child)));
            }
        }
        found.sort_unstable();
        found
    }
}
