use super::{Bricks, inner_cell};
use crate::{Bits, Texel};
use argil_field::CELLS;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3, uvec3};

/// A brick of a sparse volume: where it is, and its samples. [`Bricks::iter`] gives them.
#[derive(Clone, Copy)]
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
        let owner = self.bricks.owners[self.index as usize] as usize;
        self.bricks.table.cell(owner / CELLS) + inner_cell(owner % CELLS)
    }

    /// Its box in the scene's unit: its first sample stands at the least corner, its last at the greatest.
    pub fn aabb(&self) -> Aabb {
        self.bricks.layout.cell_box(self.cell())
    }

    /// Samples along each side: one more than voxels.
    pub fn side(&self) -> u32 {
        self.bricks.layout.brick + 1
    }

    /// Where the nth sample stands, x fastest, in the scene's unit.
    pub fn place(&self, nth: usize) -> Vec3 {
        let (side, nth) = (self.side(), nth as u32);
        let inner: UVec3 = uvec3(nth % side, nth / side % side, nth / side / side);
        let lattice = &self.bricks.layout.lattice;
        let first = self.cell() * self.bricks.layout.brick as i32;
        lattice.corner + lattice.voxel * (first + inner.as_ivec3()).as_vec3()
    }

    /// Its samples as distances in the scene's unit, x fastest. Within the band they are the field's, rounded to what is stored; at its
    /// end they are cut off.
    pub fn distances(&self) -> impl ExactSizeIterator<Item = f32> + '_ {
        let layout = &self.bricks.layout;
        let count = layout.brick_samples() as usize;
        let first = self.index as usize * count;
        let range = layout.encoding.range_length(&layout.lattice, 0);
        let unit = range / self.bricks.pool.bits().quanta() as f32;
        (first..first + count).map(move |at| unit * self.integer(at))
    }

    fn integer(&self, at: usize) -> f32 {
        let pool = &self.bricks.pool;
        match pool.bits() {
            Bits::Eight => pool.of::<i8>().map_or(0.0, |all| all[at].integer()),
            Bits::Sixteen => pool.of::<i16>().map_or(0.0, |all| all[at].integer()),
        }
    }
}
