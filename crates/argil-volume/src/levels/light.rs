//! Distances far from surfaces, and materials, for light.
//!
//! *Theory.* A brick stores distances up to its band, which is a number of its own voxels. So the finest level that
//! has a brick at a point in the air has voxels in proportion to the distance: the relative error is bounded, however
//! far the surface is.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::page::{NO_PAGE, PAGE_VOXELS_LOG2, octant_place};
use super::requests::PageAim;
use super::sampler::{LevelLanes, LevelSampler};
use crate::{MISSING_BRICK, Texel, is_brick};
use argil_abi::GpuMaterial;
use argil_field::LANES;
use glam::{IVec3, Vec3};

impl<T: Texel> LevelSampler<'_, T> {
    /// Finds the finest bricks at points, on some levels or coarser ones: see [`LevelSampler::locate`]. A point in a
    /// cell without a surface gets the brick of the coarser cell that contains it. Only where the coarsest level has no
    /// brick either, a lane's cell has none.
    #[inline(always)]
    pub fn locate_bricks(&self, points: [&[f32]; 3], wanted: &[u32], out: &mut LevelLanes) {
        self.locate(points, wanted, out);
        for i in 0..wanted.len().min(LANES) {
            if is_brick(out.at.word[i]) {
                continue;
            }
            let above = self.pages[out.page[i] as usize].parent;
            if above == NO_PAGE {
                continue;
            }
            let mut cell = above;
            if self.words[above as usize] == MISSING_BRICK {
                cell = self.levels.resident_above(above);
                out.key[i] = 16 * u64::from(above);
                let page = &self.pages[above as usize / 8];
                let first = octant_place(above % 8) << (PAGE_VOXELS_LOG2 - 1 + page.level);
                out.aim[i] = PageAim {
                    voxel: (IVec3::from(page.origin) + first).to_array(),
                    level: page.level,
                };
                out.gap[i] = (self.levels.level_of(cell) - self.levels.level_of(above)) as f32;
            }
            let point = [0, 1, 2].map(|axis: usize| points[axis][i]);
            self.set_cell(cell, point, i, out);
        }
    }

    /// Returns the stored distance of a cell without a brick, at its center.
    #[inline(always)]
    pub fn center_distance(&self, lanes: &LevelLanes, i: usize) -> f32 {
        crate::bricks::center_of(lanes.at.word[i])
    }

    /// Returns the material at a lane's point, given the outward direction: see
    /// [`Bricks::material`](crate::Bricks::material). Returns `None` if its cell has no brick.
    pub fn material(
        &self,
        lanes: &LevelLanes,
        i: usize,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let inner = Vec3::from_array([0, 1, 2].map(|axis: usize| lanes.at.inner[axis][i]));
        let brick = lanes.at.word[i];
        let store = &self.levels.store;
        is_brick(brick)
            .then(|| store.material_at(brick, inner, self.band_voxels(), 8, outward, palette))?
    }
}
