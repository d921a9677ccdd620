//! Reads bricks at many points at once, in plain loops over lanes, which the compiler turns into SIMD.
//!
//! *Practice.* Only loads run lane by lane, and none waits for another. Lanes in empty cells load from the pool's
//! first brick, which costs less than a branch.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::cell::{center_of, is_brick};
use super::table::{BlockTable, FAR_ENTRY, FAR_SLOTS};
use super::{BLOCK_SIDE, BrickLayout, Bricks};
use crate::mip_sampler::pair_at;
use crate::{CellLocations, NeighborPlanes, Texel, VoxelSamples};
use argil_field::LANES;
use glam::IVec3;

/// Bricks, ready to be sampled.
#[derive(Debug)]
pub struct BrickSampler<'a, T> {
    pub(super) bricks: &'a Bricks,
    pub(super) words: &'a [u32],
    pub(super) pool: &'a [T],
    pub(super) layout: BrickLayout,
    /// The box in voxels, and its first and last cells.
    pub(super) begin: [f32; 3],
    pub(super) end: [f32; 3],
    pub(super) low: [f32; 3],
    pub(super) last: [f32; 3],
    /// From the first cell to the first cell of the table.
    to_table: [u32; 3],
    /// Entries of the table's top, and levels below it.
    top: [u32; 3],
    pub(super) levels: u32,
    entries: &'a [u32],
    /// Number of bricks.
    count: u32,
    /// The distance that one code step means.
    pub(super) quantum: f32,
    /// How much a distance can change over a voxel's edge.
    steepness: f32,
}

/// Converts a whole number from 0 to below 2³¹.
///
/// # Safety
/// `v` must be in that range. A fraction is cut off.
#[inline(always)]
unsafe fn whole(v: f32) -> u32 {
    // SAFETY: as is asked for.
    (unsafe { v.to_int_unchecked::<i32>() }) as u32
}

