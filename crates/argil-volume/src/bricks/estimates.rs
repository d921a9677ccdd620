//! Reads distances from bricks at any point.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::BLOCK_SIDE;
use super::cell::{center_of, is_brick};
use crate::bricks::sampler::low;
use crate::{BrickSampler, CellLocations, LevelLanes, LevelSampler, Texel, VoxelSamples};
use argil_field::LANES;
use glam::IVec3;

/// The part of the band up to which an interpolated sample is a distance. Beyond it, some corner may be clamped.
const KNOWN: f32 = argil_abi::LIGHT_KNOWN;

/// Buffers for [`BrickSampler::estimates`], kept from batch to batch. They hold nothing that lasts.
#[derive(Debug, Default)]
pub struct EstimateLanes {
    at: CellLocations,
    corners: VoxelSamples,
    levels: LevelLanes,
}

impl<T: Texel> BrickSampler<'_, T> {
    /// Estimates the signed distances at points in the scene's space: interpolated in bricks, and elsewhere read from
    /// coarse levels, or interpolated between cell centers. A sample at the end of the band is no distance. Beyond the
    /// box, the way to it is added. For light, not for steps.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn estimates<L: Texel>(
        &self,
        points: [&[f32]; 3],
        light: Option<&LevelSampler<'_, L>>,
        lanes: &mut EstimateLanes,
        out: &mut [f32],
    ) {
        let n = out.len();
        assert!(n <= LANES && points.iter().all(|p| p.len() == n));
        let voxel_grid = &self.layout.voxel_grid;
        let per_voxel = 1.0 / voxel_grid.voxel_size;
        let mut u = [[0.0f32; LANES]; 3];
        let mut beside = [0.0f32; LANES];
        for (axis, from) in points.into_iter().enumerate() {
            let corner = voxel_grid.corner[axis];
            let (begin, end) = (self.begin[axis], self.end[axis]);
            for i in 0..n {
                let own = (from[i] - corner) * per_voxel;
                let held = low(if own > begin { own } else { begin }, end);
                u[axis][i] = held;
                beside[i] += (own - held) * (own - held);
            }
        }
        let EstimateLanes {
            at,
            corners,
            levels,
        } = lanes;
        self.locate([&u[0][..n], &u[1][..n], &u[2][..n]], at);
        self.voxel_samples(at, n, corners);
        for i in 0..n {
            out[i] = corners.value::<T>(i) * self.quantum;
        }
        match light {
            None => {
                for i in 0..n {
                    if !is_brick(at.word[i]) {
                        out[i] = self.between_centers([u[0][i], u[1][i], u[2][i]]);
                    }
                }
            }
            Some(light) => {
                let known = KNOWN * self.quantum * self.layout.encoding.format.max_code() as f32;
                let mut which = [0usize; LANES];
                let mut count = 0;
                for i in 0..n {
                    if !is_brick(at.word[i]) || out[i].abs() > known {
                        which[count] = i;
                        count += 1;
                    }
                }
                self.read_light(light, (levels, corners), &u, &which[..count], out);
            }
        }
        for i in 0..n {
            out[i] += beside[i].sqrt() * voxel_grid.voxel_size;
        }
    }

    /// Reads some lanes' distances from levels. Positions are in voxels.
    #[inline(always)]
    fn read_light<L: Texel>(
        &self,
        light: &LevelSampler<'_, L>,
        (lanes, corners): (&mut LevelLanes, &mut VoxelSamples),
        u: &[[f32; LANES]; 3],
        which: &[usize],
        out: &mut [f32],
    ) {
        let n = which.len();
        if n == 0 {
            return;
        }
        let voxel_grid = &self.layout.voxel_grid;
        let mut p = [[0.0f32; LANES]; 3];
        for axis in 0..3 {
            for (p, &i) in p[axis].iter_mut().zip(which) {
                let place = voxel_grid.corner[axis] + u[axis][i] * voxel_grid.voxel_size;
                *p = light.position(axis, place);
            }
        }
        light.set_starts([&p[0][..n], &p[1][..n], &p[2][..n]], lanes);
        light.locate_bricks(
            [&p[0][..n], &p[1][..n], &p[2][..n]],
            &[0; LANES][..n],
            lanes,
        );
        light.voxel_samples(&lanes.at, n, corners);
        for (k, &i) in which.iter().enumerate() {
            out[i] = if is_brick(lanes.at.word[k]) {
                corners.value::<L>(k) * light.quantum() * lanes.voxel[k]
            } else {
                light.center_distance(lanes, k)
            };
        }
    }

    /// Interpolates between the centers of the eight nearest cells.
    fn between_centers(&self, u: [f32; 3]) -> f32 {
        let per_cell = 1.0 / self.layout.brick_size_voxels as f32;
        let mut low_cell = [0.0f32; 3];
        let mut share = [0.0f32; 3];
        for axis in 0..3 {
            let (first, last) = (self.low[axis], self.last[axis]);
            let place = (u[axis] * per_cell - 0.5).clamp(first, last);
            let begin = low(place.floor(), (last - 1.0).max(first));
            low_cell[axis] = begin;
            share[axis] = place - begin;
        }
        let mut total = 0.0;
        for corner in 0..8u32 {
            let mut cell = low_cell;
            let mut weight = 1.0;
            for axis in 0..3 {
                let is_far = corner >> axis & 1 != 0;
                let step = if is_far { 1.0 } else { 0.0 };
                cell[axis] = low(cell[axis] + step, self.last[axis]);
                weight *= if is_far {
                    share[axis]
                } else {
                    1.0 - share[axis]
                };
            }
            if weight > 0.0 {
                total += weight * self.at_center(IVec3::from_array(cell.map(|c| c as i32)));
            }
        }
        total
    }

    /// Returns the distance at a cell's center.
    fn at_center(&self, cell: IVec3) -> f32 {
        let word = self.words[self.bricks.word_index(cell)];
        if !is_brick(word) {
            return center_of(word);
        }
        let (half, side) = (
            self.layout.brick_size_voxels / 2,
            self.layout.brick_size_voxels + 1,
        );
        let middle = half * (1 + side * (1 + side));
        let sample = self.pool[(word * self.layout.brick_samples() + middle) as usize];
        sample.code() * self.quantum
    }

    /// Computes the signed distances at points in the scene's space: interpolated in bricks, and stored bounds
    /// elsewhere. `margin` is subtracted from the length of interpolated ones.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn distances(&self, [x, y, z]: [&[f32]; 3], margin: f32, out: &mut [f32]) {
        let n = out.len();
        assert!(n <= LANES && x.len() == n && y.len() == n && z.len() == n);
        let (corner, per_voxel) = (
            self.layout.voxel_grid.corner,
            1.0 / self.layout.voxel_grid.voxel_size,
        );
        let mut u = [[0.0f32; LANES]; 3];
        for (axis, from) in [x, y, z].into_iter().enumerate() {
            for i in 0..n {
                u[axis][i] = (from[i] - corner[axis]) * per_voxel;
            }
        }
        let (mut at, mut corners) = (CellLocations::default(), VoxelSamples::default());
        self.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
        self.voxel_samples(&at, n, &mut corners);
        for i in 0..n {
            let d = corners.value::<T>(i) * self.quantum;
            let word = at.word[i];
            let length = d.abs() - margin;
            let length = if length > 0.0 { length } else { 0.0 };
            let shorter = if d < 0.0 { -length } else { length };
            out[i] = if is_brick(word) {
                shorter
            } else {
                self.empty_cell_distance(&at, i)
            };
        }
        if self.levels > 0 {
            self.add_ways_out([&u[0][..n], &u[1][..n], &u[2][..n]], &at, out);
        }
    }

    /// In a large empty cube, adds the way out of the cube to the stored bound.
    fn add_ways_out(&self, u: [&[f32]; 3], at: &CellLocations, out: &mut [f32]) {
        for i in 0..out.len() {
            let cells = self.empty_cells(at, i);
            if cells <= BLOCK_SIDE {
                continue;
            }
            let edge = (cells * self.layout.brick_size_voxels) as f32;
            let mut way = edge;
            for axis in 0..3 {
                let begin = (u[axis][i] / edge).floor() * edge;
                way = low(way, low(u[axis][i] - begin, begin + edge - u[axis][i]));
            }
            let way = if way > 0.0 { way } else { 0.0 } * self.layout.voxel_grid.voxel_size;
            let d = center_of(at.word[i]);
            out[i] = if d < 0.0 { d - way } else { d + way };
        }
    }
}
