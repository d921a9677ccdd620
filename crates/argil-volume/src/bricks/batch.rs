//! Bricks read for many points at once, in plain loops over lanes that the compiler turns into SIMD.
//!
//! *Practice.* As in the crate's other batches, only loads are done lane by lane, and none waits for another. Lanes in empty
//! cells load from the pool's first brick, which costs less than a branch.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::words::{center_of, is_brick};
use super::{BLOCK_SIDE, BrickLayout, Bricks};
use crate::Texel;
use crate::batch::{pair_at, unpacked};
use argil_field::LANES;
use glam::UVec3;

/// Bricks, ready to be sampled.
pub struct BrickSampler<'a, T> {
    words: &'a [u32],
    pool: &'a [T],
    layout: BrickLayout,
    /// The length that an integer of 1 stands for.
    quantum: f32,
    /// By how much a distance can change over a voxel's edge.
    steepness: f32,
}

/// Where points lie: their cell, its word, and the place in it in voxels.
pub struct Located {
    /// The cell's place along each axis.
    pub cell: [[f32; LANES]; 3],
    /// From the cell's least corner, 0 to the brick's side.
    pub inner: [[f32; LANES]; 3],
    /// What is in the cell.
    pub word: [u32; LANES],
    /// Where the word stands.
    pub index: [u32; LANES],
}

impl Default for Located {
    fn default() -> Self {
        Self {
            cell: [[0.0; LANES]; 3],
            inner: [[0.0; LANES]; 3],
            word: [0; LANES],
            index: [0; LANES],
        }
    }
}

/// The samples at a voxel's corners, two neighbours along x in each word, and where in the voxel a point is.
pub struct Corners {
    pub(crate) pairs: [[u32; LANES]; 4],
    /// The voxel's place in its brick.
    pub voxel: [[f32; LANES]; 3],
    /// From the voxel's least corner, 0 to 1.
    pub fraction: [[f32; LANES]; 3],
    /// Where the voxel's first sample stands.
    start: [u32; LANES],
}

/// Beyond the face of a voxel that is nearest along each axis: the next plane of samples, four each, and 1 for whether they
/// are there.
pub struct Beyond {
    /// By axis: first along the lower of the other two axes.
    pub plane: [[[f32; LANES]; 4]; 3],
    /// By axis.
    pub is_there: [[f32; LANES]; 3],
}

impl Default for Beyond {
    fn default() -> Self {
        Self {
            plane: [[[0.0; LANES]; 4]; 3],
            is_there: [[0.0; LANES]; 3],
        }
    }
}

impl Default for Corners {
    fn default() -> Self {
        Self {
            pairs: [[0; LANES]; 4],
            voxel: [[0.0; LANES]; 3],
            fraction: [[0.0; LANES]; 3],
            start: [0; LANES],
        }
    }
}

/// Whole numbers below 2¹³.
#[inline(always)]
fn whole(v: f32) -> u32 {
    // SAFETY: callers clamp to a grid's indices.
    (unsafe { v.to_int_unchecked::<i32>() }) as u32
}

