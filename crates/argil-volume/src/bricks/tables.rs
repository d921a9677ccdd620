//! What sparse bricks hold.

use super::cell::{BrickCell, inner_cell};
use super::changes::{BrickChanges, ChangeLog};
use super::layout::{BLOCK_SIDE, BrickLayout};
use super::table::BlockTable;
use crate::Texels;
use argil_field::CELLS_PER_BATCH;
use glam::IVec3;

/// A sparse volume of bricks.
#[derive(Clone, Debug, PartialEq)]
pub struct Bricks {
    pub(super) layout: BrickLayout,
    /// By how much distances can change over a length of 1.
    pub(super) lipschitz: f32,
    /// Which blocks there are.
    pub(super) table: BlockTable,
    /// A bit for each cell of a slot's block that has a brick.
    pub(super) masks: Vec<u64>,
    /// What is in each cell, slot by slot.
    pub(super) words: Vec<u32>,
    /// Whose brick it is: the place of its cell's word.
    pub(super) cell_of_brick: Vec<u32>,
    /// What each brick looks like.
    pub(super) materials: Vec<u32>,
    /// The materials of mixed bricks.
    pub(super) mixed: Vec<[u32; 2]>,
    /// Which brick each of those is of.
    pub(super) brick_of_mixed: Vec<u32>,
    pub(super) pool: Texels,
    pub(super) changes: ChangeLog,
}

impl Bricks {
    /// What edits have changed since this was last called, or since the bake: what a copy elsewhere, as on a renderer's own GPU, has
    /// to bring over. Its brick `n` is at `n · (brick + 1)³` samples of [`Bricks::pool`], its slot `n` at `64 n` of
    /// [`Bricks::words`].
    pub fn take_changes(&mut self) -> BrickChanges {
        self.changes.take(self.cell_of_brick.len() as u32)
    }

    /// Its measures.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// By how much distances can change over a length of 1.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Which blocks there are, and their slots.
    pub fn table(&self) -> &BlockTable {
        &self.table
    }

    /// What is in each cell, slot by slot; the first slots are of no block and tell of what is far.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// A bit for each cell with a brick, a mask for each slot.
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }

    pub(crate) fn set_cut(&mut self, is_cut: bool) {
        self.layout.voxel_grid.is_clipped = is_cut;
    }

    /// The same voxels over a larger box. Nothing is sampled.
    pub fn grow(&mut self, layout: BrickLayout) {
        let same = (
            self.layout.voxel_grid.corner,
            self.layout.voxel_grid.voxel_size,
        ) == (layout.voxel_grid.corner, layout.voxel_grid.voxel_size);
        if same && self.layout.brick_size_voxels == layout.brick_size_voxels {
            self.layout.voxel_grid = layout.voxel_grid;
            let [low, high] = layout.block_range();
            self.table.cover(low, high);
        }
    }

    /// Whose each brick is: the place of its cell's word.
    pub fn cell_of_brick(&self) -> &[u32] {
        &self.cell_of_brick
    }

    /// The bricks' samples, brick by brick. Where there is no brick at all, there is one of zeros.
    pub fn pool(&self) -> &Texels {
        &self.pool
    }

    /// Number of bricks.
    pub fn len(&self) -> usize {
        self.cell_of_brick.len()
    }

    /// Whether there is no brick.
    pub fn is_empty(&self) -> bool {
        self.cell_of_brick.is_empty()
    }

    /// Bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let tables = size_of_val(&self.masks[..])
            + size_of_val(&self.words[..])
            + size_of_val(&self.cell_of_brick[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.brick_of_mixed[..]);
        self.table.memory_bytes() + tables as u64 + self.pool.bytes().len() as u64
    }

    /// Where a cell's word stands.
    #[inline]
    pub fn word_index(&self, cell: IVec3) -> usize {
        let side = BLOCK_SIDE as i32;
        let block = cell.div_euclid(IVec3::splat(side));
        let inner = cell - block * side;
        self.table.slot(block) as usize * CELLS_PER_BATCH
            + (inner.x + side * (inner.y + side * inner.z)) as usize
    }

    /// The cell whose word stands there, of a block.
    pub fn cell_at(&self, index: usize) -> IVec3 {
        self.table.cell(index / CELLS_PER_BATCH) + inner_cell(index % CELLS_PER_BATCH)
    }

    /// What is in a cell, wherever it is.
    pub fn cell(&self, cell: IVec3) -> BrickCell {
        BrickCell::of(self.words[self.word_index(cell)])
    }
}
