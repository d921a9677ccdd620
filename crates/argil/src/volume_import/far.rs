//! Distances of a lattice, with those that it does not store.
//!
//! *Theory.* Each corner of a cell of 8³ voxels learns the nearest voxel next to the surface: first the corners around such
//! voxels, then the others from their neighbors, in sweeps (Danielsson, "Euclidean distance mapping", 1980). The surface is no
//! nearer than that voxel less half of a voxel's diagonal.

use super::lattice::Lattice;
use argil_scene::{DistanceSampler, SAMPLED_SIDE};
use glam::{IVec3, Vec3, ivec3};

const SIDE: i32 = SAMPLED_SIDE as i32;
/// No voxel is known.
const NONE: u32 = u32::MAX;

/// Distances at any index in a box of cells.
pub(super) struct Distances<'a> {
    lattice: &'a Lattice,
    /// The first cell, and the number of corners along each axis.
    first: IVec3,
    corners: IVec3,
    /// Lower bounds of the unsigned distance at corners, in voxels.
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
            far: Vec::new(),
            known: vec![false; count],
        };
        let mut points: Vec<IVec3> = Vec::new();
        let mut nearest = vec![NONE; count];
        lattice.for_each_known(|index, value| {
            let cell = index.map(|c| c.div_euclid(SIDE)) - first;
            if cell.min_element() < 0 || (cell - cells).max_element() >= 0 {
                return;
            }
            let place = own.place(cell);
            own.known[place] = true;
            if value.abs() <= lattice.voxel_size {
                let nth = points.len() as u32;
                points.push(index - first * SIDE);
                for corner in 0..8 {
                    let at = cell + ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
                    own.offer(&mut nearest, &points, at, nth);
                }
            }
        });
        own.sweep(&mut nearest, &points);
        own.far = (0..count)
            .map(|place| {
                let distance = own.length(&points, own.corner(place), nearest[place]);
                (distance - 0.5 * 3f32.sqrt()).max(0.0)
            })
            .collect();
        own
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

    fn length(&self, points: &[IVec3], corner: IVec3, nth: u32) -> f32 {
        match points.get(nth as usize) {
            Some(&point) => (point - SIDE * corner).as_vec3().length(),
            None => f32::MAX.sqrt(),
        }
    }

    /// Stores a voxel at a corner if it is nearer than the one there.
    fn offer(&self, nearest: &mut [u32], points: &[IVec3], corner: IVec3, nth: u32) {
        let own = &mut nearest[self.place(corner)];
        if self.length(points, corner, nth) < self.length(points, corner, *own) {
            *own = nth;
        }
    }

    /// Hands voxels on to neighbors, from both ends, twice.
    fn sweep(&self, nearest: &mut [u32], points: &[IVec3]) {
        let neighbors: Vec<IVec3> = (0..27)
            .map(|i| ivec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
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
                            self.offer(nearest, points, corner, nth);
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

    /// Interpolates between corners.
    fn far_at(&self, index: IVec3) -> f32 {
        let at = (index - self.first * SIDE).clamp(IVec3::ZERO, SIDE * (self.corners - 1));
        let cell = (at / SIDE).min(self.corners - 2).max(IVec3::ZERO);
        let t = (at - SIDE * cell).as_vec3() / SIDE as f32;
        let mut sum = 0.0;
        for corner in 0..8 {
            let offset = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
            let share = Vec3::select(offset.cmpgt(IVec3::ZERO), t, 1.0 - t);
            sum += share.element_product()
                * self.far[self.place((cell + offset).min(self.corners - 1))];
        }
        sum
    }

    fn distance(&self, index: IVec3) -> f32 {
        let (value, is_known) = self.lattice.value(index);
        if is_known {
            return value;
        }
        let far = (self.far_at(index) * self.lattice.voxel_size).max(value.abs());
        far.copysign(value)
    }
}

impl DistanceSampler for Distances<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        for (point, out) in points.iter().zip(out) {
            *out = self.distance(self.index(*point));
        }
    }

    fn unsigned_distance(&self, point: Vec3) -> f32 {
        let index = self.index(point);
        let cell = index.map(|c| c.div_euclid(SIDE)) - self.first;
        let held = cell.clamp(IVec3::ZERO, self.corners - 1);
        match self.known[self.place(held)] {
            true => self
                .lattice
                .value(index)
                .0
                .abs()
                .min(self.far_at(index) * self.lattice.voxel_size),
            false => self.far_at(index) * self.lattice.voxel_size,
        }
    }
}
