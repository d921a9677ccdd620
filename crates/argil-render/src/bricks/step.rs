//! One step of a batch of rays.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use crate::ray_batch::{RETIRED, RayBatch};
use argil_abi::FrameUniform;
use argil_field::LANES;
use argil_volume::{
    BLOCK_SIDE, BrickSampler, CellLocations, Texel, VoxelSamples, is_block_empty, is_brick,
};
use multiversion::multiversion;
use std::ops::Range;

/// Below this distance in voxels, a ray looks for the surface in its voxel.
pub(crate) const NEAR_VOXELS: f32 = argil_abi::NEAR_VOXELS;
/// Fraction of the largest over-relaxed step along a plane.
const RELAXATION: f32 = argil_abi::RELAXATION;
/// A ray that leaves a cell or a voxel advances by this many voxels, and by a fraction of its length, to be inside
/// the next.
pub(crate) const NUDGE_VOXELS: f32 = argil_abi::NUDGE_VOXELS;
pub(crate) const NUDGE_RELATIVE: f32 = argil_abi::NUDGE_RELATIVE;

/// And by a fraction of its position in voxels, in a world so wide that rounding exceeds that.
const NUDGE_POSITION: f32 = argil_abi::NUDGE_POSITION;

/// Returns how far beyond a voxel a ray must advance, given the rounding of its position.
#[inline(always)]
pub(super) fn nudge_for(place: [f32; 3], voxel: f32) -> f32 {
    let [x, y, z] = place.map(f32::abs);
    NUDGE_POSITION * high(x, high(y, z)) * voxel
}

/// The result of a step for a batch, 1 for each ray.
pub(crate) struct StepOutcome {
    pub near: [u8; LANES],
    pub reached: [u8; LANES],
    pub ended: [u8; LANES],
}

/// Computes the positions of rays, in voxels from the volume's corner.
#[inline(always)]
pub(super) fn place<T: Texel>(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, T>,
    direction: [&[f32]; 3],
    t: &[f32],
    out: &mut [[f32; LANES]; 3],
) {
    let voxel_grid = &sampler.layout().voxel_grid();
    let per_voxel = 1.0 / voxel_grid.voxel_size;
    for axis in 0..3 {
        let (eye, corner) = (frame.eye[axis], voxel_grid.corner[axis]);
        for ((u, d), t) in out[axis].iter_mut().zip(direction[axis]).zip(t) {
            *u = (eye + d * t - corner) * per_voxel;
        }
    }
}

#[inline(always)]
pub(crate) fn tiny(d: f32) -> f32 {
    if d.abs() < 1e-20 { 1e-20 } else { d }
}

