//! Distances of a lattice, with those that it does not store.
//!
//! *Theory.* Each voxel next to the surface gives a point of it, along the slope. Within a cell of 8³ voxels, distances are those to
//! the nearest point in the cell and its 26 neighbors, which hold all points nearer than 8 voxels. Each corner of a cell learns its
//! nearest point: first the corners around points, then the others from their neighbors, in sweeps (Danielsson, "Euclidean
//! distance mapping", 1980).

use super::lattice::Lattice;
use argil_scene::{DistanceSampler, SAMPLED_SIDE, SampledBlock};
use glam::{IVec3, Vec3, ivec3};
use multiversion::multiversion;
use rayon::prelude::*;

const SIDE: i32 = SAMPLED_SIDE as i32;
/// Samples along a block's side.
const BLOCK: usize = SAMPLED_SIDE as usize + 1;
/// No point is known.
const NONE: u32 = u32::MAX;
/// By how many voxels the nearest point can be farther than the surface, beyond the band.
const SPACING: f32 = 0.1;
/// Interpolated distances of more voxels are not measured: they are off by at most half of a cell's diagonal.
const FAR: f32 = 16.0;
/// Points that are measured together.
const LANES: usize = 16;

/// Distances at any index in a box of cells.
pub(super) struct Distances<'a> {
    lattice: &'a Lattice,
    /// The first cell, and the number of corners along each axis.
    first: IVec3,
    corners: IVec3,
    /// Points of the surface in voxels from the first cell's corner, cell by cell.
    points: Vec<Vec3>,
    /// For each cell, where its points begin. Cells are counted as their first corners are.
    begins: Vec<u32>,
    /// Unsigned distance at corners, in voxels.
    far: Vec<f32>,
    /// For each cell, whether it has known distances.
    known: Vec<bool>,
}

impl<'a> Distances<'a> {
    pub(super) fn new(lattice: &'a Lattice, first: IVec3, cells: IVec3) -> Self {
        let corners = cells + 1;
        let count = (corners.x * corners.y * corners.z) as usize;
        let mut own = Self {
            lattice,
            first,
            corners,
            points: Vec::new(),
            begins: Vec::new(),
            far: Vec::new(),
            known: vec![false; count],
        };
        let held = |origin: &IVec3| {
            let cell = origin.map(|c| c >> 3) - first;
            cell.min_element() >= 0 && (cell - cells).max_element() < 0
        };
        let boxes: Vec<IVec3> = lattice.known_boxes().into_iter().filter(held).collect();
        for origin in &boxes {
            let place = own.place(origin.map(|c| c >> 3) - first);
            own.known[place] = true;
        }
        let points = |origin: &IVec3| {
            let place = own.place(origin.map(|c| c >> 3) - first) as u32;
            let begin = (*origin - first * SIDE).as_vec3();
            let points = points_in(lattice, *origin);
            points.into_iter().map(move |point| (place, begin + point))
        };
        let mut by_cell: Vec<(u32, Vec3)> = boxes.par_iter().flat_map_iter(points).collect();
        by_cell.sort_by_key(|(place, _)| *place);
        let mut nearest = vec![NONE; count];
        own.points = by_cell.iter().map(|(_, point)| *point).collect();
        own.begins = Vec::with_capacity(count + 1);
        for (nth, &(place, _)) in by_cell.iter().enumerate() {
            while own.begins.len() <= place as usize {
                own.begins.push(nth as u32);
            }
            let cell = own.corner(place as usize);
            for corner in 0..8 {
                let at = cell + ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
                own.offer(&mut nearest, at, nth as u32);
            }
        }
        own.begins.resize(count + 1, by_cell.len() as u32);
        own.sweep(&mut nearest);
        own.far = (0..count)
            .map(|place| own.length(own.corner(place), nearest[place]))
            .collect();
        own
    }

    /// Returns whether any voxel lies next to the surface.
    pub(super) fn has_surface(&self) -> bool {
        !self.points.is_empty()
    }

    fn place(&self, corner: IVec3) -> usize {
        ((corner.z * self.corners.y + corner.y) * self.corners.x + corner.x) as usize
    }

