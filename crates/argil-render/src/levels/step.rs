//! One step of a batch of rays, each with its own voxel size.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::notes::PageNotes;
use crate::both_formats::of_both_formats;
use crate::bricks::step::{
    NEAR_VOXELS, NUDGE_RELATIVE, NUDGE_VOXELS, RayMotion, RayReading, StepOutcome, begin, high,
    low, tiny,
};
use crate::bricks::voxel_intersect::{NearLanes, VoxelMeasures, normals, roots};
use crate::ray_batch::{RETIRED, RayBatch};
use argil_abi::{self as abi, FrameUniform};
use argil_field::LANES;
use argil_math::set_indices;
use argil_volume::{LevelLanes, LevelSampler, NeighborPlanes, Texel, VoxelSamples, is_brick};
use std::ops::Range;

/// The part of a level over which its border with the next one is dithered.
const DITHER: f32 = argil_abi::LEVEL_DITHER;

/// Returns a factor around 1 that differs from pixel to pixel.
#[inline(always)]
fn dither(pixel: u32) -> f32 {
    let hash = pixel.wrapping_mul(0x9e37_79b9);
    let hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    let share = (hash >> 8) as f32 * (1.0 / 16_777_216.0);
    1.0 + DITHER * (share - 0.5)
}

/// Finds the pages of rays. `size` is the edge of a voxel at length 1.
#[inline(always)]
fn locate<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    size: f32,
    (direction, t, pixel): ([&[f32]; 3], &[f32], &[u32]),
    lanes: &mut LevelLanes,
) {
    let n = t.len();
    let mut u = [[0.0f32; LANES]; 3];
    let mut wanted = [0u32; LANES];
    for axis in 0..3 {
        for i in 0..n {
            u[axis][i] = sampler.position(axis, direction[axis][i] * t[i]);
        }
    }
    for i in 0..n {
        wanted[i] = sampler.level_of(size * t[i] * dither(pixel[i]));
    }
    sampler.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &wanted[..n], lanes);
}

/// Reads the stored distance at each ray.
#[inline(always)]
fn gaps<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    lanes: &LevelLanes,
    corners: &VoxelSamples,
    gap: &mut [f32],
) {
    let quantum = sampler.quantum();
    for i in 0..gap.len() {
        gap[i] = if is_brick(lanes.at.word[i]) {
            corners.value::<T>(i) * quantum * lanes.voxel[i]
        } else {
            sampler.empty_cell_distance(lanes, i)
        };
    }
}

/// Computes how far each ray is from the end of its cell.
#[inline(always)]
fn leaves(lanes: &LevelLanes, direction: [&[f32]; 3], n: usize, leave: &mut [f32; LANES]) {
    for axis in 0..3 {
        let d = direction[axis];
        for i in 0..n {
            let d = tiny(d[i]);
            let ahead = if d > 0.0 { 8.0 } else { 0.0 };
            let way = (ahead - lanes.at.inner[axis][i]) * lanes.voxel[i] / d;
            leave[i] = low(leave[i], way);
        }
    }
}

/// Takes one step of a batch of rays.
#[inline(always)]
fn step<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    frame: &FrameUniform,
    (size, steps): (f32, u32),
    wave: &mut RayBatch,
    range: Range<usize>,
    (lanes, notes): (&mut LevelLanes, &mut PageNotes),
    found: &mut StepOutcome,
) {
    let n = range.len();
    let scale = frame.inv_lipschitz;
    let error = sampler.error_voxels();
    let (is_first, is_last) = (steps == 1, steps >= frame.max_steps);
    let [dx, dy, dz] = &wave.direction;
    let direction = [&dx[range.clone()], &dy[range.clone()], &dz[range.clone()]];
    let (t, ends) = (&mut wave.t[range.clone()], &wave.end[range.clone()]);
    let pages = &mut wave.page[range.clone()];
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
    let pixel = &wave.pixel[range.clone()];
    let last = &mut wave.level[range];
    lanes.page[..n].copy_from_slice(pages);
    locate(sampler, size, (direction, t, pixel), lanes);
    let mut corners = VoxelSamples::default();
    sampler.voxel_samples(&lanes.at, n, &mut corners);
    let mut is_new = [0u8; LANES];
    for i in 0..n {
        let is_other = (lanes.at.index[i] != last[i]) | (lanes.gap[i] > 0.0) | is_first;
        is_new[i] = u8::from(is_other & (ends[i] != RETIRED));
    }
    for i in set_indices(&is_new) {
        notes.note(sampler, lanes, i, t[i]);
    }
    pages.copy_from_slice(&lanes.page[..n]);

    let (mut gap, mut leave) = ([0.0f32; LANES], [f32::MAX; LANES]);
    gaps(sampler, lanes, &corners, &mut gap[..n]);
    if is_first {
        last.fill(u32::MAX);
        begin(&gap[..n], side);
    }
    leaves(lanes, direction, n, &mut leave);
    for i in 0..n {
        let voxel = lanes.voxel[i];
        let in_brick = is_brick(lanes.at.word[i]);
        // In a page that is too coarse, the surface may be nearer than interpolated.
        let is_coarse = in_brick & (lanes.gap[i] > 0.0);
        let g = gap[i] * side[i] - if is_coarse { error * voxel } else { 0.0 };
        let nudge = NUDGE_VOXELS * voxel + NUDGE_RELATIVE * t[i];
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
        cells[i] += u32::from(last[i] != lanes.at.index[i]);
        last[i] = lanes.at.index[i];
        samples[i] += u32::from(in_brick);
        found.near[i] = u8::from(near);
        found.reached[i] = u8::from(reached);
        found.ended[i] = u8::from(is_there & (near | reached | is_last | (t[i] > ends[i])));
    }
}

