//! A block of rays that march through slabs together.

use crate::camera::{slope_of, through};
use crate::tile::Tile;
use argil_abi::{self as abi, FrameUniform, Hit, Instruction};
use argil_field::{Evaluator, LANES};
use argil_math::set_indices;
use glam::Vec3;
use multiversion::multiversion;
use std::ops::Range;

/// Pixels along a block's side.
pub(super) const BLOCK: u32 = 16;
/// Rays of a block.
pub(super) const RAYS: usize = (BLOCK * BLOCK) as usize;
/// Fraction of the largest over-relaxed step along a plane.
const RELAXATION: f32 = argil_abi::RELAXATION;
/// Rays of a block that are skipped together if none advances.
const STRETCH: usize = 64;
/// Pixels along the side of a cone, cones of a block, and their maximum steps in a slab.
const CONE_SIDE: u32 = 4;
const CONES: usize = ((BLOCK / CONE_SIDE) * (BLOCK / CONE_SIDE)) as usize;
const CONE_STEPS: u32 = 16;
/// Six points around each hit.
const DIFFERENCES: usize = 6;

/// A block's rays during a step.
pub(super) struct RayLanes {
    p: [[f32; RAYS]; 3],
    d: [f32; RAYS],
    /// The rays to evaluate, if they are few.
    few: [u16; RAYS],
    few_p: [[f32; RAYS]; 3],
    few_d: [f32; RAYS],
    goes: [u8; RAYS],
    reached: [f32; RAYS],
    /// Pixels and points of hits.
    hits: Vec<(u32, Vec3)>,
}

impl Default for RayLanes {
    fn default() -> Self {
        Self {
            p: [[0.0; RAYS]; 3],
            d: [0.0; RAYS],
            few: [0; RAYS],
            few_p: [[0.0; RAYS]; 3],
            few_d: [0.0; RAYS],
            goes: [0; RAYS],
            reached: [0.0; RAYS],
            hits: Vec::new(),
        }
    }
}

/// The rays of a block, in the first `count` elements of each array. Rays that ended have infinite length.
pub(super) struct RayBlock {
    pub(super) count: usize,
    pixel: [u32; RAYS],
    direction: [[f32; RAYS]; 3],
    pub(super) t: [f32; RAYS],
    end: [f32; RAYS],
    /// 1 outside, −1 inside, 0 before the first evaluation.
    side: [f32; RAYS],
    steps: [u32; RAYS],
    /// How far a ray went beyond what was known to be free, its last distance, and how far it went with that.
    over: [f32; RAYS],
    last_gap: [f32; RAYS],
    last_way: [f32; RAYS],
    /// The cone of each ray.
    cone: [u8; RAYS],
    cones: Cones,
    /// The middle of the block, and how far its rays are from there at length 1.
    pub(super) axis: Vec3,
    pub(super) slope: f32,
}

/// Cones around 4×4 rays, which advance as far as all of them can.
#[derive(Default)]
struct Cones {
    axis: [Vec3; CONES],
    /// How far rays are from the axis at length 1.
    slope: f32,
    t: [f32; CONES],
}

impl RayBlock {
    pub(super) fn new() -> Self {
        Self {
            count: 0,
            pixel: [0; RAYS],
            direction: [[0.0; RAYS]; 3],
            t: [0.0; RAYS],
            end: [0.0; RAYS],
            side: [0.0; RAYS],
            steps: [0; RAYS],
            over: [0.0; RAYS],
            last_gap: [0.0; RAYS],
            last_way: [0.0; RAYS],
            cone: [0; RAYS],
            cones: Cones::default(),
            axis: Vec3::ZERO,
            slope: 0.0,
        }
    }

    /// Sets the middle and the cones of the block whose first pixel has a position in the image.
    pub(super) fn aim(&mut self, frame: &FrameUniform, [x, y]: [f32; 2]) {
        let middle = 0.5 * BLOCK as f32;
        self.count = 0;
        self.axis = through(frame, x + middle, y + middle);
        self.slope = slope_of(frame, BLOCK);
        self.cones.slope = slope_of(frame, CONE_SIDE);
        for (k, axis) in (0u32..).zip(&mut self.cones.axis) {
            let place = |k: u32| (k as f32 + 0.5) * CONE_SIDE as f32;
            let across = BLOCK / CONE_SIDE;
            *axis = through(frame, x + place(k % across), y + place(k / across));
        }
    }

