use super::{Bricks, inner_cell};
use crate::{SampleFormat, Texel};
use argil_field::CELLS_PER_BATCH;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3, uvec3};

/// A brick of a sparse volume: where it is, and its samples. [`Bricks::iter`] gives them.
#[derive(Clone, Copy, Debug)]
pub struct Brick<'a> {
    pub(super) bricks: &'a Bricks,
    pub(super) index: u32,
}

impl Brick<'_> {
    /// Its place in the pool, which edits can change.
    pub fn index(&self) -> u32 {
        self.index
    }

    /// Its cell, counted in bricks from the lattice's corner.
    pub fn cell(&self) -> IVec3 {
        let owner = self.bricks.cell_of_brick[self.index as usize] as usize;
        self.bricks.table.cell(owner / CELLS_PER_BATCH) + inner_cell(owner % CELLS_PER_BATCH)
    }

    /// Its box in the scene's unit: its first sample stands at the least corner, its last at the greatest.
    pub fn aabb(&self) -> Aabb {
        self.bricks.layout.cell_box(self.cell())
    }

    /// Samples along each side: one more than voxels.
    pub fn side(&self) -> u32 {
        self.bricks.layout.brick_size_voxels + 1
    }

    /// Where the nth sample stands, x fastest, in the scene's unit.
    pub fn place(&self, nth: usize) -> Vec3 {
        let (side, nth) = (self.side(), nth as u32);
        let inner: UVec3 = uvec3(nth % side, nth / side % side, nth / side / side);
        let lattice = &self.bricks.layout.voxel_grid;
        let first = self.cell() * self.bricks.layout.brick_size_voxels as i32;
        lattice.corner + lattice.voxel_size * (first + inner.as_ivec3()).as_vec3()
    }

    /// Its samples as distances in the scene's unit, x fastest. Within the band they are the field's, rounded to what is stored; at its
    /// end they are cut off.
    pub fn distances(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        let layout = &self.bricks.layout;
        let count = layout.brick_samples() as usize;
        let first = self.index as usize * count;
        let range = layout.encoding.band_width(&layout.voxel_grid, 0);
        let unit = range / self.bricks.pool.bits().max_code() as f32;
        (first..first + count).map(move |at| unit * self.integer(at))
    }

    fn integer(&self, at: usize) -> f32 {
        let pool = &self.bricks.pool;
        match pool.bits() {
            SampleFormat::Snorm8 => pool.of::<i8>().map_or(0.0, |all| all[at].integer()),
            SampleFormat::Snorm16 => pool.of::<i16>().map_or(0.0, |all| all[at].integer()),
        }
    }
}
