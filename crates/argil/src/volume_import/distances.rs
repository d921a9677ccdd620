//! Distances of a lattice, with those that it does not store.
//!
//! *Theory.* The surface crosses edges of the lattice, at most a voxel apart. The nearest crossing lies beside the nearest point
//! of the surface, by `a`. So its distance is `√(d² + a²)`, and the mean of `a²` tells `d` within 0.05 voxels, four voxels away or
//! farther. Files know nearer distances.

use super::lattice::Lattice;
use argil_mesh::SurfacePoints;
use argil_scene::{DistanceSampler, SAMPLED_SIDE, SampledBlock};
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Up to this many voxels from the surface, distances are those of the file. They end at twice as many.
const BAND: f32 = 2.0;

/// Mean square of the distance from a point of the surface to the nearest crossing, in voxels: 1/6 on a plane along the lattice, 0.1
/// on others.
const BESIDE: f32 = 0.14;

/// From this sum of second differences on, in voxels, values tell of a corner. A sphere of four voxels has less.
const CORNER: f32 = 0.6;
/// The least slope beside a corner. The larger one of two coordinates, which is no distance, has less.
const CORNER_SLOPE: f32 = 0.87;

/// Values nearer to the largest one than this share of it may be clamped.
const CLAMPED: f32 = 0.9;

/// Slopes in this range are those of distances.
const SLOPES: std::ops::RangeInclusive<f32> = 0.8..=1.25;
/// About this many boxes tell the slope.
const SLOPE_BOXES: usize = 4096;

/// Makes values distances near the surface. Returns their factor: 1, unless half of their slopes there are out of range.
pub(super) fn scale_to_distances(lattice: &mut Lattice) -> f32 {
    // Distances to the sides of an array say nothing about its values.
    let is_cut = lattice.is_cut();
    if is_cut {
        lattice.set_cut(false);
    }
    let factor = factor_of(lattice);
    if is_cut {
        lattice.set_cut(true);
    }
    if factor != 1.0 {
        lattice.scale(factor);
    }
    factor
}

fn factor_of(lattice: &Lattice) -> f32 {
    let boxes = lattice.known_boxes();
    let some = boxes.par_iter().step_by(boxes.len() / SLOPE_BOXES + 1);
    let mut slopes: Vec<f32> = some
        .flat_map_iter(|origin| surface_points(lattice, *origin, Vec3::ZERO, false))
        .map(|[_, slope]| slope.as_dvec3().length() as f32)
        .collect();
    if slopes.is_empty() {
        return 1.0;
    }
    let middle = slopes.len() / 2;
    let (_, &mut slope, _) = slopes.select_nth_unstable_by(middle, f32::total_cmp);
    let factor = 1.0 / slope;
    if SLOPES.contains(&slope) || !factor.is_normal() {
        1.0
    } else {
        factor
    }
}

/// Distances at any place. Known ones near the surface are those of the file.
pub(super) struct Distances<'a> {
    lattice: &'a Lattice,
    /// The index that the points count from.
    first: IVec3,
    /// Where the surface crosses the edges, in voxels.
    surface: SurfacePoints,
    /// Up to this many voxels, values of the file are taken as they are.
    trusted: f32,
    /// From this many voxels on, outside and inside, values may be clamped.
    clamped: [f32; 2],
}

impl<'a> Distances<'a> {
    /// Finds the surface. Returns `None` if there is none. `first` is an index near it.
    pub(super) fn new(lattice: &'a Lattice, first: IVec3) -> Option<Self> {
        let boxes = lattice.known_boxes();
        // Arrays often hold other functions, whose corners would lie elsewhere.
        let has_corners = lattice.is_level_set();
        let points = |origin: &IVec3| {
            surface_points(lattice, *origin, (*origin - first).as_vec3(), has_corners)
        };
        let points: Vec<[Vec3; 2]> = boxes.par_iter().flat_map_iter(points).collect();
        // Where values rise by at least half of a distance, one of at most 1.5 voxels is at most 3 voxels away.
        let flat = points.iter().filter(|[_, slope]| slope.length() < 0.5);
        let is_steep = flat.count() < points.len() / 64;
        let surface = (!points.is_empty()).then(|| SurfacePoints::new(points))?;
        Some(Self {
            lattice,
            first,
            surface,
            trusted: if is_steep { 0.75 * BAND } else { 0.0 },
            clamped: clamped_from(lattice),
        })
    }

    /// Returns the place of a point in voxels from the first index.
    fn place(&self, point: Vec3) -> Vec3 {
        (point - self.lattice.origin) / self.lattice.voxel_size - self.first.as_vec3()
    }

    /// Returns a value in voxels, if it is a distance.
    fn stored(&self, (value, is_known): (f32, bool)) -> Option<f32> {
        let voxels = value.abs() / self.lattice.voxel_size;
        let clamped = self.clamped[usize::from(value < 0.0)];
        (is_known && voxels < clamped).then_some(voxels)
    }