    /// Loads the rays of some pixels, whose first has a position in the block.
    pub(super) fn push_row(
        &mut self,
        starts: &crate::ray_batch::RaySetup,
        row: Range<usize>,
        [x, y]: [u32; 2],
    ) {
        let to = self.count..self.count + row.len();
        for (lanes, from) in self.direction.iter_mut().zip(&starts.direction) {
            lanes[to.clone()].copy_from_slice(&from[row.clone()]);
        }
        self.t[to.clone()].copy_from_slice(&starts.near[row.clone()]);
        self.end[to.clone()].copy_from_slice(&starts.far[row.clone()]);
        self.side[to.clone()].fill(0.0);
        self.steps[to.clone()].fill(0);
        self.over[to.clone()].fill(0.0);
        self.last_way[to.clone()].fill(0.0);
        for (pixel, i) in self.pixel[to.clone()].iter_mut().zip(row) {
            *pixel = i as u32;
        }
        for (cone, x) in self.cone[to.clone()].iter_mut().zip(x..) {
            *cone = (y / CONE_SIDE * (BLOCK / CONE_SIDE) + x / CONE_SIDE) as u8;
        }
        self.count = to.end;
    }
}

impl RayBlock {
    /// Marches to the end of a slab with a program.
    #[expect(clippy::too_many_arguments, reason = "a tile's whole context")]
    pub(super) fn march(
        &mut self,
        frame: &FrameUniform,
        tile: Tile,
        (begin, end): (f32, f32),
        list: &[Instruction],
        evaluator: &mut Evaluator<'_>,
        lanes: &mut RayLanes,
        out: &mut [Hit],
    ) {
        let n = self.count;
        enter(self, begin);
        self.march_cones(frame, end, list, evaluator);
        lanes.hits.clear();
        loop {
            let going = place(self, frame, end, lanes);
            if going == 0 {
                break;
            }
            if 4 * going > 3 * n {
                evaluate(list, &lanes.p, n, evaluator, &mut lanes.d);
            } else {
                // Only rays before the end of the slab.
                list_active(lanes);
                let few = &lanes.few[..going];
                for (from, to) in lanes.p.iter().zip(lanes.few_p.iter_mut()) {
                    for (to, &i) in to.iter_mut().zip(few.iter()) {
                        *to = from[usize::from(i) % RAYS];
                    }
                }
                evaluate(list, &lanes.few_p, going, evaluator, &mut lanes.few_d);
                for (&i, distance) in few.iter().zip(lanes.few_d.iter()) {
                    lanes.d[usize::from(i) % RAYS] = *distance;
                }
            }
            if step(self, frame, end, lanes) {
                self.end_rays(frame, lanes, out);
            }
        }
        if !lanes.hits.is_empty() {
            normals(frame, tile, &lanes.hits, list, evaluator, out);
        }
    }

    /// Advances the rays of each cone as far as all of them can, from outside: if the axis is at length t, a free sphere
    /// of radius D around it is free for its rays up to (t + D) / (1 + slope).
    fn march_cones(
        &mut self,
        frame: &FrameUniform,
        end: f32,
        list: &[Instruction],
        evaluator: &mut Evaluator<'_>,
    ) {
        let n = self.count;
        let Cones { axis, slope, t } = &mut self.cones;
        t.fill(f32::INFINITY);
        for (&ray_t, &cone) in self.t[..n].iter().zip(&self.cone) {
            let t = &mut t[usize::from(cone)];
            *t = t.min(ray_t);
        }
        let (eye, first) = (Vec3::from(frame.eye), *t);
        let mut under_way: [usize; CONES] = std::array::from_fn(|cone| cone);
        let mut count = CONES;
        for _ in 0..CONE_STEPS {
            let mut kept = 0;
            for k in 0..count {
                if t[under_way[k]] < end {
                    under_way[kept] = under_way[k];
                    kept += 1;
                }
            }
            count = kept;
            if count == 0 {
                break;
            }
            let (mut p, mut d) = ([[0.0; CONES]; 3], [0.0; CONES]);
            for (k, &cone) in under_way[..count].iter().enumerate() {
                let at = eye + axis[cone] * t[cone];
                (p[0][k], p[1][k], p[2][k]) = (at.x, at.y, at.z);
            }
            let [x, y, z] = p.each_ref().map(|lanes| &lanes[..count]);
            evaluator.distances_with(list, x, y, z, &mut d[..count]);
            kept = 0;
            for k in 0..count {
                let cone = under_way[k];
                let next = (t[cone] + d[k] * frame.inv_lipschitz) / (1.0 + *slope);
                let gain = next - t[cone];
                if gain > 0.0 {
                    t[cone] = next.min(end);
                }
                if gain > 0.5 * *slope * next {
                    under_way[kept] = cone;
                    kept += 1;
                }
            }
            count = kept;
        }
        for i in 0..n {
            let cone = usize::from(self.cone[i]);
            if t[cone] > first[cone] && self.t[i] < t[cone] && self.side[i] >= 0.0 {
                // A ray that leaves the box on its way misses.
                let misses = t[cone] > self.end[i];
                self.t[i] = if misses { f32::INFINITY } else { t[cone] };
                (self.side[i], self.last_way[i]) = (1.0, 0.0);
            }
        }
    }

