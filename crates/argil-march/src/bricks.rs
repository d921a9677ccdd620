//! Rays through sparse bricks; `bricks.wgsl` is the twin.
//!
//! *Theory.* In a cell without a brick a ray goes as far as the cell's distance says, at least to the cell's end, or to
//! the block's where all of that is empty. In a brick it sphere traces the interpolated distance until that is under
//! half a voxel; then the distance along the ray within the voxel is a cubic polynomial, and its first root is the
//! surface (Parker et al., "Interactive ray tracing for isosurface rendering", 1998; Hansson-Söderlund, Evans and
//! Akenine-Möller, "Ray tracing of signed distance function grids", 2022). A ray that comes closer than half of its
//! pixel has hit as well.
//!
//! *Practice.* Cones around 8×8 pixels go first (`cones.rs`); rays begin where theirs ended. A tile's rays march
//! together in batches; those near the surface are gathered, and their voxels' cubics solved in batches of their own. The
//! voxel's gradient is the normal.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use crate::cones::{CONE_SIDE, Cones};
use crate::scratch::TileScratch;
use crate::tile::Tile;
use crate::trace::{around, lay_ground, set_normals};
use crate::wave::{RETIRED, Wave};
use argil_abi::{self as abi, Frame, Hit};
use argil_field::{Evaluator, LANES};

use argil_volume::{
    BLOCK_SIDE, Beyond, Bits, BrickSampler, Bricks, Corners, Located, Texel, is_brick, is_lonely,
};
use glam::Vec3;
use multiversion::multiversion;
use std::ops::Range;

/// Nearer than this many voxels a ray looks for the surface in its voxel.
const NEAR_VOXELS: f32 = 0.2;
/// A ray that leaves a cell or a voxel goes so many voxels farther, and so much of its length, to be in the next.
/// How much of what spheres along a plane allow a ray goes beyond its own.
const RELAXATION: f32 = 0.9;
const NUDGE_VOXELS: f32 = 1e-3;
const NUDGE_SHARE: f32 = 5e-7;

