//! Creates bricks from stored parts, after checking them.

use super::cell::BrickCell;
use super::changes::ChangeLog;
use super::layout::BrickLayout;
use super::pool;
use super::store::{BrickStore, PLACES};
use super::table::{BlockTable, FAR_SLOTS, far_words};
use super::tables::Bricks;
use crate::Texels;
use argil_abi::BRICK_MIXED;
use argil_field::CELLS_PER_BATCH;

impl Bricks {
    /// Creates bricks from stored parts, with 64 words per slot of the table.
    ///
    /// # Errors
    /// A description of how the tables contradict each other.
    pub fn from_parts(
        layout: BrickLayout,
        lipschitz: f32,
        (mut table, mut words): (BlockTable, Vec<u32>),
        (materials, mixed): (Vec<u32>, Vec<[u32; 2]>),
        pool: Texels,
    ) -> Result<Self, &'static str> {
        if !(1.0..=1e6).contains(&lipschitz) {
            return Err("invalid Lipschitz constant");
        }
        let samples = layout.brick_samples() as usize;
        if pool.bits() != layout.encoding.format {
            return Err("the samples have another width");
        }
        let length = pool.bytes().len() / pool.bits().bytes();
        if !length.is_multiple_of(samples) || length == 0 {
            return Err("the samples are not a multiple of a brick");
        }
        if words.len() != table.slots() * CELLS_PER_BATCH {
            return Err("there are not as many cells as the blocks have");
        }
        let [low, high] = layout.block_range();
        table.grow_to(low, high);
        words[..FAR_SLOTS as usize * CELLS_PER_BATCH]
            .copy_from_slice(&far_words(layout.far_length()));
        if layout.check_count((length / samples) as u64).is_err() {
            return Err("it has more bricks than can be");
        }
        let mut owners = vec![u32::MAX; length / samples];
        let mut masks = vec![0u64; words.len() / CELLS_PER_BATCH];
        let mut is_there = vec![false; table.slots()];
        for (slot, block) in table.blocks() {
            is_there[slot] = true;
            if layout.voxel_grid.is_clipped && (block.cmplt(low).any() || block.cmpge(high).any()) {
                return Err("a block is outside of the box");
            }
        }
        for (at, &word) in words.iter().enumerate() {
            if let BrickCell::Brick(brick) = BrickCell::of(word) {
                if !is_there[at / CELLS_PER_BATCH] {
                    return Err("a brick is in no block");
                }
                match owners.get_mut(brick as usize) {
                    Some(owner) if *owner == u32::MAX => *owner = at as u32,
                    Some(_) => return Err("a brick is in two cells"),
                    None => return Err("a cell's brick is not there"),
                }
                masks[at / 64] |= 1 << (at % 64);
            }
        }
        if owners.len() > 1 && owners.contains(&u32::MAX) {
            return Err("a brick is in no cell");
        }
        if owners == [u32::MAX] {
            owners.clear();
        }
        if materials.len() != owners.len() || !mixed.len().is_multiple_of(PLACES) {
            return Err("there are not as many materials as bricks");
        }
        let blocks = (mixed.len() / PLACES) as u32;
        let is_beyond = |&m: &u32| m & BRICK_MIXED != 0 && m & !BRICK_MIXED >= blocks;
        if materials.iter().any(is_beyond) {
            return Err("a mixed brick's materials are not there");
        }
        Ok(Self {
            layout,
            lipschitz,
            table,
            masks,
            store: BrickStore {
                brick_of_mixed: pool::owners_of_mixed(&materials, &mixed),
                changes: ChangeLog::default(),
                materials,
                mixed,
                words,
                cell_of_brick: owners,
                pool,
            },
        })
    }
}