/// Solves a batch's cubics for their first roots, and computes the normals there.
#[inline(always)]
fn solve<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    frame: &FrameUniform,
    (size, pixels): (f32, &[u32]),
    rays: &mut NearLanes,
    (lanes, notes): (&mut LevelLanes, &mut PageNotes),
) {
    let n = pixels.len();
    let [dx, dy, dz] = &rays.direction;
    let direction = [&dx[..n], &dy[..n], &dz[..n]];
    locate(sampler, size, (direction, &rays.t[..n], pixels), lanes);
    let mut corners = VoxelSamples::default();
    sampler.voxel_samples(&lanes.at, n, &mut corners);
    let mut measures = VoxelMeasures {
        voxel: [1.0; LANES],
        quantum: [1.0; LANES],
        close: [0.0; LANES],
        nudge: [0.0; LANES],
    };
    let (quantum, error) = (sampler.quantum(), sampler.error_voxels());
    for i in 0..n {
        let (voxel, t) = (lanes.voxel[i], rays.t[i]);
        let off = if lanes.gap[i] > 0.0 {
            error * voxel
        } else {
            0.0
        };
        measures.voxel[i] = voxel;
        measures.quantum[i] = quantum * voxel;
        measures.nudge[i] = NUDGE_VOXELS * voxel + NUDGE_RELATIVE * t;
        measures.close[i] = frame.epsilon + off;
    }
    let mut hit = [[0.0f32; LANES]; 3];
    roots::<T>(&measures, &corners, n, rays, &mut hit);
    for i in (0..n).filter(|&i| rays.hit[i] != 0) {
        notes.hits += 1;
        let is_coarse = lanes.gap[i] > 0.0 && lanes.voxel[i] > 2.0 * size * rays.t[i];
        notes.coarse += u64::from(is_coarse);
    }
    let mut beyond = NeighborPlanes::default();
    if frame.normals == abi::NORMALS_SMOOTH {
        for i in 0..n {
            if rays.hit[i] != 0 {
                let fraction = [hit[0][i], hit[1][i], hit[2][i]];
                let asked = &mut notes.asked;
                sampler.neighbor_planes(lanes, &corners, i, fraction, &mut beyond, asked);
            }
        }
    }
    normals::<T>(&corners, &beyond, &hit, n, rays);
}

/// Computes lower bounds of the signed distance around points in the scene's space.
#[inline(always)]
fn clearances<T: Texel>(
    sampler: &LevelSampler<'_, T>,
    (eye, size): ([f32; 3], f32),
    points: [&[f32]; 3],
    t: &[f32],
    (lanes, notes): (&mut LevelLanes, &mut PageNotes),
    out: &mut [f32],
) {
    let n = out.len();
    let mut u = [[0.0f32; LANES]; 3];
    let mut wanted = [0u32; LANES];
    for axis in 0..3 {
        for i in 0..n {
            u[axis][i] = sampler.position(axis, points[axis][i] - eye[axis]);
        }
    }
    for i in 0..n {
        wanted[i] = sampler.level_of(size * t[i]);
    }
    sampler.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &wanted[..n], lanes);
    let mut corners = VoxelSamples::default();
    sampler.voxel_samples(&lanes.at, n, &mut corners);
    let (quantum, error) = (sampler.quantum(), sampler.error_voxels());
    for i in 0..n {
        notes.note(sampler, lanes, i, t[i]);
        let voxel = lanes.voxel[i];
        let d = corners.value::<T>(i) * quantum * voxel;
        let length = high(d.abs() - error * voxel, 0.0);
        out[i] = if is_brick(lanes.at.word[i]) {
            if d < 0.0 { -length } else { length }
        } else {
            sampler.empty_cell_distance(lanes, i)
        };
    }
}

of_both_formats! {
    LevelSampler;
    step: step_i8, step_i16(
        frame: &FrameUniform,
        sizes: (f32, u32),
        wave: &mut RayBatch,
        range: Range<usize>,
        notes: (&mut LevelLanes, &mut PageNotes),
        found: &mut StepOutcome,
    );
    solve: solve_i8, solve_i16(
        frame: &FrameUniform,
        sizes: (f32, &[u32]),
        rays: &mut NearLanes,
        notes: (&mut LevelLanes, &mut PageNotes),
    );
    clearances: clearances_i8, clearances_i16(
        eye: ([f32; 3], f32),
        points: [&[f32]; 3],
        t: &[f32],
        notes: (&mut LevelLanes, &mut PageNotes),
        out: &mut [f32],
    );
}
