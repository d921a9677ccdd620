//! Follows edits: what is resident where they reach is baked again, on all levels.

use super::bake::PageContext;
use super::fill::by_format;
use super::layout::LevelsLayout;
use super::page::{NO_PAGE, UNKNOWN_CELL, is_page};
use super::pending::LevelsPendingEdits;
use super::tree::Levels;
use crate::MISSING_BRICK;
use crate::{BricksError, EditStats, SampleFormat, Texel, is_brick};
use argil_field::Program;
use argil_math::Aabb;

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

    /// Bakes again what is resident where edits reach. What is not resident needs nothing: it is baked from the edited
    /// program when a ray asks for it.
    ///
    /// # Errors
    /// If the coarsest level alone exceeds the budget.
    pub fn edit(
        &mut self,
        program: &Program,
        edits: &mut LevelsPendingEdits,
    ) -> Result<EditStats, BricksError> {
        if edits.is_done() {
            return Ok(EditStats::default());
        }
        by_format!(self, edit_pages(program, edits))
    }

    fn edit_pages<T: Texel>(
        &mut self,
        program: &Program,
        edits: &mut LevelsPendingEdits,
    ) -> Result<EditStats, BricksError> {
        let mut done = EditStats::default();
        // Requests name cells, whose pages may be freed now.
        self.requests.take();
        self.lists.fill(None);
        self.lipschitz = program.lipschitz();
        self.bake_roots::<T>(program)?;
        let context = PageContext::new(program, &self.layout);
        let before = self.brick_count();
        for level in (0..self.layout.count()).rev() {
            let boxes = edits.take(level);
            let slots = self.touched(level, &boxes);
            // What is known of a cell's samples must be found again.
            let known = |cell: u32| self.children[cell as usize] != UNKNOWN_CELL;
            let is_root = level == self.layout.root();
            let cells: Vec<u8> = slots
                .iter()
                .map(|slot| {
                    let own = (0..8).filter(|i| is_root || known(8 * slot + i));
                    own.fold(0, |all, i| all | 1 << i)
                })
                .collect();
            let baked = self.bake_pages::<T>(&context, &slots, &cells);
            done.filled += baked.iter().map(|page| page.bricks()).sum::<u64>();
            done.cells += 8 * slots.len() as u64;
            let had_page: Vec<u32> = slots
                .iter()
                .flat_map(|slot| self.children[8 * *slot as usize..][..8].iter().copied())
                .collect();
            // Cells that are not sampled have no page.
            for slot in &slots {
                for cell in 8 * *slot as usize..8 * *slot as usize + 8 {
                    if !is_page(self.children[cell]) {
                        self.children[cell] = UNKNOWN_CELL;
                    }
                }
            }
            self.commit(&slots, &baked, true);
            let mut gone = Vec::new();
            for (nth, (slot, page)) in slots.iter().zip(&baked).enumerate() {
                for i in 0..8 {
                    let child = &mut self.children[(8 * slot + i) as usize];
                    let is_sampled = page.cells.iter().any(|own| own.cell == i);
                    if !is_sampled {
                        *child = UNKNOWN_CELL;
                    }
                    let was = had_page[8 * nth + i as usize];
                    if is_page(was) && *child != was {
                        gone.push(was);
                    }
                }
            }
            let gone = self.all_below(gone);
            self.remove_pages::<T>(&gone);
        }
        let after = self.brick_count();
        done.added = after.saturating_sub(before);
        done.removed = before.saturating_sub(after);
        Ok(done)
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
        let rounding = 0.01 * self.layout.level(level).voxel_grid.voxel_size;
        while let Some(slot) = open.pop() {
            let page = &self.pages[slot as usize];
            // A point on a page's side belongs to both pages.
            let held = self.layout.page_box(page).grown(rounding);
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

    /// Counts the cells of resident pages that differ from a fresh bake with a program, to the bit: in what is known of
    /// them, their words, or their bricks and materials.
    pub fn differing_cells(&self, program: &Program) -> u64 {
        by_format!(self, differing(program))
    }

    fn differing<T: Texel>(&self, program: &Program) -> u64 {
        let mut fresh = Self::empty(self.layout, program.lipschitz(), u64::MAX);
        if fresh.bake_roots::<T>(program).is_err() {
            return 8 * self.page_count();
        }
        let mut count = 0;
        // Pages of this tree, with those of the fresh one.
        let mut open: Vec<(u32, u32)> = Vec::new();
        for place in self.root_places() {
            match (self.root_slot(place), fresh.root_slot(place)) {
                (Some(own), Some(other)) => open.push((own, other)),
                // The box was larger before: nothing is there.
                (Some(own), None) => {
                    let mut cells = 8 * own as usize..8 * own as usize + 8;
                    count += u64::from(cells.any(|cell| is_brick(self.store.words[cell])));
                }
                _ => count += 8,
            }
        }
        while !open.is_empty() {
            let cells =
                |&(own, other): &(u32, u32)| (0..8).map(move |i| (8 * own + i, 8 * other + i));
            // Sample what is known of this tree's cells.
            let known = |cell: u32| self.children[cell as usize] != UNKNOWN_CELL;
            for pair in &open {
                for (own, other) in cells(pair) {
                    let is_missing = fresh.store.words[other as usize] == MISSING_BRICK;
                    // A cell that is clear was sampled too.
                    let was_sampled = known(own) || self.store.words[own as usize] != MISSING_BRICK;
                    if was_sampled && is_missing {
                        fresh
                            .requests
                            .add(&[super::PageRequest::of_cell(other, 1.0, 0.0)]);
                    }
                }
            }
            fresh.fill(program, None);
            let mut next = Vec::new();
            for pair in &open {
                for (own, other) in cells(pair) {
                    count += u64::from(!self.is_same_cell(own, &fresh, other));
                    let is_open = fresh.children[other as usize] == NO_PAGE;
                    if is_page(self.children[own as usize]) && is_open {
                        next.push((self.children[own as usize], other));
                        fresh
                            .requests
                            .add(&[super::PageRequest::of_child(other, 0, 1.0, 0.0)]);
                    }
                }
            }
            fresh.fill(program, None);
            open = next
                .into_iter()
                .map(|(own, above)| (own, fresh.children[above as usize]))
                .collect();
        }
        count
    }

    fn is_same_cell(&self, own: u32, other: &Self, theirs: u32) -> bool {
        let (a, b) = (
            self.store.words[own as usize],
            other.store.words[theirs as usize],
        );
        let (child, fresh) = (self.children[own as usize], other.children[theirs as usize]);
        let is_known = child != UNKNOWN_CELL;
        if is_known && is_page(child) != (fresh == NO_PAGE) && child != fresh {
            return false;
        }
        match (is_brick(a), is_brick(b)) {
            (false, false) => a == b,
            // Evicted, or not asked for yet. The fresh one may have found that it is clear.
            (true, _) if a == MISSING_BRICK => !is_known || is_brick(b),
            (true, true) if b != MISSING_BRICK => {
                let bytes = self.layout.level(0).brick_bytes() as usize;
                let texels = |levels: &Self, brick: u32| {
                    levels.store.pool.bytes()[brick as usize * bytes..][..bytes].to_vec()
                };
                texels(self, a) == texels(other, b)
                    && self.store.material_of(a) == other.store.material_of(b)
            }
            _ => false,
        }
    }
}
