//! Follows edits: every resident page that they reach is baked again, on all levels.

use super::bake::PageContext;
use super::fill::{PageJob, bake_all, by_format};
use super::page::NO_PAGE;
use super::pending::LevelsPendingEdits;
use super::tree::Levels;
use crate::{EditStats, SampleFormat, Texel};
use argil_field::Program;
use argil_math::Aabb;

impl Levels {
    /// Grows to another box of the same voxels.
    pub(super) fn grow_to(&mut self, layout: super::LevelsLayout) {
        let [low, high] = layout.root_blocks();
        let old = (self.root_low, self.root_size);
        let (low, high) = (low.min(old.0), high.max(old.0 + old.1));
        let size = high - low;
        let mut roots = vec![NO_PAGE; size.element_product() as usize];
        for block in self.root_places() {
            if let Some(slot) = self.root_slot(block) {
                let at = block - low;
                roots[(at.x + size.x * (at.y + size.y * at.z)) as usize] = slot;
            }
        }
        (self.root_low, self.root_size, self.roots) = (low, size, roots);
        self.layout = layout;
    }

    /// Bakes all resident pages again that edits reach. Pages that are not resident need nothing: they are baked
    /// from the edited program when a ray asks for them.
    ///
    /// # Errors
    /// If the coarsest level alone exceeds the budget.
    pub fn edit(
        &mut self,
        program: &Program,
        edits: &mut LevelsPendingEdits,
    ) -> Result<EditStats, crate::BricksError> {
        if edits.is_done() {
            return Ok(EditStats::default());
        }
        by_format!(self, edit_pages(program, edits))
    }

    fn edit_pages<T: Texel>(
        &mut self,
        program: &Program,
        edits: &mut LevelsPendingEdits,
    ) -> Result<EditStats, crate::BricksError> {
        let mut done = EditStats::default();
        // Requests name slots, which may be freed now.
        self.requests.take();
        self.lists.fill(None);
        self.lipschitz = program.lipschitz();
        self.bake_roots::<T>(program)?;
        let context = PageContext::new(program, &self.layout);
        let before = self.brick_count();
        for level in (0..self.layout.len()).rev() {
            let boxes = edits.take(level);
            let touched: Vec<u32> = self.touched(level, &boxes);
            let mut lists = self.lists_of(&context, &touched);
            let jobs: Vec<PageJob> = touched
                .iter()
                .map(|slot| PageJob {
                    level,
                    block: self.pages[*slot as usize].block(),
                    list: lists.remove(slot).unwrap_or_default(),
                })
                .collect();
            let baked = bake_all::<T>(&context, jobs);
            done.filled += baked.iter().map(|page| page.made.sampled).sum::<u64>();
            done.cells += 64 * baked.len() as u64;
            self.commit(&baked);
            // Without a brick in the octant, there are no finer pages.
            let mut gone = Vec::new();
            for &slot in &touched {
                let octants = self.open_octants(slot);
                for octant in (0..8).filter(|octant| octants >> octant & 1 == 0) {
                    self.list_below(self.pages[slot as usize].children[octant], &mut gone);
                }
            }
            self.remove::<T>(&gone);
        }
        let after = self.brick_count();
        done.added = after.saturating_sub(before);
        done.removed = before.saturating_sub(after);
        Ok(done)
    }

    /// Lists a page and all below it.
    fn list_below(&self, slot: u32, out: &mut Vec<u32>) {
        if slot == NO_PAGE {
            return;
        }
        let from = out.len();
        out.push(slot);
        let mut at = from;
        while at < out.len() {
            let children = self.pages[out[at] as usize].children;
            out.extend(children.into_iter().filter(|&child| child != NO_PAGE));
            at += 1;
        }
    }

    /// Returns the resident pages of a level that boxes reach, in the order of their slots.
    fn touched(&self, level: u32, boxes: &[Aabb]) -> Vec<u32> {
        let mut found = Vec::new();
        let mut open: Vec<u32> = self
            .roots
            .iter()
            .copied()
            .filter(|&s| s != NO_PAGE)
            .collect();
        while let Some(slot) = open.pop() {
            let page = &self.pages[slot as usize];
            let held = self.layout.block_box(page.level, page.block());
            // A point on a page's side belongs to both pages.
            let held = held.grown(0.01 * self.layout.level(level).voxel_grid.voxel_size);
            if !boxes.iter().any(|one| !one.intersection(held).is_empty()) {
                continue;
            }
            if page.level == level {
                found.push(slot);
            } else {
                open.extend(page.children.into_iter().filter(|&child| child != NO_PAGE));
            }
        }
        found.sort_unstable();
        found
    }

    /// Counts the resident pages that differ from a fresh bake with a program, to the bit: in their words, bricks or
    /// materials.
    pub fn differing_pages(&self, program: &Program) -> u64 {
        match self.layout.level(0).encoding.format {
            SampleFormat::Snorm8 => self.differing::<i8>(program),
            SampleFormat::Snorm16 => self.differing::<i16>(program),
        }
    }

    fn differing<T: Texel>(&self, program: &Program) -> u64 {
        let mut fresh = Self::empty(self.layout, program.lipschitz(), u64::MAX);
        if fresh.bake_roots::<T>(program).is_err() {
            return self.resident().count() as u64;
        }
        let mut count = 0;
        let mut open: Vec<u32> = self
            .roots
            .iter()
            .copied()
            .filter(|&s| s != NO_PAGE)
            .collect();
        while !open.is_empty() {
            let mut asked = Vec::new();
            let mut next = Vec::new();
            for &slot in &open {
                let page = &self.pages[slot as usize];
                let own = fresh.find(page.level, page.block());
                let own = own.filter(|&own| fresh.pages[own as usize].level == page.level);
                let Some(own) = own else {
                    // A page that cannot be there.
                    count += 1;
                    continue;
                };
                count += u64::from(!self.is_same_page(slot, &fresh, own));
                for (octant, &child) in (0..).zip(&page.children) {
                    if child != NO_PAGE {
                        next.push(child);
                        asked.push(super::PageRequest::new(own, octant, 1.0, 0.0));
                    }
                }
            }
            fresh.requests.add(&asked);
            fresh.fill(program, None);
            open = next;
        }
        count
    }

    fn is_same_page(&self, own: u32, other: &Self, theirs: u32) -> bool {
        let words = |levels: &Self, slot: u32| {
            levels.store.words[slot as usize * 64..(slot as usize + 1) * 64].to_vec()
        };
        let pairs = words(self, own).into_iter().zip(words(other, theirs));
        let bytes = self.layout.level(0).brick_bytes() as usize;
        pairs.into_iter().all(|(a, b)| {
            if crate::is_brick(a) != crate::is_brick(b) {
                return false;
            }
            if !crate::is_brick(a) {
                return a == b;
            }
            let texels = |levels: &Self, brick: u32| {
                levels.store.pool.bytes()[brick as usize * bytes..][..bytes].to_vec()
            };
            texels(self, a) == texels(other, b)
                && self.store.material_of(a) == other.store.material_of(b)
        })
    }
}
