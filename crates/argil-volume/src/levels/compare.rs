//! Compares levels with a fresh bake.

use super::fill::by_format;
use super::page::{NO_PAGE, UNKNOWN_CELL, is_page};
use super::tree::Levels;
use crate::MISSING_BRICK;
use crate::{SampleFormat, Texel, is_brick};
use argil_field::Program;

impl Levels {
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