#[inline(always)]
pub(super) fn low(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl<'a, T: Texel> BrickSampler<'a, T> {
    /// Creates a sampler. Returns `None` if the samples have another type.
    pub fn new(bricks: &'a Bricks) -> Option<Self> {
        let layout = *bricks.layout();
        let encoding = &layout.encoding;
        let table = bricks.table();
        let (table_low, top) = table.top();
        let (low, high) = (layout.first_cell(), layout.end_cell());
        let to_table = low - table_low * BLOCK_SIDE as i32;
        let blocks = top.as_ivec3() * (1 << (3 * table.levels()));
        let reach = high - low + to_table;
        // Reads without bounds checks stay within the tables.
        let is_held = to_table.cmpge(IVec3::ZERO).all()
            && reach.cmple(blocks * BLOCK_SIDE as i32).all()
            && bricks.words().len() >= table.slots() * 64;
        let pool = bricks.pool().of::<T>()?;
        let samples = layout.brick_samples() as usize;
        let is_held = is_held && pool.len() >= bricks.len().max(1) * samples;
        let end = layout.voxel_grid.begin + layout.voxel_grid.size.as_ivec3();
        is_held.then(|| Self {
            bricks,
            words: bricks.words(),
            pool,
            quantum: encoding.band_width(&layout.voxel_grid, 0) / encoding.format.max_code() as f32,
            steepness: 1.000_01 * bricks.lipschitz() * layout.voxel_grid.voxel_size,
            begin: layout.voxel_grid.begin.as_vec3().to_array(),
            end: end.as_vec3().to_array(),
            low: low.as_vec3().to_array(),
            last: (high - 1).as_vec3().to_array(),
            to_table: to_table.as_uvec3().to_array(),
            top: top.to_array(),
            levels: table.levels(),
            entries: table.entries(),
            count: bricks.len() as u32,
            layout,
        })
    }

    /// Whether empty space is known in cubes larger than blocks.
    #[inline(always)]
    pub fn has_levels(&self) -> bool {
        self.levels > 0
    }

    /// Returns the cells along the side of the empty cube that contains a lane's cell. The cube is aligned to its
    /// size. 0 if there is a block.
    #[inline(always)]
    pub fn empty_cells(&self, at: &CellLocations, i: usize) -> u32 {
        let slot = at.index[i] / 64;
        if slot < FAR_SLOTS {
            BlockTable::far_cells(slot)
        } else {
            0
        }
    }

    /// Returns a lower bound of the signed distance for a lane in a cell without a brick: the center's, minus what
    /// the way can change.
    #[inline(always)]
    pub fn empty_cell_distance(&self, at: &CellLocations, i: usize) -> f32 {
        let center = center_of(at.word[i]);
        let half = 0.5 * self.layout.brick_size_voxels as f32;
        let (x, y, z) = (
            at.inner[0][i] - half,
            at.inner[1][i] - half,
            at.inner[2][i] - half,
        );
        let left = center.abs() - self.steepness * (x * x + y * y + z * z).sqrt();
        // Never quite 0, so that the sign survives.
        let left = if left > 1e-30 { left } else { 1e-30 };
        if center < 0.0 { -left } else { left }
    }

    /// Returns the layout of cells and bricks.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// Returns the distance that one code step means.
    pub fn quantum(&self) -> f32 {
        self.quantum
    }

    /// Finds the cells of points, in voxels from the box's corner. Points outside count as the nearest ones inside.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn locate(&self, points: [&[f32]; 3], out: &mut CellLocations) {
        let n = points[0].len();
        assert!(n <= LANES && points[1].len() == n && points[2].len() == n);
        let brick = self.layout.brick_size_voxels as f32;
        let per_cell = 1.0 / brick;
        for axis in 0..3 {
            let (begin, end) = (self.begin[axis], self.end[axis]);
            let (first, last) = (self.low[axis], self.last[axis]);
            let count = last - first;
            let (cells, inner) = (&mut out.cell[axis], &mut out.inner[axis]);
            for i in 0..n {
                let u = points[axis][i];
                // NaN becomes the first position.
                let u = if u > begin { u } else { begin };
                let u = low(u, end);
                let place = u * per_cell - first;
                let place = if place > 0.0 { place } else { 0.0 };
                // SAFETY: it is held between 0 and the number of cells along the axis.
                let place = unsafe { whole(low(place, count)) } as f32;
                let cell = place + first;
                cells[i] = cell;
                inner[i] = u - cell * brick;
            }
        }
        let [tx, ty, tz] = self.to_table;
        let [fx, fy, fz] = self.low;
        let [nx, ny, _] = self.top;
        let shift = 3 * self.levels;
        // From the table's first cell on.
        let mut place = [[0u32; LANES]; 3];
        for i in 0..n {
            // SAFETY: each is a whole number between 0 and the number of cells along the axis.
            let (x, y, z) = unsafe {
                (
                    whole(out.cell[0][i] - fx) + tx,
                    whole(out.cell[1][i] - fy) + ty,
                    whole(out.cell[2][i] - fz) + tz,
                )
            };
            let (bx, by, bz) = (
                (x / BLOCK_SIDE) >> shift,
                (y / BLOCK_SIDE) >> shift,
                (z / BLOCK_SIDE) >> shift,
            );
            out.index[i] = bx + nx * (by + ny * bz);
            (place[0][i], place[1][i], place[2][i]) = (x, y, z);
        }
        for i in 0..n {
            // SAFETY: the table holds the box, and each coordinate is in that.
            out.index[i] = unsafe { *self.entries.get_unchecked(out.index[i] as usize) };
        }
        for level in (0..self.levels).rev() {
            for i in 0..n {
                let [x, y, z] =
                    [0, 1, 2].map(|axis| ((place[axis][i] / BLOCK_SIDE) >> (3 * level)) & 7);
                let entry = out.index[i];
                let is_far = entry & FAR_ENTRY != 0;
                let next = if is_far {
                    0
                } else {
                    entry + x + 8 * y + 64 * z
                };
                // SAFETY: an entry above the last level is where 8³ others begin.
                let next = unsafe { *self.entries.get_unchecked(next as usize) };
                out.index[i] = if is_far { entry } else { next };
            }
        }
        for i in 0..n {
            let (x, y, z) = (place[0][i], place[1][i], place[2][i]);
            let slot = out.index[i] & !FAR_ENTRY;
            out.index[i] =
                slot * 64 + x % BLOCK_SIDE + 4 * (y % BLOCK_SIDE) + 16 * (z % BLOCK_SIDE);
        }
        for i in 0..n {
            // SAFETY: each slot that the table names has 64 words.
            out.word[i] = unsafe { *self.words.get_unchecked(out.index[i] as usize) };
        }
    }

    /// Loads the corner samples of the voxels that contain the points. The result is arbitrary for points in cells
    /// without a brick.
    ///
    /// # Panics
    /// If `n` exceeds [`LANES`].
    #[inline(always)]
    pub fn voxel_samples(&self, at: &CellLocations, n: usize, out: &mut VoxelSamples) {
        let side = self.layout.brick_size_voxels;
        load_voxels(self.pool, (self.count, side), at, n, out);
    }

    /// Loads the samples beyond the faces of a lane's voxel that are nearest to a position in it, from its own
    /// brick or a neighbor's.
    #[inline(always)]
    pub fn neighbor_planes(
        &self,
        at: &CellLocations,
        corners: &VoxelSamples,
        i: usize,
        fraction: [f32; 3],
        out: &mut NeighborPlanes,
    ) {
        let neighbor = |axis: usize, goes_up: bool| self.neighbor(at, i, axis, goes_up);
        let side = self.layout.brick_size_voxels;
        load_planes(
            self.pool, side, at.word[i], corners, i, fraction, neighbor, out,
        );
    }

    /// Returns the brick of the cell next to a lane's.
    #[inline(always)]
    fn neighbor(&self, at: &CellLocations, i: usize, axis: usize, goes_up: bool) -> Option<u32> {
        let mut cell = IVec3::new(
            at.cell[0][i] as i32,
            at.cell[1][i] as i32,
            at.cell[2][i] as i32,
        );
        cell[axis] += if goes_up { 1 } else { -1 };
        let is_held = cell[axis] as f32 >= self.low[axis] && cell[axis] as f32 <= self.last[axis];
        if !is_held {
            return None;
        }
        let word = *self.words.get(self.bricks.word_index(cell))?;
        is_brick(word).then_some(word)
    }
}

