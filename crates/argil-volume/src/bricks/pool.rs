//! Adds and removes bricks of the pool.
//!
//! The pool has no holes between edits. Bricks that an edit needs take freed slots, and then the last bricks move
//! into the rest. So files and other devices see the same as after a bake, and an edit moves no more bricks than it
//! freed.

use super::BrickLayout;
use super::store::BrickStore;
use super::store::PLACES;
use crate::Texel;
use crate::Texels;
use argil_abi::BRICK_MIXED;

/// Bricks by which the pool grows.
const PAGE: usize = 1024;

/// The pool of bricks during an edit.
pub(crate) struct Pool<'a, T> {
    store: &'a mut BrickStore,
    texels: Vec<T>,
    samples: usize,
    free: Vec<u32>,
    /// The owner of each mixed brick's materials.
    mixed_owners: Vec<u32>,
    mixed_free: Vec<u32>,
}

impl<'a, T: Texel> Pool<'a, T> {
    pub(crate) fn open(store: &'a mut BrickStore, layout: &BrickLayout) -> Self {
        let samples = layout.brick_samples() as usize;
        let texels = std::mem::replace(&mut store.pool, Texels::from_vec(Vec::<T>::new()));
        let mut texels = texels.into_vec::<T>();
        // An empty volume's pool has one brick of zeros.
        texels.truncate(store.cell_of_brick.len() * samples);
        let mixed_owners = std::mem::take(&mut store.brick_of_mixed);
        Self {
            store,
            texels,
            samples,
            free: Vec::new(),
            mixed_owners,
            mixed_free: Vec::new(),
        }
    }

    /// Stores a brick for the cell of a word, over its old brick or in a new place.
    pub(crate) fn put(&mut self, at: u32, texels: &[T], material: u32, mixed: &[[u32; 2]]) {
        let word = self.store.words[at as usize];
        let brick = if names_brick(word) {
            self.free_mixed(word);
            word
        } else {
            self.take(at)
        };
        let to = brick as usize * self.samples;
        self.texels[to..to + self.samples].copy_from_slice(texels);
        self.store.materials[brick as usize] = if material & BRICK_MIXED == 0 {
            material
        } else {
            BRICK_MIXED | self.put_mixed(brick, mixed)
        };
        self.store.words[at as usize] = brick;
        self.store.changes.brick(brick);
    }

    /// Frees the brick of a word's cell, if there is one. The word then gets a new value.
    pub(crate) fn clear(&mut self, at: u32, word: u32) {
        let old = std::mem::replace(&mut self.store.words[at as usize], word);
        if names_brick(old) {
            self.free_mixed(old);
            self.store.cell_of_brick[old as usize] = u32::MAX;
            self.free.push(old);
        }
    }

    /// Takes a place for the brick of a word's cell.
    fn take(&mut self, at: u32) -> u32 {
        if let Some(brick) = self.free.pop() {
            self.store.cell_of_brick[brick as usize] = at;
            return brick;
        }
        let brick = self.store.cell_of_brick.len() as u32;
        if self.texels.len() + self.samples > self.texels.capacity() {
            self.texels.reserve_exact(PAGE * self.samples);
            self.store.cell_of_brick.reserve_exact(PAGE);
            self.store.materials.reserve_exact(PAGE);
        }
        let length = self.texels.len() + self.samples;
        self.texels.resize(length, T::default());
        self.store.cell_of_brick.push(at);
        self.store.materials.push(0);
        brick
    }

    fn put_mixed(&mut self, brick: u32, mixed: &[[u32; 2]]) -> u32 {
        let block = match self.mixed_free.pop() {
            Some(block) => block,
            None => {
                let all = &mut self.store.mixed;
                if all.len() + PLACES > all.capacity() {
                    all.reserve_exact(PAGE * PLACES / 4);
                }
                all.resize(all.len() + PLACES, [0; 2]);
                self.mixed_owners.push(u32::MAX);
                self.mixed_owners.len() as u32 - 1
            }
        };
        let to = block as usize * PLACES;
        self.store.mixed[to..to + PLACES].copy_from_slice(mixed);
        self.mixed_owners[block as usize] = brick;
        block
    }