    /// Returns a signed distance, given the value at the nearest index, and the distance in voxels to the nearest crossing.
    fn joined(&self, value: (f32, bool), crossing: f32) -> f32 {
        let voxel = self.lattice.voxel_size;
        let voxels = (crossing * crossing - BESIDE).max(0.0).sqrt();
        let (value, stored) = (value.0, self.stored(value));
        // A value that is much too short must not end beside a distance.
        let share = stored.map_or(1.0, |stored| {
            (stored.max(voxels - 1.0) / BAND - 1.0).clamp(0.0, 1.0)
        });
        let stored = stored.unwrap_or(0.0);
        (voxel * (stored + (voxels - stored) * share)).copysign(value)
    }
}

impl DistanceSampler for Distances<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        let places: Vec<Vec3> = points.iter().map(|&p| self.place(p)).collect();
        self.surface.distances(&places, out);
        for (place, d) in places.iter().zip(out) {
            let index = self.first + place.round().as_ivec3();
            *d = self.joined(self.lattice.value(index), *d);
        }
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        let first = self.place(block.first).round();
        if (block.step / self.lattice.voxel_size - 1.0).abs() > 0.01 {
            let places: Vec<Vec3> = (0..out.len()).map(|i| block.position(i)).collect();
            return self.distances(&places, out);
        }
        let index = self.first + first.as_ivec3();
        let mut values = Vec::new();
        self.lattice
            .values_in(index, SAMPLED_SIDE as usize + 1, &mut values);
        let is_far = |&i: &usize| {
            let stored = self.stored(values[i]);
            stored.is_none_or(|stored| stored > self.trusted)
        };
        let far: Vec<usize> = (0..out.len()).filter(is_far).collect();
        let place = |&i: &usize| self.place(block.position(i));
        let places: Vec<Vec3> = far.iter().map(place).collect();
        let mut crossings = vec![0.0; far.len()];
        self.surface.distances(&places, &mut crossings);
        for (out, (value, _)) in out.iter_mut().zip(&values) {
            *out = *value;
        }
        for (i, crossing) in far.into_iter().zip(crossings) {
            out[i] = self.joined(values[i], crossing);
        }
    }
}

/// Returns from how many voxels on values may be clamped, outside and inside.
fn clamped_from(lattice: &Lattice) -> [f32; 2] {
    let mut most = [0.0f32; 2];
    lattice.for_each_known(|_, value| {
        let extreme = &mut most[usize::from(value < 0.0)];
        *extreme = extreme.max(value.abs());
    });
    most.map(|most| {
        let limit = CLAMPED * most / lattice.voxel_size;
        // Values of the file end before.
        if limit > 2.0 * BAND { f32::MAX } else { limit }
    })
}

/// Returns where the surface crosses the edges from a box of 8³ voxels, and the slopes of the values there. The first voxel of the
/// box lies at `begin`, in voxels. Values that are distances also tell of corners.
fn surface_points(
    lattice: &Lattice,
    origin: IVec3,
    begin: Vec3,
    has_corners: bool,
) -> Vec<[Vec3; 2]> {
    const SIDE: usize = 10;
    let mut values = Vec::new();
    // With a voxel around it.
    lattice.values_in(origin - 1, SIDE, &mut values);
    let strides = [1, SIDE, SIDE * SIDE];
    // Toward the surface, so that the other side of a thin wall does not count.
    let slope = |place: usize| {
        let here = values[place].0;
        let sign = if here < 0.0 { -1.0 } else { 1.0 };
        let nearer = |(other, is_known): (f32, bool)| match is_known {
            true => (sign * (here - other)).max(0.0),
            false => 0.0,
        };
        let slope = strides.map(|stride| {
            let [before, after] = [place - stride, place + stride].map(|at| nearer(values[at]));
            sign * if before > after { before } else { -after }
        });
        Vec3::from(slope) / lattice.voxel_size
    };
    let mut points = Vec::new();
    for i in 0..512 {
        let inner = IVec3::new(i % 8, i / 8 % 8, i / 64);
        let place = (inner + 1).dot(IVec3::new(1, SIDE as i32, (SIDE * SIDE) as i32)) as usize;
        let (value, is_known) = values[place];
        if !is_known {
            continue;
        }
        let around = strides.map(|stride| [values[place - stride], values[place + stride]]);
        let around = around.as_flattened();
        // Beside a corner, distances are those to it, and bend: the crossings would cut it off.
        let bend: f32 = around.iter().map(|(other, _)| other - value).sum();
        let voxels = value / lattice.voxel_size;
        if has_corners
            && (1.0..=BAND).contains(&voxels.abs())
            && bend * value.signum() > CORNER * lattice.voxel_size
            && around.iter().all(|(_, is_known)| *is_known)
        {
            let slope = strides.map(|s| values[place + s].0 - values[place - s].0);
            let slope = Vec3::from(slope) / (2.0 * lattice.voxel_size);
            if slope.length() > CORNER_SLOPE {
                let way = voxels * slope.normalize();
                points.push([begin + inner.as_vec3() - way, slope]);
            }
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