/// Loads the corner samples of the voxels that contain points of cells, from bricks of `side` voxels.
///
/// # Panics
/// If `n` exceeds [`LANES`].
#[inline(always)]
pub(crate) fn load_voxels<T: Texel>(
    pool: &[T],
    (count, side): (u32, u32),
    at: &CellLocations,
    n: usize,
    out: &mut VoxelSamples,
) {
    assert!(n <= LANES);
    let last = (side - 1) as f32;
    let side = side + 1;
    let samples = side * side * side;
    for axis in 0..3 {
        let (voxels, fractions) = (&mut out.voxel[axis], &mut out.fraction[axis]);
        for i in 0..n {
            let inner = at.inner[axis][i];
            let inner = if inner > 0.0 { inner } else { 0.0 };
            // SAFETY: it is held between 0 and the last voxel.
            let voxel = unsafe { whole(low(inner, last)) } as f32;
            voxels[i] = voxel;
            fractions[i] = inner - voxel;
        }
    }
    for i in 0..n {
        // SAFETY: they are what was made of them just now.
        let (x, y, z) = unsafe {
            (
                whole(out.voxel[0][i]),
                whole(out.voxel[1][i]),
                whole(out.voxel[2][i]),
            )
        };
        // A word that names a missing brick counts as none, because words may come from a file.
        let brick = if at.word[i] < count { at.word[i] } else { 0 };
        out.start[i] = brick * samples + x + side * (y + side * z);
    }
    for (k, pairs) in out.pairs.iter_mut().enumerate() {
        let step = [0, side, side * side, side * side + side][k];
        for i in 0..n {
            // SAFETY: the brick is there, and a voxel below the brick's side has samples above it.
            pairs[i] = unsafe { pair_at(pool, (out.start[i] + step) as usize) };
        }
    }
}

/// Loads the samples beyond the faces of a lane's voxel that are nearest to a position in it, from its brick or that
/// of the neighbor along an axis, upward or downward.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one lane of many arrays")]
pub(crate) fn load_planes<T: Texel>(
    pool: &[T],
    side: u32,
    brick: u32,
    corners: &VoxelSamples,
    i: usize,
    fraction: [f32; 3],
    neighbor: impl Fn(usize, bool) -> Option<u32>,
    out: &mut NeighborPlanes,
) {
    let last = side - 1;
    let side = side + 1;
    let samples = side * side * side;
    let strides = [1, side, side * side];
    for axis in 0..3 {
        let stride = strides[axis];
        let goes_up = fraction[axis] >= 0.5;
        let voxel = corners.voxel[axis][i] as u32;
        let is_outside = if goes_up { voxel == last } else { voxel == 0 };
        let start = corners.start[i];
        let first = if !is_outside {
            Some(if goes_up {
                start + 2 * stride
            } else {
                start - stride
            })
        } else {
            neighbor(axis, goes_up).map(|beside| {
                // The same position in the neighbor, one plane from the common face.
                let own = brick * samples;
                let inner = start - own - voxel * stride;
                let plane = if goes_up { 1 } else { last };
                beside * samples + inner + plane * stride
            })
        };
        out.is_there[axis][i] = if first.is_some() { 1.0 } else { 0.0 };
        let first = first.unwrap_or(start);
        let (a, b) = (
            strides[(axis == 0) as usize],
            strides[2 - (axis == 2) as usize],
        );
        for (k, step) in [0, a, b, a + b].into_iter().enumerate() {
            // Bricks end where voxels do, so all four are in the brick.
            let sample = pool.get((first + step) as usize);
            out.plane[axis][k][i] = sample.map_or(0.0, |s| s.code());
        }
    }
}