    fn free_mixed(&mut self, brick: u32) {
        let material = self.store.materials[brick as usize];
        if material & BRICK_MIXED != 0 {
            let block = material & !BRICK_MIXED;
            self.mixed_owners[block as usize] = u32::MAX;
            self.mixed_free.push(block);
            self.store.materials[brick as usize] = 0;
        }
    }

    /// Moves the last bricks into places that were freed and not reused.
    pub(crate) fn close(self) {
        let Self {
            store,
            mut texels,
            samples,
            mut free,
            mut mixed_owners,
            mut mixed_free,
        } = self;
        free.sort_unstable();
        for &gap in &free {
            while store.cell_of_brick.last() == Some(&u32::MAX) {
                store.cell_of_brick.pop();
            }
            let (gap, last) = (gap as usize, store.cell_of_brick.len().wrapping_sub(1));
            if gap >= store.cell_of_brick.len() {
                break;
            }
            let from = last * samples;
            texels.copy_within(from..from + samples, gap * samples);
            let owner = store.cell_of_brick[last];
            store.cell_of_brick[gap] = owner;
            store.words[owner as usize] = gap as u32;
            store.changes.brick(gap as u32);
            store.changes.slot(owner / 64);
            let material = store.materials[last];
            store.materials[gap] = material;
            if material & BRICK_MIXED != 0 {
                mixed_owners[(material & !BRICK_MIXED) as usize] = gap as u32;
            }
            store.cell_of_brick.pop();
        }
        while store.cell_of_brick.last() == Some(&u32::MAX) {
            store.cell_of_brick.pop();
        }
        let count = store.cell_of_brick.len();
        store.materials.truncate(count);
        texels.truncate(count * samples);

        mixed_free.sort_unstable();
        for &gap in &mixed_free {
            while mixed_owners.last() == Some(&u32::MAX) {
                mixed_owners.pop();
            }
            let (gap, last) = (gap as usize, mixed_owners.len().wrapping_sub(1));
            if gap >= mixed_owners.len() {
                break;
            }
            store
                .mixed
                .copy_within(last * PLACES..(last + 1) * PLACES, gap * PLACES);
            let owner = mixed_owners[last];
            mixed_owners[gap] = owner;
            store.materials[owner as usize] = BRICK_MIXED | gap as u32;
            store.changes.brick(owner);
            mixed_owners.pop();
        }
        while mixed_owners.last() == Some(&u32::MAX) {
            mixed_owners.pop();
        }
        store.mixed.truncate(mixed_owners.len() * PLACES);

        // Also return memory that a large edit needed.
        if texels.capacity() > texels.len() + 2 * PAGE * samples {
            texels.shrink_to(texels.len() + PAGE * samples);
            store.cell_of_brick.shrink_to(count + PAGE);
            store.materials.shrink_to(count + PAGE);
        }
        if store.mixed.capacity() > store.mixed.len() + PAGE * PLACES {
            store.mixed.shrink_to(store.mixed.len() + PAGE * PLACES / 4);
        }
        if texels.is_empty() {
            texels.resize(samples, T::default());
        }
        store.brick_of_mixed = mixed_owners;
        store.pool = Texels::from_vec(texels);
    }

    /// Returns the word of a cell.
    pub(super) fn word(&self, at: usize) -> u32 {
        self.store.words[at]
    }
}

/// Returns the owner of each mixed brick's materials.
pub(super) fn owners_of_mixed(materials: &[u32], mixed: &[[u32; 2]]) -> Vec<u32> {
    let mut owners = vec![u32::MAX; mixed.len() / PLACES];
    for (brick, &material) in (0..).zip(materials) {
        if material & BRICK_MIXED != 0
            && let Some(owner) = owners.get_mut((material & !BRICK_MIXED) as usize)
        {
            *owner = brick;
        }
    }
    owners
}

/// Whether a word names a brick of the pool.
fn names_brick(word: u32) -> bool {
    super::is_brick(word) && word != super::cell::MISSING_BRICK
}