    /// Writes what was hit.
    fn end_rays(&mut self, frame: &FrameUniform, lanes: &mut RayLanes, out: &mut [Hit]) {
        let [ex, ey, ez] = frame.eye;
        for (goes, reached) in lanes.goes.iter_mut().zip(&lanes.reached) {
            *goes = u8::from(*reached > 0.0);
        }
        for i in set_indices(&lanes.goes) {
            let hit = &mut out[self.pixel[i] as usize];
            hit.kind = if self.side[i] < 0.0 {
                abi::HIT_INSIDE
            } else {
                abi::HIT_OUTSIDE
            };
            let t = self.t[i];
            hit.normal_t[3] = t;
            self.t[i] = f32::INFINITY;
            let [x, y, z] = &self.direction;
            let p = Vec3::new(ex + x[i] * t, ey + y[i] * t, ez + z[i] * t);
            lanes.hits.push((self.pixel[i], p));
        }
    }

    /// Writes how many steps each ray took.
    pub(super) fn finish(&self, out: &mut [Hit]) {
        for (&pixel, &steps) in self.pixel.iter().zip(&self.steps).take(self.count) {
            if steps > 0 {
                out[pixel as usize].steps = steps;
            }
        }
    }
}

/// Lists the rays that advance. Without branches: each index is written, and counts if its ray advances.
#[inline(always)]
fn list_active(lanes: &mut RayLanes) {
    let mut n = 0;
    for (k, goes) in lanes.goes.as_chunks::<8>().0.iter().enumerate() {
        if u64::from_le_bytes(*goes) == 0 {
            continue;
        }
        for (i, &goes) in goes.iter().enumerate() {
            lanes.few[n % RAYS] = (8 * k + i) as u16;
            n += usize::from(goes);
        }
    }
}

/// Evaluates the first `n` of some points with a program.
fn evaluate(
    list: &[Instruction],
    p: &[[f32; RAYS]; 3],
    n: usize,
    evaluator: &mut Evaluator<'_>,
    d: &mut [f32; RAYS],
) {
    for first in (0..n).step_by(LANES) {
        let r = first..(first + LANES).min(n);
        let [x, y, z] = p;
        let out = &mut d[r.clone()];
        evaluator.distances_with(list, &x[r.clone()], &y[r.clone()], &z[r], out);
    }
}

/// Advances to the start of a slab, because nothing is in between.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn enter(block: &mut RayBlock, begin: f32) {
    let n = block.count.min(RAYS);
    for (t, end) in block.t[..n].iter_mut().zip(&block.end[..n]) {
        let from = if *t < begin { begin } else { *t };
        *t = if from > *end { f32::INFINITY } else { from };
    }
}

/// Computes the positions of rays, and which are before the end of a slab. Returns their number.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn place(block: &RayBlock, frame: &FrameUniform, end: f32, lanes: &mut RayLanes) -> usize {
    let n = block.count.min(RAYS);
    let t = &block.t[..n];
    let mut going = 0u32;
    for (goes, &t) in lanes.goes[..n].iter_mut().zip(t) {
        *goes = u8::from(t < end);
        going += u32::from(*goes);
    }
    lanes.goes[n..].fill(0);
    for (axis, p) in lanes.p.iter_mut().enumerate() {
        let eye = frame.eye[axis];
        let lanes = block.direction[axis][..n].iter().zip(t);
        for (p, (direction, &t)) in p[..n].iter_mut().zip(lanes) {
            // A ray that ended is anywhere.
            let t = if t < f32::MAX { t } else { 0.0 };
            *p = eye + direction * t;
        }
    }
    going as usize
}

