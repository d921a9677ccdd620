//! Distances of a lattice, with those that it does not store.
//!
//! *Theory.* The surface crosses edges of the lattice, at most a voxel apart. The nearest crossing lies beside the nearest point
//! of the surface, by `a`. So its distance is `√(d² + a²)`, and the mean of `a²` tells `d` within 0.05 voxels, four voxels away or
//! farther. Files know nearer distances.

use super::lattice::Lattice;
use argil_mesh::SurfacePoints;
use argil_scene::DistanceSampler;
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Up to this many voxels from the surface, distances are those of the file. They end at twice as many.
const BAND: f32 = 2.0;

/// Mean square of the distance from a point of the surface to the nearest crossing, in voxels: 1/6 on a plane along the lattice, 0.1
/// on others.
const BESIDE: f32 = 0.14;

/// Distances at any place. Known ones near the surface are those of the file.
pub(super) struct Distances<'a> {
    lattice: &'a Lattice,
    /// The index that the points count from.
    first: IVec3,
    /// Where the surface crosses the edges, in voxels.
    surface: SurfacePoints,
}

impl<'a> Distances<'a> {
    /// Finds the surface. Returns `None` if there is none. `first` is an index near it.
    pub(super) fn new(lattice: &'a Lattice, first: IVec3) -> Option<Self> {
        let boxes = lattice.known_boxes();
        let points = |origin: &IVec3| crossings(lattice, *origin, (*origin - first).as_vec3());
        let points: Vec<[Vec3; 2]> = boxes.par_iter().flat_map_iter(points).collect();
        let surface = (!points.is_empty()).then(|| SurfacePoints::new(points))?;
        Some(Self {
            lattice,
            first,
            surface,
        })
    }
}

impl DistanceSampler for Distances<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        let Lattice {
            voxel_size, origin, ..
        } = *self.lattice;
        let first = self.first.as_vec3();
        let places: Vec<Vec3> = points
            .iter()
            .map(|&p| (p - origin) / voxel_size - first)
            .collect();
        self.surface.distances(&places, out);
        for (place, d) in places.iter().zip(out) {
            let (value, is_known) = self.lattice.value(self.first + place.round().as_ivec3());
            let voxels = (*d * *d - BESIDE).max(0.0).sqrt();
            let stored = value.abs() / voxel_size;
            // A value that is much too short must not end beside a distance.
            let share = match is_known {
                true => (stored.max(voxels - 1.0) / BAND - 1.0).clamp(0.0, 1.0),
                false => 1.0,
            };
            *d = (voxel_size * (stored + (voxels - stored) * share)).copysign(value);
        }
    }
}

/// Returns where the surface crosses the edges from a box of 8³ voxels, in voxels from its first, `begin`, and its slopes there.
fn crossings(lattice: &Lattice, origin: IVec3, begin: Vec3) -> Vec<[Vec3; 2]> {
    const SIDE: usize = 10;
    let mut values = Vec::new();
    // With a voxel around it.
    lattice.values_in(origin - 1, SIDE, &mut values);
    let strides = [1, SIDE, SIDE * SIDE];
    let slope = |place: usize| {
        let own = values[place].0;
        Vec3::from(strides.map(|stride| {
            let [before, after] = [place - stride, place + stride].map(|at| match values[at] {
                (value, true) => value,
                _ => own,
            });
            after - before
        }))
    };
    let mut points = Vec::new();
    for i in 0..512 {
        let inner = IVec3::new(i % 8, i / 8 % 8, i / 64);
        let place = (inner + 1).dot(IVec3::new(1, SIDE as i32, (SIDE * SIDE) as i32)) as usize;
        let (value, is_known) = values[place];
        if !is_known {
            continue;
        }
        for (axis, stride) in IVec3::AXES.into_iter().zip(strides) {
            for (side, other) in [(axis, place + stride), (-axis, place - stride)] {
                let (beyond, is_beyond_known) = values[other];
                // Of two known values, the first one has the crossing.
                if (beyond < 0.0) == (value < 0.0) || (is_beyond_known && side != axis) {
                    continue;
                }
                let along = match is_beyond_known {
                    true => value / (value - beyond),
                    false => (value.abs() / lattice.voxel_size).min(1.0),
                };
                points.push([
                    begin + inner.as_vec3() + along * side.as_vec3(),
                    slope(place),
                ]);
            }
        }
    }
    points
}