#[inline(always)]
fn low(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl<'a, T: Texel> BrickSampler<'a, T> {
    /// Over bricks whose samples are of this type; `None` for others.
    pub fn new(bricks: &'a Bricks) -> Option<Self> {
        let layout = *bricks.layout();
        let encoding = &layout.encoding;
        Some(Self {
            words: bricks.words(),
            pool: bricks.pool().of()?,
            quantum: encoding.range_length(&layout.lattice, 0) / encoding.bits.quanta() as f32,
            steepness: 1.000_01 * bricks.lipschitz() * layout.lattice.voxel,
            layout,
        })
    }

    /// Of a lane in a cell without a brick, the signed distance that it does not fall short of: that of the cell's centre,
    /// less what it can be on the way.
    #[inline(always)]
    pub fn away(&self, at: &Located, i: usize) -> f32 {
        let center = center_of(at.word[i]);
        let half = 0.5 * self.layout.brick as f32;
        let (x, y, z) = (
            at.inner[0][i] - half,
            at.inner[1][i] - half,
            at.inner[2][i] - half,
        );
        let left = center.abs() - self.steepness * (x * x + y * y + z * z).sqrt();
        // Never quite 0, so that the sign stays.
        let left = if left > 1e-30 { left } else { 1e-30 };
        if center < 0.0 { -left } else { left }
    }

    /// Where cells and bricks lie.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// The length that an integer of 1 stands for.
    pub fn quantum(&self) -> f32 {
        self.quantum
    }

    /// The cells of points of the box in voxels from its corner; points outside count as the nearest ones in it.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn locate(&self, points: [&[f32]; 3], out: &mut Located) {
        let n = points[0].len();
        assert!(n <= LANES && points[1].len() == n && points[2].len() == n);
        let brick = self.layout.brick as f32;
        let per_cell = 1.0 / brick;
        for axis in 0..3 {
            let last = (self.layout.grid[axis] - 1) as f32;
            let size = self.layout.lattice.size[axis] as f32;
            let (cells, inner) = (&mut out.cell[axis], &mut out.inner[axis]);
            for i in 0..n {
                let u = points[axis][i];
                // Not a number becomes 0.
                let u = if u > 0.0 { u } else { 0.0 };
                let u = low(u, size);
                let cell = low(whole(u * per_cell) as f32, last);
                cells[i] = cell;
                inner[i] = u - cell * brick;
            }
        }
        let [nx, ny, _] = self.layout.blocks.to_array();
        for i in 0..n {
            let (x, y, z) = (
                whole(out.cell[0][i]),
                whole(out.cell[1][i]),
                whole(out.cell[2][i]),
            );
            let block = (x / BLOCK_SIDE) + nx * ((y / BLOCK_SIDE) + ny * (z / BLOCK_SIDE));
            out.index[i] =
                block * 64 + x % BLOCK_SIDE + 4 * (y % BLOCK_SIDE) + 16 * (z % BLOCK_SIDE);
        }
        for i in 0..n {
            // SAFETY: each coordinate is below the grid's, whose cells all have a word.
            out.word[i] = unsafe { *self.words.get_unchecked(out.index[i] as usize) };
        }
    }

    /// The corners of the voxels that points lie in; of points in cells without a brick, anything.
    #[inline(always)]
    pub fn corners(&self, at: &Located, n: usize, out: &mut Corners) {
        assert!(n <= LANES);
        let last = (self.layout.brick - 1) as f32;
        let side = self.layout.brick + 1;
        let samples = self.layout.brick_samples();
        for axis in 0..3 {
            let (voxels, fractions) = (&mut out.voxel[axis], &mut out.fraction[axis]);
            for i in 0..n {
                let inner = at.inner[axis][i];
                let inner = if inner > 0.0 { inner } else { 0.0 };
                let voxel = low(whole(low(inner, last)) as f32, last);
                voxels[i] = voxel;
                fractions[i] = inner - voxel;
            }
        }
        for i in 0..n {
            let (x, y, z) = (
                whole(out.voxel[0][i]),
                whole(out.voxel[1][i]),
                whole(out.voxel[2][i]),
            );
            let brick = if is_brick(at.word[i]) { at.word[i] } else { 0 };
            out.start[i] = brick * samples + x + side * (y + side * z);
        }
        for (k, pairs) in out.pairs.iter_mut().enumerate() {
            let step = [0, side, side * side, side * side + side][k];
            for i in 0..n {
                // SAFETY: words name bricks that are there, and a voxel below the brick's side has samples above it.
                pairs[i] =
                    unsafe { pair_at(self.pool.as_ptr().add((out.start[i] + step) as usize)) };
            }
        }
    }

    /// The samples beyond the faces of a lane's voxel that are nearest to a place in it: in its own brick, or in the
    /// neighbour's where there is one.
    #[inline(always)]
    pub fn beyond(
        &self,
        at: &Located,
        corners: &Corners,
        i: usize,
        fraction: [f32; 3],
        out: &mut Beyond,
    ) {
        let side = self.layout.brick + 1;
        let strides = [1, side, side * side];
        let last = self.layout.brick - 1;
        for axis in 0..3 {
            let stride = strides[axis];
            let goes_up = fraction[axis] >= 0.5;
            let voxel = whole(corners.voxel[axis][i]);
            let is_outside = if goes_up { voxel == last } else { voxel == 0 };
            let start = corners.start[i];
            let first = if !is_outside {
                Some(if goes_up {
                    start + 2 * stride
                } else {
                    start - stride
                })
            } else {
                self.neighbour(at, i, axis, goes_up).map(|brick| {
                    // The same place in the neighbour, one plane from the common face.
                    let own = at.word[i] * self.layout.brick_samples();
                    let inner = start - own - voxel * stride;
                    let plane = if goes_up { 1 } else { last };
                    brick * self.layout.brick_samples() + inner + plane * stride
                })
            };
            out.is_there[axis][i] = if first.is_some() { 1.0 } else { 0.0 };
            let first = first.unwrap_or(start);
            let (a, b) = (
                strides[(axis == 0) as usize],
                strides[2 - (axis == 2) as usize],
            );
            for (k, step) in [0, a, b, a + b].into_iter().enumerate() {
                // Bricks end where voxels do: all four are in the brick.
                let sample = self.pool.get((first + step) as usize);
                out.plane[axis][k][i] = sample.map_or(0.0, |s| s.integer());
            }
        }
    }

    /// The brick of the cell beside a lane's.
    #[inline(always)]
    fn neighbour(&self, at: &Located, i: usize, axis: usize, goes_up: bool) -> Option<u32> {
        let mut cell = [
            whole(at.cell[0][i]),
            whole(at.cell[1][i]),
            whole(at.cell[2][i]),
        ];
        cell[axis] = if goes_up {
            cell[axis] + 1
        } else {
            cell[axis].checked_sub(1)?
        };
        if cell[axis] >= self.layout.grid[axis] {
            return None;
        }
        let word = *self.words.get(self.layout.word_index(cell.into()))?;
        is_brick(word).then_some(word)
    }

    /// The signed distances at points in the world as nearly as they are known: interpolated in bricks, elsewhere between
    /// cells' centres; beyond the box, as much more as the way to it. For light, not for steps.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn estimates(&self, points: [&[f32]; 3], out: &mut [f32]) {
        let n = out.len();
        assert!(n <= LANES && points.iter().all(|p| p.len() == n));
        let lattice = &self.layout.lattice;
        let per_voxel = 1.0 / lattice.voxel;
        let mut u = [[0.0f32; LANES]; 3];
        let mut beside = [0.0f32; LANES];
        for (axis, from) in points.into_iter().enumerate() {
            let (corner, size) = (lattice.corner[axis], lattice.size[axis] as f32);
            for i in 0..n {
                let own = (from[i] - corner) * per_voxel;
                let held = low(if own > 0.0 { own } else { 0.0 }, size);
                u[axis][i] = held;
                beside[i] += (own - held) * (own - held);
            }
        }
        let (mut at, mut corners) = (Located::default(), Corners::default());
        self.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
        self.corners(&at, n, &mut corners);
        for i in 0..n {
            let d = if is_brick(at.word[i]) {
                corners.value::<T>(i) * self.quantum
            } else {
                self.between_centers([u[0][i], u[1][i], u[2][i]])
            };
            out[i] = d + beside[i].sqrt() * lattice.voxel;
        }
    }

    /// Interpolated between the centres of the eight nearest cells.
    fn between_centers(&self, u: [f32; 3]) -> f32 {
        let per_cell = 1.0 / self.layout.brick as f32;
        let mut low_cell = [0u32; 3];
        let mut share = [0.0f32; 3];
        for axis in 0..3 {
            let last = (self.layout.grid[axis] - 1) as f32;
            let place = (u[axis] * per_cell - 0.5).clamp(0.0, last);
            let begin = low(place.floor(), (last - 1.0).max(0.0));
            low_cell[axis] = whole(begin);
            share[axis] = place - begin;
        }
        let mut total = 0.0;
        for corner in 0..8u32 {
            let mut cell = low_cell;
            let mut weight = 1.0;
            for axis in 0..3 {
                let is_far = corner >> axis & 1 != 0;
                let last = self.layout.grid[axis] - 1;
                cell[axis] = (cell[axis] + u32::from(is_far)).min(last);
                weight *= if is_far {
                    share[axis]
                } else {
                    1.0 - share[axis]
                };
            }
            if weight > 0.0 {
                total += weight * self.at_center(cell.into());
            }
        }
        total
    }

    /// The distance at a cell's centre.
    fn at_center(&self, cell: UVec3) -> f32 {
        let word = self.words[self.layout.word_index(cell)];
        if !is_brick(word) {
            return center_of(word);
        }
        let (half, side) = (self.layout.brick / 2, self.layout.brick + 1);
        let middle = half * (1 + side * (1 + side));
        let sample = self.pool[(word * self.layout.brick_samples() + middle) as usize];
        sample.integer() * self.quantum
    }

    /// The signed distances at points in the world: interpolated in bricks, elsewhere what is stored. `margin` is taken
    /// off the length of those that are interpolated.
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn distances(&self, [x, y, z]: [&[f32]; 3], margin: f32, out: &mut [f32]) {
        let n = out.len();
        assert!(n <= LANES && x.len() == n && y.len() == n && z.len() == n);
        let (corner, per_voxel) = (self.layout.lattice.corner, 1.0 / self.layout.lattice.voxel);
        let mut u = [[0.0f32; LANES]; 3];
        for (axis, from) in [x, y, z].into_iter().enumerate() {
            for i in 0..n {
                u[axis][i] = (from[i] - corner[axis]) * per_voxel;
            }
        }
        let (mut at, mut corners) = (Located::default(), Corners::default());
        self.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
        self.corners(&at, n, &mut corners);
        for i in 0..n {
            let d = corners.value::<T>(i) * self.quantum;
            let word = at.word[i];
            let length = d.abs() - margin;
            let length = if length > 0.0 { length } else { 0.0 };
            let shorter = if d < 0.0 { -length } else { length };
            out[i] = if is_brick(word) {
                shorter
            } else {
                self.away(&at, i)
            };
        }
    }
}

impl Corners {
    /// The eight corners of a lane, x fastest.
    #[inline(always)]
    pub fn integers<T: Texel>(&self, i: usize) -> [f32; 8] {
        let (a, b) = unpacked::<T>(self.pairs[0][i]);
        let (c, d) = unpacked::<T>(self.pairs[1][i]);
        let (e, f) = unpacked::<T>(self.pairs[2][i]);
        let (g, h) = unpacked::<T>(self.pairs[3][i]);
        [a, b, c, d, e, f, g, h]
    }

    /// What is interpolated between a lane's corners.
    #[inline(always)]
    pub fn value<T: Texel>(&self, i: usize) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.integers::<T>(i);
        let (x, y, z) = (
            self.fraction[0][i],
            self.fraction[1][i],
            self.fraction[2][i],
        );
        let (p, q) = (a + (b - a) * x, c + (d - c) * x);
        let (r, s) = (e + (f - e) * x, g + (h - g) * x);
        let (near, far) = (p + (q - p) * y, r + (s - r) * y);
        near + (far - near) * z
    }
}