/// Bricks, ready to be marched through.
pub(crate) enum BrickRays<'a> {
    Eight(BrickSampler<'a, i8>),
    Sixteen(BrickSampler<'a, i16>),
}

impl<'a> BrickRays<'a> {
    pub fn new(bricks: &'a Bricks) -> Option<Self> {
        match bricks.layout().encoding.bits {
            Bits::Eight => BrickSampler::new(bricks).map(Self::Eight),
            Bits::Sixteen => BrickSampler::new(bricks).map(Self::Sixteen),
        }
    }

    /// Around points in the world, how far the surface is at least, with the sign of the side. What is interpolated is off
    /// by half of a voxel's diagonal at most.
    pub fn clearances(&self, points: [&[f32]; 3], out: &mut [f32]) {
        let margin = 0.5 * 3f32.sqrt() * self.voxel();
        match self {
            Self::Eight(sampler) => clearances_i8(sampler, points, margin, out),
            Self::Sixteen(sampler) => clearances_i16(sampler, points, margin, out),
        }
    }

    /// The signed distances at points in the world, as nearly as they are known.
    pub fn estimates(&self, points: [&[f32]; 3], out: &mut [f32]) {
        match self {
            Self::Eight(sampler) => estimates_i8(sampler, points, out),
            Self::Sixteen(sampler) => estimates_i16(sampler, points, out),
        }
    }

    pub fn voxel(&self) -> f32 {
        match self {
            Self::Eight(sampler) => sampler.layout().lattice.voxel,
            Self::Sixteen(sampler) => sampler.layout().lattice.voxel,
        }
    }

    pub fn bounds(&self) -> argil_math::Aabb {
        match self {
            Self::Eight(sampler) => sampler.layout().lattice.aabb(),
            Self::Sixteen(sampler) => sampler.layout().lattice.aabb(),
        }
    }
}

/// Rays near the surface, in batches of their own.
#[derive(Default)]
pub(crate) struct Near {
    /// Their places in the wave.
    rays: Vec<u32>,
    lanes: Box<NearLanes>,
}

/// A batch of rays near the surface, and what is found of each.
struct NearLanes {
    direction: [[f32; LANES]; 3],
    t: [f32; LANES],
    side: [f32; LANES],
    hit: [u8; LANES],
    normal: [[f32; LANES]; 3],
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

/// What a step of a batch finds: a 1 for each ray.
struct Found {
    near: [u8; LANES],
    reached: [u8; LANES],
    ended: [u8; LANES],
}

/// What the primary ray of each pixel of a tile hits, row by row, into `out`.
pub(crate) fn trace_bricks(
    frame: &Frame,
    tile: Tile,
    bricks: &BrickRays<'_>,
    evaluator: &mut Evaluator<'_>,
    scratch: &mut TileScratch,
    out: &mut [Hit],
) {
    let TileScratch {
        starts,
        wave,
        cones,
        near,
        points,
        hits,
        ..
    } = scratch;
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    cones.march(frame, tile, starts, bricks, out);
    start(tile, starts, cones, wave);

    let mut steps = 0;
    while wave.len() > 0 {
        steps += 1;
        near.rays.clear();
        for first in (0..wave.len()).step_by(LANES) {
            let range = first..(first + LANES).min(wave.len());
            let mut found = Found {
                near: [0; LANES],
                reached: [0; LANES],
                ended: [0; LANES],
            };
            match bricks {
                BrickRays::Eight(s) => step_i8(frame, s, steps, wave, range, &mut found),
                BrickRays::Sixteen(s) => step_i16(frame, s, steps, wave, range, &mut found),
            }
            for i in crate::trace::flagged(&found.ended) {
                let ray = first + i;
                if found.near[i] != 0 {
                    near.rays.push(ray as u32);
                    continue;
                }
                let hit = end(wave, ray, out);
                if found.reached[i] != 0 {
                    hit.kind = kind_of(wave.side[ray]);
                    hit.normal_t[3] = wave.t[ray];
                    // In a cell without a brick, or a cut side: the box's own is as good as any.
                    let [x, y, z] = [0, 1, 2].map(|axis: usize| -wave.direction[axis][ray]);
                    hit.normal_t = [x, y, z, wave.t[ray]];
                }
                wave.retire(ray);
            }
        }
        settle(frame, bricks, steps, near, wave, out);
        wave.compact();
    }
    if frame.normals == abi::NORMALS_FIELD {
        hits.clear();
        let is_hit = |&i: &u32| out[i as usize].kind != abi::HIT_NONE;
        hits.extend((0..tile.area() as u32).filter(is_hit));
        around(frame, tile, hits, points, out);
        points.measure(evaluator);
        set_normals(frame, tile, hits, points, out);
    }
    lay_ground(frame, tile, out);
}

/// Take up the rays whose cones have not shown that they miss.
fn start(tile: Tile, starts: &crate::wave::Starts, cones: &Cones, wave: &mut Wave) {
    wave.clear();
    let [x, y, z] = &starts.direction;
    for row in 0..tile.rows {
        for first in (0..tile.width).step_by(CONE_SIDE as usize) {
            let begin = cones.begin(first, row);
            if begin == f32::INFINITY {
                continue;
            }
            for column in first..(first + CONE_SIDE).min(tile.width) {
                let i = (row * tile.width + column) as usize;
                let (near, far) = (starts.near[i], starts.far[i]);
                let from = if begin > near { begin } else { near };
                if near <= far && from <= far {
                    wave.push(i as u32, Vec3::new(x[i], y[i], z[i]), (from, far));
                    // What a ray is in when it begins: a negative start tells that it came from outside.
                    if let Some(side) = wave.side.last_mut() {
                        *side = if near > 0.0 { 2.0 } else { 0.0 };
                    }
                }
            }
        }
    }
}

fn kind_of(side: f32) -> u32 {
    if side < 0.0 {
        abi::HIT_INSIDE
    } else {
        abi::HIT_OUTSIDE
    }
}

/// Write down what a ray has looked up.
fn end<'a>(wave: &Wave, ray: usize, out: &'a mut [Hit]) -> &'a mut Hit {
    let hit = &mut out[wave.pixel[ray] as usize];
    hit.steps += wave.samples[ray] + wave.cells[ray];
    hit.cells += wave.cells[ray];
    hit
}