/// Takes one step of the rays that advance. Returns whether any hits.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step(block: &mut RayBlock, frame: &FrameUniform, slab_end: f32, lanes: &mut RayLanes) -> bool {
    let (epsilon, close_slope, scale) = (frame.epsilon, frame.close_slope, frame.inv_lipschitz);
    let (pixel, max_steps) = (frame.pixel_width, frame.max_steps);
    let mut any = 0u32;
    for k in 0..RAYS / STRETCH {
        let goes = &lanes.goes.as_chunks::<STRETCH>().0[k];
        let reached = &mut lanes.reached.as_chunks_mut::<STRETCH>().0[k];
        if goes.iter().all(|&goes| goes == 0) {
            reached.fill(0.0);
            continue;
        }
        let d = &lanes.d.as_chunks::<STRETCH>().0[k];
        let end = &block.end.as_chunks::<STRETCH>().0[k];
        let t = &mut block.t.as_chunks_mut::<STRETCH>().0[k];
        let side = &mut block.side.as_chunks_mut::<STRETCH>().0[k];
        let steps = &mut block.steps.as_chunks_mut::<STRETCH>().0[k];
        let over = &mut block.over.as_chunks_mut::<STRETCH>().0[k];
        let last_gap = &mut block.last_gap.as_chunks_mut::<STRETCH>().0[k];
        let last_way = &mut block.last_way.as_chunks_mut::<STRETCH>().0[k];
        for i in 0..STRETCH {
            let goes = t[i] < slab_end;
            let sign = if d[i] < 0.0 { -1.0 } else { 1.0 };
            let sign = if side[i] == 0.0 { sign } else { side[i] };
            let gap = d[i] * sign;
            let taken = steps[i] + 1;
            let spent = taken >= max_steps;
            // The spheres no longer touch: return to the end of the last one.
            let way = gap * scale;
            let too_far = (over[i] > 0.0) & (way < over[i]);
            // A ray that grazes the surface may run out of steps within a pixel of it.
            let close = f32::from(u8::from(taken > abi::EXACT_STEPS)) * close_slope * t[i];
            let close = if close > epsilon { close } else { epsilon };
            let arrives = !too_far & ((gap < close) | (spent & (gap < pixel * t[i])));
            // Along a plane, spheres still touch with this additional distance between their centers.
            let (before, fell) = (last_way[i], last_gap[i] - gap);
            let fell = if fell > 0.0 { fell } else { 0.0 };
            let sum = before + fell;
            let share = (before - fell) / (if sum > 0.0 { sum } else { 1.0 });
            let share = if share > 0.0 { share } else { 0.0 };
            let more = RELAXATION * way * share;
            // Beyond the end of the slab, or of the box, nothing would tell whether they do.
            let beyond = t[i] + way + more;
            let is_kept = !too_far & (beyond < slab_end) & (beyond <= end[i]);
            let more = if is_kept { more } else { 0.0 };
            let moved = if too_far { -over[i] } else { way + more };
            let next = t[i] + moved;
            let misses = !arrives & (spent | (next > end[i]));
            let next = if misses { f32::INFINITY } else { next };
            let way = if too_far { 0.0 } else { way + more };
            side[i] = if goes { sign } else { side[i] };
            steps[i] = if goes { taken } else { steps[i] };
            over[i] = if goes { more } else { over[i] };
            last_gap[i] = if goes { gap } else { last_gap[i] };
            last_way[i] = if goes { way } else { last_way[i] };
            t[i] = if goes { next } else { t[i] };
            let hits = goes & arrives;
            reached[i] = if hits { 1.0 } else { 0.0 };
        }
        any |= reached.iter().fold(0, |bits, hit| bits | hit.to_bits());
    }
    any != 0
}

/// Computes the normals of hits by central differences, with a program for the points around them.
fn normals(
    frame: &FrameUniform,
    tile: Tile,
    hits: &[(u32, Vec3)],
    list: &[Instruction],
    evaluator: &mut Evaluator<'_>,
    out: &mut [Hit],
) {
    let bias = frame.normal_bias;
    let [mut x, mut y, mut z, mut d] = [[0.0f32; LANES]; 4];
    for part in hits.chunks(LANES / DIFFERENCES) {
        let places = x
            .as_chunks_mut::<DIFFERENCES>()
            .0
            .iter_mut()
            .zip(y.as_chunks_mut::<DIFFERENCES>().0)
            .zip(z.as_chunks_mut::<DIFFERENCES>().0);
        for (((x, y), z), &(_, p)) in places.zip(part) {
            let (low, high) = (p - bias, p + bias);
            *x = [high.x, low.x, p.x, p.x, p.x, p.x];
            *y = [p.y, p.y, high.y, low.y, p.y, p.y];
            *z = [p.z, p.z, p.z, p.z, high.z, low.z];
        }
        let n = part.len() * DIFFERENCES;
        evaluator.distances_with(list, &x[..n], &y[..n], &z[..n], &mut d[..n]);
        for (&(pixel, _), d) in part.iter().zip(d.as_chunks::<DIFFERENCES>().0) {
            crate::trace::set_normal(frame, tile, pixel, d, out);
        }
    }
}
