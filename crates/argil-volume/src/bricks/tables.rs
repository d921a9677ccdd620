//! The tables of sparse bricks.

use super::cell::{BrickCell, inner_cell};
use super::changes::BrickChanges;
use super::layout::{BLOCK_SIDE, BrickLayout};
use super::store::BrickStore;
use super::table::BlockTable;
use crate::Texels;
use argil_field::CELLS_PER_BATCH;
use glam::IVec3;

/// A sparse volume of bricks.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{BrickLayout, BrickSettings, Bricks, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 64)?;
/// let layout = BrickLayout::new(grid, &BrickSettings::default())?;
/// let (bricks, _) = Bricks::bake(&program, layout, None)?;
/// assert!(bricks.has_brick([0.5, 0.0, 0.0].into()));
/// assert!(!bricks.has_brick([0.0, 0.0, 0.0].into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[doc(alias = "VDB")]
#[doc(alias = "narrow band")]
#[doc(alias = "brickmap")]
pub struct Bricks {
    pub(super) layout: BrickLayout,
    /// The Lipschitz constant of the distances.
    pub(super) lipschitz: f32,
    /// The blocks.
    pub(super) table: BlockTable,
    /// For each slot, a bit for each cell with a brick.
    pub(super) masks: Vec<u64>,
    pub(super) store: BrickStore,
}

impl Bricks {
    /// Takes the list of what edits changed since the last call or the bake. A copy elsewhere, such as on a
    /// renderer's GPU, updates from it. Brick `n` is at `n · (brick_size_voxels + 1)³` samples of [`Bricks::pool`],
    /// and slot `n` at `64 n` of [`Bricks::words`].
    pub fn take_changes(&mut self) -> BrickChanges {
        self.store
            .changes
            .take(self.store.cell_of_brick.len() as u32)
    }

    /// Returns the layout of cells and bricks.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// Returns the Lipschitz constant of the distances.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Returns the blocks and their slots.
    pub fn table(&self) -> &BlockTable {
        &self.table
    }

    /// Returns the word of each cell, slot by slot. The first slots are the far slots.
    pub fn words(&self) -> &[u32] {
        &self.store.words
    }

    /// Returns the mask of each slot: a bit for each cell with a brick.
    pub fn masks(&self) -> &[u64] {
        &self.masks
    }

    pub(crate) fn set_cut(&mut self, is_cut: bool) {
        self.layout.voxel_grid.is_clipped = is_cut;
    }

    /// Grows to a larger box with the same voxels. Samples nothing.
    pub fn grow(&mut self, layout: BrickLayout) {
        let same = (
            self.layout.voxel_grid.corner,
            self.layout.voxel_grid.voxel_size,
        ) == (layout.voxel_grid.corner, layout.voxel_grid.voxel_size);
        if same && self.layout.brick_size_voxels == layout.brick_size_voxels {
            self.layout.voxel_grid = layout.voxel_grid;
            let [low, high] = layout.block_range();
            self.table.grow_to(low, high);
        }
    }

    /// Returns the owner of each brick: the index of its cell's word.
    pub fn cell_of_brick(&self) -> &[u32] {
        &self.store.cell_of_brick
    }

    /// Returns the samples, brick by brick. An empty volume has one brick of zeros.
    pub fn pool(&self) -> &Texels {
        &self.store.pool
    }

    /// Returns the number of bricks.
    pub fn len(&self) -> usize {
        self.store.cell_of_brick.len()
    }

    /// Whether there is no brick.
    pub fn is_empty(&self) -> bool {
        self.store.cell_of_brick.is_empty()
    }

    /// Returns the bytes of everything.
    pub fn memory_bytes(&self) -> u64 {
        let masks = size_of_val(&self.masks[..]) as u64;
        self.table.memory_bytes() + masks + self.store.memory_bytes()
    }

    /// Returns the index of a cell's word.
    #[inline]
    pub fn word_index(&self, cell: IVec3) -> usize {
        let side = BLOCK_SIDE as i32;
        let block = cell.div_euclid(IVec3::splat(side));
        let inner = cell - block * side;
        self.table.slot(block) as usize * CELLS_PER_BATCH
            + (inner.x + side * (inner.y + side * inner.z)) as usize
    }

    /// Returns the cell of a word in a block.
    pub fn cell_at(&self, index: usize) -> IVec3 {
        self.table.cell(index / CELLS_PER_BATCH) + inner_cell(index % CELLS_PER_BATCH)
    }

    /// Returns the contents of a cell anywhere.
    pub fn cell(&self, cell: IVec3) -> BrickCell {
        BrickCell::of(self.store.words[self.word_index(cell)])
    }
}