    fn corner(&self, place: usize) -> IVec3 {
        let place = place as i32;
        ivec3(
            place % self.corners.x,
            place / self.corners.x % self.corners.y,
            place / self.corners.x / self.corners.y,
        )
    }

    fn length(&self, corner: IVec3, nth: u32) -> f32 {
        match self.points.get(nth as usize) {
            Some(&point) => (point - (SIDE * corner).as_vec3()).length(),
            None => f32::MAX.sqrt(),
        }
    }

    /// Stores a point at a corner if it is nearer than the one there.
    fn offer(&self, nearest: &mut [u32], corner: IVec3, nth: u32) {
        let own = &mut nearest[self.place(corner)];
        if self.length(corner, nth) < self.length(corner, *own) {
            *own = nth;
        }
    }

    /// Hands points on to neighbors, from both ends, twice.
    fn sweep(&self, nearest: &mut [u32]) {
        let neighbors: Vec<IVec3> = around(IVec3::ZERO)
            .filter(|offset| *offset != IVec3::ZERO)
            .collect();
        let end = self.corners;
        let count = nearest.len();
        for pass in 0..4 {
            for i in 0..count {
                let place = if pass % 2 == 0 { i } else { count - 1 - i };
                let corner = self.corner(place);
                for offset in &neighbors {
                    let at = corner + *offset;
                    if at.min_element() >= 0 && (at - end).max_element() < 0 {
                        let nth = nearest[self.place(at)];
                        if nth != NONE {
                            self.offer(nearest, corner, nth);
                        }
                    }
                }
            }
        }
    }

    /// Returns the index at a point.
    fn index(&self, point: Vec3) -> IVec3 {
        let place = (point - self.lattice.origin) / self.lattice.voxel_size;
        place.round().as_ivec3()
    }

    /// Interpolates between corners, in voxels.
    fn far_at(&self, index: IVec3) -> f32 {
        let at = (index - self.first * SIDE).clamp(IVec3::ZERO, SIDE * (self.corners - 1));
        let cell = (at / SIDE).min(self.corners - 2).max(IVec3::ZERO);
        let t = (at - SIDE * cell).as_vec3() / SIDE as f32;
        let mut sum = 0.0;
        for corner in 0..8 {
            let offset = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
            let share = Vec3::select(offset.cmpgt(IVec3::ZERO), t, 1.0 - t);
            let held = (cell + offset).min(self.corners - 1);
            sum += share.element_product() * self.far[self.place(held)];
        }
        sum
    }

    /// Gives a distance in voxels to a point that has only a sign, or a smaller distance.
    fn signed(&self, voxels: f32, stored: f32) -> f32 {
        let own = (voxels - SPACING) * self.lattice.voxel_size;
        own.max(stored.abs()).copysign(stored)
    }

    /// Returns the points in a cell and its neighbors, each axis for itself, and as many as fill lanes.
    fn points_around(&self, cell: IVec3) -> [Vec<f32>; 3] {
        let mut all: [Vec<f32>; 3] = Default::default();
        for own in around(cell) {
            if own.min_element() < 0 || (own - self.corners).max_element() >= 0 {
                continue;
            }
            let place = self.place(own);
            let [begin, end] = [self.begins[place], self.begins[place + 1]];
            for point in &self.points[begin as usize..end as usize] {
                for (axis, list) in all.iter_mut().enumerate() {
                    list.push(point[axis]);
                }
            }
        }
        for list in &mut all {
            let filled = list.len().next_multiple_of(LANES);
            list.resize(filled, 1e9);
        }
        all
    }
}

/// Returns the points of the surface next to the voxels of a box of 8³, in voxels from its first.
fn points_in(lattice: &Lattice, origin: IVec3) -> Vec<Vec3> {
    // With a voxel around it, for slopes.
    let side = SIDE as usize + 2;
    let mut values = Vec::new();
    lattice.values_in(origin - 1, side, &mut values);
    let mut points = Vec::new();
    for i in 0..SIDE * SIDE * SIDE {
        let inner = ivec3(i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE);
        let at = inner.as_usizevec3() + 1;
        let place = (at.z * side + at.y) * side + at.x;
        let (value, is_known) = values[place];
        if !is_known || value.abs() > lattice.voxel_size {
            continue;
        }
        let slope = [1, side, side * side].map(|stride| {
            let [before, after] = [values[place - stride], values[place + stride]];
            match (before.1, after.1) {
                (true, true) => 0.5 * (after.0 - before.0),
                (true, false) => value - before.0,
                (false, true) => after.0 - value,
                (false, false) => 0.0,
            }
        });
        let slope = Vec3::from(slope).normalize_or_zero();
        points.push(inner.as_vec3() - slope * (value / lattice.voxel_size));
    }
    points
}