/// Solve the cubics of the rays near the surface; what has hit ends, the others go on behind their voxel.
fn settle(
    frame: &Frame,
    bricks: &BrickRays<'_>,
    steps: u32,
    near: &mut Near,
    wave: &mut Wave,
    out: &mut [Hit],
) {
    let lanes = &mut near.lanes;
    for rays in near.rays.chunks(LANES) {
        for (i, &ray) in rays.iter().enumerate() {
            let ray = ray as usize;
            for axis in 0..3 {
                lanes.direction[axis][i] = wave.direction[axis][ray];
            }
            lanes.t[i] = wave.t[ray];
            lanes.side[i] = wave.side[ray];
        }
        match bricks {
            BrickRays::Eight(sampler) => solve_i8(frame, sampler, rays.len(), lanes),
            BrickRays::Sixteen(sampler) => solve_i16(frame, sampler, rays.len(), lanes),
        }
        for (i, &ray) in rays.iter().enumerate() {
            let ray = ray as usize;
            wave.t[ray] = lanes.t[i];
            wave.samples[ray] += 1;
            if lanes.hit[i] != 0 {
                let hit = end(wave, ray, out);
                hit.kind = kind_of(wave.side[ray]);
                let [x, y, z] = [0, 1, 2].map(|axis: usize| lanes.normal[axis][i]);
                hit.normal_t = [x, y, z, lanes.t[i]];
                wave.retire(ray);
            } else if lanes.t[i] > wave.end[ray] || steps >= frame.max_steps {
                end(wave, ray, out);
                wave.retire(ray);
            }
        }
    }
}

/// Rays at their lengths, in voxels from the volume's corner.
#[inline(always)]
fn place<T: Texel>(
    frame: &Frame,
    sampler: &BrickSampler<'_, T>,
    direction: [&[f32]; 3],
    t: &[f32],
    out: &mut [[f32; LANES]; 3],
) {
    let lattice = &sampler.layout().lattice;
    let per_voxel = 1.0 / lattice.voxel;
    for axis in 0..3 {
        let (eye, corner) = (frame.eye_step[axis], lattice.corner[axis]);
        for ((u, d), t) in out[axis].iter_mut().zip(direction[axis]).zip(t) {
            *u = (eye + d * t - corner) * per_voxel;
        }
    }
}

#[inline(always)]
fn tiny(d: f32) -> f32 {
    if d.abs() < 1e-20 { 1e-20 } else { d }
}

