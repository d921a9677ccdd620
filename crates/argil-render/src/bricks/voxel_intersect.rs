//! Intersects rays near the surface with it in their voxel, and computes normals there.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::step::{NUDGE_RELATIVE, NUDGE_VOXELS, high, low, tiny};
use argil_abi::{self as abi, FrameUniform};
use argil_field::LANES;
use argil_volume::{BrickSampler, CellLocations, NeighborPlanes, Texel, VoxelSamples};
use multiversion::multiversion;

/// A batch of rays near the surface, and their results.
pub(crate) struct NearLanes {
    pub direction: [[f32; LANES]; 3],
    pub t: [f32; LANES],
    pub side: [f32; LANES],
    pub hit: [u8; LANES],
    pub normal: [[f32; LANES]; 3],
}

impl Default for NearLanes {
    fn default() -> Self {
        Self {
            direction: [[0.0; LANES]; 3],
            t: [0.0; LANES],
            side: [0.0; LANES],
            hit: [0; LANES],
            normal: [[0.0; LANES]; 3],
        }
    }
}

/// The positions of a batch's rays in their voxels, and the samples there.
struct RayPositions<'a, 'b, T> {
    sampler: &'a BrickSampler<'b, T>,
    u: [[f32; LANES]; 3],
    at: CellLocations,
    corners: VoxelSamples,
}

/// Solves a batch's cubics for their first roots, and computes the normals there.
#[inline(always)]
fn intersect_voxel<T: Texel>(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, T>,
    n: usize,
    lanes: &mut NearLanes,
) {
    let mut places = RayPositions {
        sampler,
        u: [[0.0f32; LANES]; 3],
        at: CellLocations::default(),
        corners: VoxelSamples::default(),
    };
    let [dx, dy, dz] = &lanes.direction;
    let direction = [&dx[..n], &dy[..n], &dz[..n]];
    super::step::place(frame, sampler, direction, &lanes.t[..n], &mut places.u);
    let [ux, uy, uz] = &places.u;
    sampler.locate([&ux[..n], &uy[..n], &uz[..n]], &mut places.at);
    sampler.voxel_samples(&places.at, n, &mut places.corners);
    let mut hit = [[0.0f32; LANES]; 3];
    let measures = measures(frame, &places, n, lanes);
    roots::<T>(&measures, &places.corners, n, lanes, &mut hit);
    let mut beyond = NeighborPlanes::default();
    if frame.normals == abi::NORMALS_SMOOTH {
        for i in 0..n {
            if lanes.hit[i] != 0 {
                let fraction = [hit[0][i], hit[1][i], hit[2][i]];
                sampler.neighbor_planes(&places.at, &places.corners, i, fraction, &mut beyond);
            }
        }
    }
    normals::<T>(&places.corners, &beyond, &hit, n, lanes);
}

/// Returns what intersecting a batch needs of sparse bricks.
#[inline(always)]
fn measures<T: Texel>(
    frame: &FrameUniform,
    places: &RayPositions<'_, '_, T>,
    n: usize,
    lanes: &NearLanes,
) -> VoxelMeasures {
    let RayPositions { sampler, u, .. } = places;
    let voxel = sampler.layout().voxel_grid().voxel_size;
    let mut measures = VoxelMeasures {
        voxel: [voxel; LANES],
        quantum: [sampler.quantum(); LANES],
        close: [frame.epsilon; LANES],
        nudge: [0.0; LANES],
    };
    for i in 0..n {
        let t = lanes.t[i];
        let rounding = if sampler.has_levels() {
            super::step::nudge_for([u[0][i], u[1][i], u[2][i]], voxel)
        } else {
            0.0
        };
        measures.nudge[i] = NUDGE_VOXELS * voxel + NUDGE_RELATIVE * t + rounding;
    }
    measures
}

/// What intersecting a batch needs of the volume, for each ray.
pub(crate) struct VoxelMeasures {
    /// The edge of the voxel.
    pub voxel: [f32; LANES],
    /// The distance that one code step means.
    pub quantum: [f32; LANES],
    /// Below this distance, a ray hits.
    pub close: [f32; LANES],
    /// How far a ray advances beyond its voxel.
    pub nudge: [f32; LANES],
}