/// Returns a cell and its 26 neighbors.
fn around(cell: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |i| cell + ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

/// Returns the distance to the nearest of many points.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn nearest_of(points: &[Vec<f32>; 3], p: Vec3) -> f32 {
    let mut least = [f32::INFINITY; LANES];
    let [x, y, z] = points.each_ref().map(|list| list.as_chunks::<LANES>().0);
    for ((x, y), z) in x.iter().zip(y).zip(z) {
        for lane in 0..LANES {
            let (dx, dy, dz) = (x[lane] - p.x, y[lane] - p.y, z[lane] - p.z);
            let square = dx * dx + dy * dy + dz * dz;
            least[lane] = if square < least[lane] {
                square
            } else {
                least[lane]
            };
        }
    }
    least.into_iter().fold(f32::INFINITY, f32::min).sqrt()
}

impl DistanceSampler for Distances<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        for (point, out) in points.iter().zip(out) {
            let index = self.index(*point);
            let (value, is_known) = self.lattice.value(index);
            *out = match is_known {
                true => value,
                false => self.signed(self.far_at(index), value),
            };
        }
    }

    fn unsigned_distance(&self, point: Vec3) -> f32 {
        let index = self.index(point);
        let cell = index.map(|c| c.div_euclid(SIDE)) - self.first;
        let held = cell.clamp(IVec3::ZERO, self.corners - 1);
        let far = self.far_at(index) * self.lattice.voxel_size;
        match self.known[self.place(held)] {
            true => self.lattice.value(index).0.abs().min(far),
            false => far,
        }
    }

    fn knows_outside(&self) -> bool {
        false
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        let begin = self.index(block.first);
        let cell = begin.map(|c| c.div_euclid(SIDE)) - self.first;
        let mut points = None;
        let mut unknown = [false; BLOCK * BLOCK * BLOCK];
        let mut values = Vec::new();
        self.lattice.values_in(begin, BLOCK, &mut values);
        for (place, (out, &(value, is_known))) in out.iter_mut().zip(&values).enumerate() {
            let inner = [place % BLOCK, place / BLOCK % BLOCK, place / BLOCK / BLOCK];
            let index = begin + IVec3::from(inner.map(|c| c as i32));
            if is_known {
                *out = value;
                continue;
            }
            unknown[place] = true;
            let points = points.get_or_insert_with(|| self.points_around(cell));
            // Beyond 8 voxels, a point of another cell may be nearer, and an estimate is enough.
            let far = self.far_at(index);
            let voxels = if far > FAR {
                far
            } else {
                nearest_of(points, (index - self.first * SIDE).as_vec3()).min(far.max(SIDE as f32))
            };
            *out = self.signed(voxels, value);
        }
        if points.is_some() {
            limit(out, &unknown, self.lattice.voxel_size);
        }
    }
}

/// Limits unknown distances to one step more than their neighbors'. A file may store too short distances far from the
/// surface, and nothing may jump beside them.
fn limit(values: &mut [f32], unknown: &[bool], step: f32) {
    let strides = [1, BLOCK, BLOCK * BLOCK];
    let count = values.len();
    for is_back in [false, true] {
        for i in 0..count {
            let place = if is_back { count - 1 - i } else { i };
            if !unknown[place] {
                continue;
            }
            let mut most = f32::INFINITY;
            for stride in strides {
                let at = place / stride % BLOCK;
                if at > 0 {
                    most = most.min(values[place - stride].abs());
                }
                if at + 1 < BLOCK {
                    most = most.min(values[place + stride].abs());
                }
            }
            let own = values[place];
            values[place] = own.abs().min(most + step).copysign(own);
        }
    }
}
