use super::{Bricks, inner_cell};
use crate::{SampleFormat, Texel};
use argil_field::CELLS_PER_BATCH;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3, uvec3};

/// A brick of a sparse volume: its position and its samples. [`Bricks::iter`](super::Bricks::iter) returns bricks.
#[derive(Clone, Copy, Debug)]
pub struct Brick<'a> {
    pub(super) bricks: &'a Bricks,
    pub(super) index: u32,
}

impl Brick<'_> {
    /// Returns its index in the pool, which edits can change.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Returns its cell, counted in bricks from the grid's corner.
    pub fn cell(&self) -> IVec3 {
        let owner = self.bricks.store.cell_of_brick[self.index as usize] as usize;
        self.bricks.table.cell(owner / CELLS_PER_BATCH) + inner_cell(owner % CELLS_PER_BATCH)
    }

    /// Returns its box in the scene's unit. Its first sample is at the minimum corner, and its last at the maximum.
    pub fn aabb(&self) -> Aabb {
        self.bricks.layout.cell_box(self.cell())
    }

    /// Returns the samples along each side: one more than voxels.
    pub fn side(&self) -> u32 {
        self.bricks.layout.brick_size_voxels + 1
    }

    /// Returns the position of a sample by its index, x fastest, in the scene's unit.
    pub fn position(&self, index: usize) -> Vec3 {
        let (side, index) = (self.side(), index as u32);
        let inner: UVec3 = uvec3(index % side, index / side % side, index / side / side);
        let voxel_grid = &self.bricks.layout.voxel_grid;
        let first = self.cell() * self.bricks.layout.brick_size_voxels as i32;
        voxel_grid.corner + voxel_grid.voxel_size * (first + inner.as_ivec3()).as_vec3()
    }

    /// Iterates over its samples as distances in the scene's unit, x fastest. Within the band, they are the field's
    /// distances, rounded to the format. At the ends of the band, they are clamped.
    pub fn distances(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        let layout = &self.bricks.layout;
        let count = layout.brick_samples() as usize;
        let first = self.index as usize * count;
        let range = layout.encoding.band_width(&layout.voxel_grid, 0);
        let unit = range / self.bricks.store.pool.bits().max_code() as f32;
        (first..first + count).map(move |at| unit * self.integer(at))
    }

    fn integer(&self, at: usize) -> f32 {
        let pool = &self.bricks.store.pool;
        match pool.bits() {
            SampleFormat::Snorm8 => pool.of::<i8>().map_or(0.0, |all| all[at].code()),
            SampleFormat::Snorm16 => pool.of::<i16>().map_or(0.0, |all| all[at].code()),
        }
    }
}