/// Computes how far each ray goes in its voxel until it hits or leaves, and the position there.
#[inline(always)]
pub(crate) fn roots<T: Texel>(
    measures: &VoxelMeasures,
    corners: &VoxelSamples,
    n: usize,
    lanes: &mut NearLanes,
    place: &mut [[f32; LANES]; 3],
) {
    for i in 0..n {
        let s = corners.integers::<T>(i);
        let fraction = [
            corners.fraction[0][i],
            corners.fraction[1][i],
            corners.fraction[2][i],
        ];
        let [x, y, z] = fraction;
        let per_voxel = 1.0 / measures.voxel[i];
        let (dx, dy, dz) = (
            lanes.direction[0][i] * per_voxel,
            lanes.direction[1][i] * per_voxel,
            lanes.direction[2][i] * per_voxel,
        );
        // Where the ray leaves the voxel.
        let out_of = |d: f32, f: f32| {
            let d = tiny(d);
            (if d > 0.0 { 1.0 - f } else { -f }) / d
        };
        let leave = high(low(out_of(dx, x), low(out_of(dy, y), out_of(dz, z))), 0.0);
        let (dx, dy, dz) = (dx * leave, dy * leave, dz * leave);
        let c = cubic(
            s,
            lanes.side[i] * measures.quantum[i],
            fraction,
            [dx, dy, dz],
        );
        let (s, is_crossed) = first_root(c);
        let t = lanes.t[i];
        let starts_below = c[0] <= 0.0;
        let is_close = c[0] < measures.close[i];
        let s = if starts_below | !is_crossed { 0.0 } else { s };
        let hit = starts_below | is_crossed | is_close;
        lanes.t[i] = if hit {
            t + s * leave
        } else {
            t + leave + measures.nudge[i]
        };
        lanes.hit[i] = u8::from(hit);
        for (place, (f, d)) in place.iter_mut().zip([(x, dx), (y, dy), (z, dz)]) {
            place[i] = low(high(f + s * d, 0.0), 1.0);
        }
    }
}

/// Returns the coefficients of the interpolated distance along a way through a voxel, for a parameter from 0 to 1.
#[inline(always)]
fn cubic(s: [f32; 8], side: f32, [x, y, z]: [f32; 3], [dx, dy, dz]: [f32; 3]) -> [f32; 4] {
    // As a polynomial of the position in the voxel.
    let k0 = s[0] * side;
    let (kx, ky, kz) = (
        (s[1] - s[0]) * side,
        (s[2] - s[0]) * side,
        (s[4] - s[0]) * side,
    );
    let kxy = (s[3] - s[2] - s[1] + s[0]) * side;
    let kyz = (s[6] - s[4] - s[2] + s[0]) * side;
    let kxz = (s[5] - s[4] - s[1] + s[0]) * side;
    let kxyz = (s[7] - s[6] - s[5] - s[3] + s[4] + s[2] + s[1] - s[0]) * side;
    let c0 =
        k0 + kx * x + ky * y + kz * z + kxy * x * y + kyz * y * z + kxz * x * z + kxyz * x * y * z;
    let c1 = kx * dx
        + ky * dy
        + kz * dz
        + kxy * (x * dy + y * dx)
        + kyz * (y * dz + z * dy)
        + kxz * (x * dz + z * dx)
        + kxyz * (dx * y * z + x * dy * z + x * y * dz);
    let c2 = kxy * dx * dy
        + kyz * dy * dz
        + kxz * dx * dz
        + kxyz * (dx * dy * z + dx * y * dz + x * dy * dz);
    let c3 = kxyz * dx * dy * dz;
    [c0, c1, c2, c3]
}