#[inline(always)]
fn low(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn high(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// One step of a batch of rays.
#[inline(always)]
fn step<T: Texel>(
    frame: &Frame,
    sampler: &BrickSampler<'_, T>,
    steps: u32,
    wave: &mut Wave,
    range: Range<usize>,
    found: &mut Found,
) {
    let n = range.len();
    let layout = sampler.layout();
    let (voxel, brick) = (layout.lattice.voxel, layout.brick as f32);
    let (scale, footprint) = (frame.eye_step[3], 0.5 * frame.pixel);
    let (is_first, is_last) = (steps == 1, steps >= frame.max_steps);
    let [dx, dy, dz] = &wave.direction;
    let direction = [&dx[range.clone()], &dy[range.clone()], &dz[range.clone()]];
    let (t, ends) = (&mut wave.t[range.clone()], &wave.end[range.clone()]);
    let side = &mut wave.side[range.clone()];
    let (samples, cells) = (
        &mut wave.samples[range.clone()],
        &mut wave.cells[range.clone()],
    );
    let (over, last_gap) = (
        &mut wave.over[range.clone()],
        &mut wave.last_gap[range.clone()],
    );
    let last_way = &mut wave.last_way[range.clone()];
    let last = &mut wave.level[range];
    let mut u = [[0.0f32; LANES]; 3];
    place(frame, sampler, direction, t, &mut u);
    let (mut at, mut corners) = (Located::default(), Corners::default());
    sampler.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
    sampler.corners(&at, n, &mut corners);

    let (mut gap, mut leave) = ([0.0f32; LANES], [0.0f32; LANES]);
    let gap = &mut gap[..n];
    let quantum = sampler.quantum();
    for i in 0..n {
        let word = at.word[i];
        gap[i] = if is_brick(word) {
            corners.value::<T>(i) * quantum
        } else {
            sampler.away(&at, i)
        };
    }
    if is_first {
        // A ray that enters the volume through a solid's cut side has hit there; one that starts within goes on.
        for i in 0..n {
            let from_outside = side[i] > 1.0;
            side[i] = if (gap[i] < 0.0) & !from_outside {
                -1.0
            } else {
                1.0
            };
            last[i] = u32::MAX;
        }
    }
    // To the end of the cell, or of the block.
    leave[..n].fill(f32::MAX);
    let block = BLOCK_SIDE as f32;
    for axis in 0..3 {
        let (cells, u, d) = (&at.cell[axis][..n], &u[axis][..n], &direction[axis][..n]);
        for i in 0..n {
            let cell = cells[i];
            let of_block = (cell * (1.0 / block)).floor() * block;
            let lonely = is_lonely(at.word[i]);
            let begin = if lonely { of_block } else { cell };
            let side = if lonely { block } else { 1.0 };
            let d = tiny(d[i]);
            let ahead = if d > 0.0 { begin + side } else { begin };
            leave[i] = low(leave[i], (ahead * brick - u[i]) * voxel / d);
        }
    }
    for i in 0..n {
        let g = gap[i] * side[i];
        let in_brick = is_brick(at.word[i]);
        let nudge = NUDGE_VOXELS * voxel + NUDGE_SHARE * t[i];
        let empty_way = high(g * scale, leave[i] + nudge);
        let close = high(NEAR_VOXELS * voxel, footprint * t[i]);
        // Spheres that no longer touch: back to where the last one ended.
        let too_far = (over[i] > 0.0) & (g < over[i]);
        let near = in_brick & (g < close) & !too_far;
        let reached = !in_brick & (g < 0.0) & !too_far;
        // Along a plane, spheres still touch with so much more than their radius between their centres.
        let (before, fell) = (last_way[i], high(last_gap[i] - g, 0.0));
        let sum = before + fell;
        let share = high((before - fell) / (if sum > 0.0 { sum } else { 1.0 }), 0.0);
        let more = RELAXATION * g * share * scale;
        let beyond = if in_brick & !too_far { more } else { 0.0 };
        let moved = if in_brick {
            g * scale + beyond
        } else {
            empty_way
        };
        let moved = if too_far { -over[i] } else { moved };
        let stays = near | reached;
        over[i] = if stays { 0.0 } else { beyond };
        let tells = in_brick & !too_far & !stays;
        last_gap[i] = g;
        last_way[i] = if tells { moved } else { 0.0 };
        t[i] += if stays { 0.0 } else { moved };
        let is_there = ends[i] != RETIRED;
        cells[i] += u32::from(last[i] != at.index[i]);
        last[i] = at.index[i];
        samples[i] += u32::from(in_brick);
        found.near[i] = u8::from(near);
        found.reached[i] = u8::from(reached);
        found.ended[i] = u8::from(is_there & (near | reached | is_last | (t[i] > ends[i])));
    }
}

/// The first root of a batch's cubics, and the normals there.
#[inline(always)]
fn solve<T: Texel>(frame: &Frame, sampler: &BrickSampler<'_, T>, n: usize, lanes: &mut NearLanes) {
    let voxel = sampler.layout().lattice.voxel;
    let per_voxel = 1.0 / voxel;
    let quantum = sampler.quantum();
    let (epsilon, footprint) = (frame.box_min_epsilon[3], 0.5 * frame.pixel);
    let mut u = [[0.0f32; LANES]; 3];
    let [dx, dy, dz] = &lanes.direction;
    let direction = [&dx[..n], &dy[..n], &dz[..n]];
    self::place(frame, sampler, direction, &lanes.t[..n], &mut u);
    let (mut at, mut corners) = (Located::default(), Corners::default());
    sampler.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
    sampler.corners(&at, n, &mut corners);
    let mut place = [[0.0f32; LANES]; 3];
    for i in 0..n {
        let s = corners.integers::<T>(i);
        let side = lanes.side[i] * quantum;
        // The interpolated distance as a polynomial of the place in the voxel.
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
        let (x, y, z) = (
            corners.fraction[0][i],
            corners.fraction[1][i],
            corners.fraction[2][i],
        );
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
        // Along the ray, from 0 to 1.
        let c0 = k0
            + kx * x
            + ky * y
            + kz * z
            + kxy * x * y
            + kyz * y * z
            + kxz * x * z
            + kxyz * x * y * z;
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
        let value = |s: f32| ((c3 * s + c2) * s + c1) * s + c0;

        // It rises and falls at most twice: the first stretch that ends below 0 holds the first root.
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
        // Regula falsi, Illinois: the end that stays counts half.
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
        let is_crossed = in_first | in_second | at_end;
        let t = lanes.t[i];
        let starts_below = c0 <= 0.0;
        let is_close = c0 < high(epsilon, footprint * t);
        let s = if starts_below | !is_crossed { 0.0 } else { s };
        let hit = starts_below | is_crossed | is_close;
        let nudge = NUDGE_VOXELS * voxel + NUDGE_SHARE * t;
        lanes.t[i] = if hit {
            t + s * leave
        } else {
            t + leave + nudge
        };
        lanes.hit[i] = u8::from(hit);

        for (place, (f, d)) in place.iter_mut().zip([(x, dx), (y, dy), (z, dz)]) {
            place[i] = low(high(f + s * d, 0.0), 1.0);
        }
    }
    let mut beyond = Beyond::default();
    if frame.normals == abi::NORMALS_SMOOTH {
        for i in 0..n {
            if lanes.hit[i] != 0 {
                let fraction = [place[0][i], place[1][i], place[2][i]];
                sampler.beyond(&at, &corners, i, fraction, &mut beyond);
            }
        }
    }
    for i in 0..n {
        let s = corners.integers::<T>(i);
        let (x, y, z) = (place[0][i], place[1][i], place[2][i]);
        // The faces' values at the place, and how the distance changes from one to the other and beyond.
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
            let own = far - near;
            own + (outer - own) * share
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
        // Where all is the same, towards the viewer.
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

// `multiversion` takes no generic functions: each has a wrapper for each type of sample.

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_i8(
    frame: &Frame,
    sampler: &BrickSampler<'_, i8>,
    steps: u32,
    wave: &mut Wave,
    range: Range<usize>,
    found: &mut Found,
) {
    step(frame, sampler, steps, wave, range, found);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_i16(
    frame: &Frame,
    sampler: &BrickSampler<'_, i16>,
    steps: u32,
    wave: &mut Wave,
    range: Range<usize>,
    found: &mut Found,
) {
    step(frame, sampler, steps, wave, range, found);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn solve_i8(frame: &Frame, sampler: &BrickSampler<'_, i8>, n: usize, lanes: &mut NearLanes) {
    solve(frame, sampler, n, lanes);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn solve_i16(frame: &Frame, sampler: &BrickSampler<'_, i16>, n: usize, lanes: &mut NearLanes) {
    solve(frame, sampler, n, lanes);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn clearances_i8(
    sampler: &BrickSampler<'_, i8>,
    points: [&[f32]; 3],
    margin: f32,
    out: &mut [f32],
) {
    sampler.distances(points, margin, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn clearances_i16(
    sampler: &BrickSampler<'_, i16>,
    points: [&[f32]; 3],
    margin: f32,
    out: &mut [f32],
) {
    sampler.distances(points, margin, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn estimates_i8(sampler: &BrickSampler<'_, i8>, points: [&[f32]; 3], out: &mut [f32]) {
    sampler.estimates(points, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn estimates_i16(sampler: &BrickSampler<'_, i16>, points: [&[f32]; 3], out: &mut [f32]) {
    sampler.estimates(points, out);
}
