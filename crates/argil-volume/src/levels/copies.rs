//! What copies of levels on a device need.

use super::page::PAGE_VOXELS_LOG2;
use super::tree::Levels;
use crate::{BrickChanges, Texels};
use glam::{IVec3, Vec3};

impl Levels {
    /// Takes the list of bricks that changed since the last call.
    pub fn take_changes(&mut self) -> BrickChanges {
        let count = self.brick_count() as u32;
        self.store.changes.take(count)
    }

    /// Marks all bricks as changed, for a new copy.
    pub fn mark_all_changed(&mut self) {
        for brick in 0..self.brick_count() as u32 {
            self.store.changes.brick(brick);
        }
    }

    /// Returns each brick's material, and the materials of mixed bricks: see
    /// [`Bricks::materials`](crate::Bricks::materials).
    pub fn brick_materials(&self) -> (&[u32], &[[u32; 2]]) {
        (&self.store.materials, &self.store.mixed)
    }

    /// Returns the same pages with other words, children, and bricks, as a copy has them. Returns `None` if they are
    /// not as many, or samples have another format.
    pub fn with_contents(&self, words: Vec<u32>, children: Vec<u32>, pool: Texels) -> Option<Self> {
        let sizes = [words.len(), children.len(), pool.bytes().len()];
        let own = [
            self.store.words.len(),
            self.children.len(),
            self.store.pool.bytes().len(),
        ];
        if sizes != own || pool.bits() != self.store.pool.bits() {
            return None;
        }
        let mut copy = self.clone();
        (copy.store.words, copy.children, copy.store.pool) = (words, children, pool);
        Some(copy)
    }

    /// Returns by how many levels a cell's page is too coarse for rays from a camera, at least 1, and its distance.
    /// `size` is the edge of a voxel that a ray accepts, at length 1.
    pub fn urgency(&self, cell: u32, eye: Vec3, size: f32) -> (f32, f32) {
        let page = &self.pages[cell as usize / 8];
        let distance = self.layout.page_box(page).distance(eye);
        let voxel = self.layout.level(page.level).voxel_grid.voxel_size;
        let ratio = voxel / (size * distance).max(1e-30);
        (ratio.log2().floor().max(1.0), distance)
    }

    /// Returns the first and the last voxel of level 0 that pages cover, within what an integer counts.
    pub fn voxel_range(&self) -> (IVec3, IVec3) {
        let side = PAGE_VOXELS_LOG2 + self.layout.root();
        let held = |page: i32| (i64::from(page) << side).clamp(-(1 << 30), (1 << 30) - 1) as i32;
        let end = self.root_low + self.root_size;
        let (low, high) = (self.root_low.to_array(), end.to_array());
        (
            IVec3::from_array(low.map(held)),
            IVec3::from_array(high.map(held)) - 1,
        )
    }
}