/// Returns the first parameter from 0 to 1 where a cubic falls below 0, and whether there is one.
#[inline(always)]
fn first_root([c0, c1, c2, c3]: [f32; 4]) -> (f32, bool) {
    let value = |s: f32| ((c3 * s + c2) * s + c1) * s + c0;
    // It has at most two turning points: the first interval that ends below 0 contains the first root.
    let (a, b) = (3.0 * c3, c2);
    let root = high(b * b - a * c1, 0.0).sqrt();
    let q = -(b + if b < 0.0 { -root } else { root });
    let turn = |num: f32, den: f32| {
        let s = num / (if den == 0.0 { 1e-30 } else { den });
        high(low(s, 1.0), 0.0)
    };
    let (s1, s2) = (turn(q, a), turn(c1, q));
    let (first, second) = (low(s1, s2), high(s1, s2));
    let in_first = value(first) < 0.0;
    let in_second = value(second) < 0.0;
    let at_end = value(1.0) < 0.0;
    let mut from = if in_first {
        0.0
    } else if in_second {
        first
    } else {
        second
    };
    let mut to = if in_first {
        first
    } else if in_second {
        second
    } else {
        1.0
    };
    let (mut f_from, mut f_to) = (value(from), value(to));
    // Regula falsi, Illinois variant: the end that stays counts half.
    let mut s = to;
    for _ in 0..4 {
        let span = f_from - f_to;
        s = from + (to - from) * (f_from / (if span == 0.0 { 1.0 } else { span }));
        let f = value(s);
        let below = f < 0.0;
        f_from = if below { 0.5 * f_from } else { f };
        from = if below { from } else { s };
        f_to = if below { f } else { 0.5 * f_to };
        to = if below { s } else { to };
    }
    (s, in_first | in_second | at_end)
}

/// Computes the normals at hits.
#[inline(always)]
pub(crate) fn normals<T: Texel>(
    corners: &VoxelSamples,
    beyond: &NeighborPlanes,
    place: &[[f32; LANES]; 3],
    n: usize,
    lanes: &mut NearLanes,
) {
    for i in 0..n {
        let s = corners.integers::<T>(i);
        let (x, y, z) = (place[0][i], place[1][i], place[2][i]);
        // The values of the faces at the position, and how the distance changes from one to the other and beyond.
        let change = |axis: usize, near: [f32; 4], far: [f32; 4], f: f32, (u, v): (f32, f32)| {
            let on_face = |[a, b, c, d]: [f32; 4]| {
                let (p, q) = (a + (b - a) * u, c + (d - c) * u);
                p + (q - p) * v
            };
            let plane = &beyond.plane[axis];
            let (near, far) = (on_face(near), on_face(far));
            let next = on_face([plane[0][i], plane[1][i], plane[2][i], plane[3][i]]);
            let goes_up = f >= 0.5;
            let outer = if goes_up { next - far } else { near - next };
            let share = (f - 0.5).abs() * beyond.is_there[axis][i];
            let inner = far - near;
            inner + (outer - inner) * share
        };
        let side = lanes.side[i];
        let nx = change(
            0,
            [s[0], s[2], s[4], s[6]],
            [s[1], s[3], s[5], s[7]],
            x,
            (y, z),
        ) * side;
        let ny = change(
            1,
            [s[0], s[1], s[4], s[5]],
            [s[2], s[3], s[6], s[7]],
            y,
            (x, z),
        ) * side;
        let nz = change(
            2,
            [s[0], s[1], s[2], s[3]],
            [s[4], s[5], s[6], s[7]],
            z,
            (x, y),
        ) * side;
        let length = (nx * nx + ny * ny + nz * nz).sqrt();
        let is_flat = length == 0.0;
        let scale = 1.0 / (if is_flat { 1.0 } else { length });
        // If all values are equal, toward the viewer.
        let toward = |axis: usize, n: f32| {
            if is_flat {
                -lanes.direction[axis][i]
            } else {
                n * scale
            }
        };
        let (nx, ny, nz) = (toward(0, nx), toward(1, ny), toward(2, nz));
        lanes.normal[0][i] = nx;
        lanes.normal[1][i] = ny;
        lanes.normal[2][i] = nz;
    }
}

// `multiversion` does not accept generic functions, so each sample type has a wrapper.

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn solve_i8(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, i8>,
    n: usize,
    lanes: &mut NearLanes,
) {
    intersect_voxel(frame, sampler, n, lanes);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn solve_i16(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, i16>,
    n: usize,
    lanes: &mut NearLanes,
) {
    intersect_voxel(frame, sampler, n, lanes);
}