#[inline(always)]
pub(crate) fn low(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(crate) fn high(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Reads the stored distance at each ray.
#[inline(always)]
fn gaps<T: Texel>(
    sampler: &BrickSampler<'_, T>,
    at: &CellLocations,
    corners: &VoxelSamples,
    gap: &mut [f32],
) {
    let quantum = sampler.quantum();
    for i in 0..gap.len() {
        gap[i] = if is_brick(at.word[i]) {
            corners.value::<T>(i) * quantum
        } else {
            sampler.empty_cell_distance(at, i)
        };
    }
}

/// Determines on which side of the surface each ray begins. A ray that enters the volume through a clipped solid
/// hits there. A ray that starts inside continues.
#[inline(always)]
pub(crate) fn begin(gap: &[f32], side: &mut [f32]) {
    for i in 0..gap.len() {
        let from_outside = side[i] > 1.0;
        side[i] = if (gap[i] < 0.0) & !from_outside {
            -1.0
        } else {
            1.0
        };
    }
}

/// Computes how far each ray is from the end of its cell, its block, or the empty cube around that, and the
/// rounding to add.
#[inline(always)]
fn leaves<T: Texel>(
    sampler: &BrickSampler<'_, T>,
    at: &CellLocations,
    u: &[[f32; LANES]; 3],
    direction: [&[f32]; 3],
    n: usize,
    leave: &mut [f32; LANES],
    rounding: &mut [f32; LANES],
) {
    let layout = sampler.layout();
    let (voxel, brick) = (
        layout.voxel_grid().voxel_size,
        layout.brick_size_voxels() as f32,
    );
    leave[..n].fill(f32::MAX);
    let block = BLOCK_SIDE as f32;
    let mut edges = [1.0f32; LANES];
    for i in 0..n {
        edges[i] = if is_block_empty(at.word[i]) {
            block
        } else {
            1.0
        };
    }
    if sampler.has_levels() {
        for i in 0..n {
            edges[i] = high(edges[i], sampler.empty_cells(at, i) as f32);
            rounding[i] = nudge_for([u[0][i], u[1][i], u[2][i]], voxel);
        }
    }
    for axis in 0..3 {
        let (cells, u, d) = (&at.cell[axis][..n], &u[axis][..n], &direction[axis][..n]);
        for i in 0..n {
            let edge = edges[i];
            let begin = (cells[i] * (1.0 / edge)).floor() * edge;
            let d = tiny(d[i]);
            let ahead = if d > 0.0 { begin + edge } else { begin };
            leave[i] = low(leave[i], (ahead * brick - u[i]) * voxel / d);
        }
    }
}

/// What a ray reads at its position.
pub(crate) struct RayReading {
    /// The distance to the surface, positive on the ray's side.
    pub gap: f32,
    /// Below this distance, the ray looks for the surface in its voxel.
    pub close: f32,
    pub in_brick: bool,
    /// How far it may advance outside a brick.
    pub empty_way: f32,
}

/// What a step of a ray changes: its length, and what it remembers of the last step.
pub(crate) struct RayMotion<'a> {
    pub t: &'a mut f32,
    pub over: &'a mut f32,
    pub last_gap: &'a mut f32,
    pub last_way: &'a mut f32,
}

impl RayMotion<'_> {
    /// Advances a ray that ends at length `end`. Returns whether it is near the surface in a brick, and whether it
    /// reached the solid outside of one. `scale` is the reciprocal of the Lipschitz constant.
    #[inline(always)]
    pub(crate) fn advance(self, read: &RayReading, scale: f32, end: f32) -> (bool, bool) {
        let (g, in_brick) = (read.gap, read.in_brick);
        // The spheres no longer touch: return to the end of the last one.
        let too_far = (*self.over > 0.0) & (g < *self.over);
        let near = in_brick & (g < read.close) & !too_far;
        let reached = !in_brick & (g < 0.0) & !too_far;
        // Along a plane, spheres still touch with this additional distance between their centers.
        let (before, fell) = (*self.last_way, high(*self.last_gap - g, 0.0));
        let sum = before + fell;
        let share = high((before - fell) / (if sum > 0.0 { sum } else { 1.0 }), 0.0);
        let more = RELAXATION * g * share * scale;
        let beyond = if in_brick & !too_far { more } else { 0.0 };
        let moved = if in_brick {
            g * scale + beyond
        } else {
            read.empty_way
        };
        let moved = if too_far { -*self.over } else { moved };
        let stays = near | reached;
        let over = if stays { 0.0 } else { beyond };
        let tells = in_brick & !too_far & !stays;
        let way = if tells { moved } else { 0.0 };
        let t = *self.t + if stays { 0.0 } else { moved };
        // Beyond the ray's end, it must not go farther than what is known to be free, or it would miss what is
        // there.
        let pull = low(high(t - end, 0.0), over);
        *self.last_gap = g;
        *self.t = t - pull;
        *self.over = over - pull;
        *self.last_way = high(way - pull, 0.0);
        (near, reached)
    }
}

/// Takes one step of a batch of rays.
#[inline(always)]
fn step<T: Texel>(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, T>,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut StepOutcome,
) {
    let n = range.len();
    let layout = sampler.layout();
    let voxel = layout.voxel_grid().voxel_size;
    let scale = frame.inv_lipschitz;
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
    let (mut at, mut corners) = (CellLocations::default(), VoxelSamples::default());
    sampler.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
    sampler.voxel_samples(&at, n, &mut corners);

    let (mut gap, mut leave) = ([0.0f32; LANES], [0.0f32; LANES]);
    let gap = &mut gap[..n];
    gaps(sampler, &at, &corners, gap);
    if is_first {
        last.fill(u32::MAX);
        begin(gap, side);
    }
    let mut rounding = [0.0f32; LANES];
    leaves(sampler, &at, &u, direction, n, &mut leave, &mut rounding);
    for i in 0..n {
        let g = gap[i] * side[i];
        let in_brick = is_brick(at.word[i]);
        let nudge = NUDGE_VOXELS * voxel + NUDGE_RELATIVE * t[i] + rounding[i];
        let empty_way = high(g * scale, leave[i] + nudge);
        let close = NEAR_VOXELS * voxel;
        let motion = RayMotion {
            t: &mut t[i],
            over: &mut over[i],
            last_gap: &mut last_gap[i],
            last_way: &mut last_way[i],
        };
        let read = RayReading {
            gap: g,
            close,
            in_brick,
            empty_way,
        };
        let (near, reached) = motion.advance(&read, scale, ends[i]);
        let is_there = ends[i] != RETIRED;
        cells[i] += u32::from(last[i] != at.index[i]);
        last[i] = at.index[i];
        samples[i] += u32::from(in_brick);
        found.near[i] = u8::from(near);
        found.reached[i] = u8::from(reached);
        found.ended[i] = u8::from(is_there & (near | reached | is_last | (t[i] > ends[i])));
    }
}

// `multiversion` does not accept generic functions, so each sample type has a wrapper.

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn step_i8(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, i8>,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut StepOutcome,
) {
    step(frame, sampler, steps, wave, range, found);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn step_i16(
    frame: &FrameUniform,
    sampler: &BrickSampler<'_, i16>,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut StepOutcome,
) {
    step(frame, sampler, steps, wave, range, found);
}
