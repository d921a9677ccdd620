//! Evicts what no ray used for the longest time.

use super::page::{NO_PAGE, is_page};
use super::tree::{Levels, PAGE_BYTES};
use crate::bricks::Pool;
use crate::{MISSING_BRICK, Texel, is_brick};
use std::sync::atomic::Ordering;

/// The factors by which the accepted size of voxels changes from fill to fill, and its limit.
const COARSER: f32 = 1.2;
const FINER: f32 = 0.95;
const MAX_COARSENING: f32 = 256.0;

impl Levels {
    /// Removes bricks of cells. What is known of the cells stays.
    fn remove_bricks<T: Texel>(&mut self, cells: &[u32]) {
        let layout = self.layout.level(0);
        let mut pool = Pool::<T>::open(&mut self.store, &layout);
        for &cell in cells {
            pool.clear(cell, MISSING_BRICK);
        }
        pool.close();
    }

    /// Removes pages that have no pages below them, and their bricks.
    pub(super) fn remove_pages<T: Texel>(&mut self, slots: &[u32]) {
        let layout = self.layout.level(0);
        let mut pool = Pool::<T>::open(&mut self.store, &layout);
        for &slot in slots {
            for cell in 8 * slot..8 * slot + 8 {
                pool.clear(cell, crate::bricks::empty_word(0.0));
            }
        }
        pool.close();
        for &slot in slots {
            let parent = self.pages[slot as usize].parent;
            if let Some(child) = self.children.get_mut(parent as usize)
                && *child == slot
            {
                *child = NO_PAGE;
            }
            self.pages[slot as usize].parent = NO_PAGE;
            self.forget_lists(slot);
            self.free.push(slot);
        }
    }

    /// Returns the bytes of the budget that bricks and pages in use need. Programs of a scene that is itself large may
    /// need more than their share.
    pub(super) fn used_bytes(&self) -> u64 {
        let lists = self.list_bytes();
        let beyond = lists.saturating_sub(self.list_share());
        self.memory_bytes() - beyond - PAGE_BYTES * self.free.len() as u64
    }

    /// Evicts bricks and pages until some more bytes fit. Returns how many bricks, and whether they fit now.
    pub(super) fn make_room<T: Texel>(&mut self, bytes: u64) -> (u64, bool) {
        if self.used_bytes() + bytes <= self.budget {
            return (0, true);
        }
        // A little more than is needed, so that this does not happen for each brick.
        let over = self.used_bytes() + bytes - self.budget + self.budget / 64;
        let each = self.layout.level(0).brick_bytes() + 8;
        let stamp = |cell: u32| self.used[cell as usize].load(Ordering::Relaxed);
        let root = self.layout.root();
        let mut old: Vec<u32> = self
            .store
            .cell_of_brick
            .iter()
            .copied()
            .filter(|&cell| stamp(cell) < self.kept_since && self.level_of(cell) < root)
            .collect();
        old.sort_unstable_by_key(|&cell| (stamp(cell), cell));
        old.truncate(over.div_ceil(each) as usize);
        self.remove_bricks::<T>(&old);
        let evicted = old.len() as u64;
        self.remove_unused_pages::<T>();
        (evicted, self.used_bytes() + bytes <= self.budget)
    }

    /// Lets rays accept larger voxels while memory is full, and smaller ones when the last frame used little of it.
    pub(super) fn adapt(&mut self, is_full: bool) {
        if is_full {
            self.coarsening = (self.coarsening * COARSER).min(MAX_COARSENING);
            return;
        }
        if self.coarsening == 1.0 {
            return;
        }
        let is_used =
            |cell: &&u32| self.used[**cell as usize].load(Ordering::Relaxed) >= self.kept_since;
        let used = self.store.cell_of_brick.iter().filter(is_used).count() as u64;
        if 2 * used * (self.layout.level(0).brick_bytes() + 8) < self.budget {
            self.coarsening = (self.coarsening * FINER).max(1.0);
        }
    }

    /// Removes pages without bricks that no recent frame used.
    fn remove_unused_pages<T: Texel>(&mut self) {
        let all: Vec<u32> = self.slots().collect();
        let mut gone = Vec::new();
        for &slot in all.iter().rev() {
            let mut cells = 8 * slot as usize..8 * slot as usize + 8;
            let is_unused = cells.all(|cell| {
                let word = self.store.words[cell];
                let has_brick = is_brick(word) && word != MISSING_BRICK;
                let is_old = self.used[cell].load(Ordering::Relaxed) < self.kept_since;
                !has_brick && !is_page(self.children[cell]) && is_old
            });
            let parent = self.pages[slot as usize].parent;
            if is_unused && parent != NO_PAGE {
                self.children[parent as usize] = NO_PAGE;
                gone.push(slot);
            }
        }
        self.remove_pages::<T>(&gone);
    }
}
