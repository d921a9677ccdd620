//! Primary rays through the field. `trace.wgsl` is the twin.

use crate::camera::{clip_normal, primary_ray};
use crate::probe::FieldProbe;
use crate::ray_batch::{Points, RETIRED, RayBatch, RaySetup};
use crate::source::{RayTracer, RenderSource};
use crate::tile::{TILE_WIDTH, Tile};
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, EXACT_STEPS, FrameUniform, Hit, RELAXATION};
use argil_field::LANES;
use argil_math::{Ray, set_indices};
use glam::Vec3;
use multiversion::multiversion;

/// Six points around each, two along each axis.
const DIFFERENCES: usize = 6;

/// The field without pruning, as a GPU marches through it: the reference for pruning.
#[derive(Debug)]
pub struct UnprunedField;

impl RenderSource for UnprunedField {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        Some(Box::new(Self))
    }
}

impl RayTracer for UnprunedField {
    fn needs_field(&self, _: u32) -> bool {
        false
    }

    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_tile(frame, tile, probe, scratch, out);
    }
}

/// Traces the primary ray of each pixel of a tile into `out`, row by row.
///
/// # Panics
/// If `out` is shorter than the tile's area.
pub(crate) fn trace_tile(
    frame: &FrameUniform,
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    scratch: &mut TileScratch,
    out: &mut [Hit],
) {
    let TileScratch {
        starts,
        wave,
        points,
        hits,
        ..
    } = scratch;
    let eye = Vec3::from(frame.eye);

    // Start the rays that meet the box.
    hits.clear();
    start_rays(frame, tile, starts, wave, out);

    // March until every ray has hit, left the box, or used its steps.
    let (mut steps, batch) = (0, probe.batch());
    while wave.len() > 0 {
        steps += 1;
        let count = wave.len();
        for first in (0..count).step_by(batch) {
            let range = first..first + batch.min(count - first);
            points.clear();
            let Points { x, y, z, .. } = points;
            for (k, p) in [x, y, z].into_iter().enumerate() {
                let (t, direction) = (&wave.t[range.clone()], &wave.direction[k][range.clone()]);
                let places = t.iter().zip(direction);
                p.extend(places.map(|(t, direction)| eye[k] + direction * t));
            }
            probe.measure(points);
            for (d, first) in points.d.chunks(LANES).zip(range.step_by(LANES)) {
                let found = step(wave, first, frame, d, steps);
                end_rays(wave, first, steps, &found, hits, out);
            }
        }
        // A ray that left the box is near nothing.
        if probe.is_near() {
            wave.close();
        } else {
            wave.compact();
        }
    }

    // Normals by central differences.
    central_difference_points(frame, tile, hits, points, out);
    probe.measure(points);
    set_normals(frame, tile, hits, points, out);
    intersect_ground(frame, tile, out);
}

/// Takes one step of the rays from `first` on, whose distances are known. Then looks at those that end with it.
fn step(
    wave: &mut RayBatch,
    first: usize,
    frame: &FrameUniform,
    d: &[f32],
    steps: u32,
) -> TraceState {
    let range = first..first + d.len();
    let (t, end) = (&mut wave.t[range.clone()], &wave.end[range.clone()]);
    let over = &mut wave.over[range.clone()];
    let last_gap = &mut wave.last_gap[range.clone()];
    let last_way = &mut wave.last_way[range.clone()];
    let side = &mut wave.side[range];
    let spent = steps >= frame.max_steps;
    let close_slope = if steps > EXACT_STEPS {
        frame.close_slope
    } else {
        0.0
    };
    if steps == 1 {
        for (side, &d) in side.iter_mut().zip(d) {
            *side = if d < 0.0 { -1.0 } else { 1.0 };
        }
    }
    let mut found = TraceState::default();
    for i in 0..d.len() {
        let gap = d[i] * side[i];
        let way = gap * frame.inv_lipschitz;
        // The spheres no longer touch: return to the end of the last one.
        let too_far = (over[i] > 0.0) & (way < over[i]);
        // A ray that grazes the surface may run out of steps within a pixel of it.
        let close = close_slope * t[i];
        let close = if close > frame.epsilon {
            close
        } else {
            frame.epsilon
        };
        let near = (gap < close) | (spent & (gap < frame.pixel_width * t[i]));
        let arrives = !too_far & near;
        // Along a plane, spheres still touch with this additional distance between their centers.
        let (before, fell) = (last_way[i], last_gap[i] - gap);
        let fell = if fell > 0.0 { fell } else { 0.0 };
        let sum = before + fell;
        let share = (before - fell) / (if sum > 0.0 { sum } else { 1.0 });
        let more = RELAXATION * way * (if share > 0.0 { share } else { 0.0 });
        // Beyond the box, nothing would tell whether they do.
        let is_kept = !too_far & (t[i] + way + more <= end[i]);
        let more = if is_kept { more } else { 0.0 };
        let moved = if too_far { -over[i] } else { way + more };
        t[i] += if arrives { way } else { moved };
        over[i] = more;
        last_gap[i] = gap;
        last_way[i] = if too_far { 0.0 } else { moved };
        found.reached[i] = u8::from(arrives);
        found.ended[i] = u8::from((end[i] != RETIRED) & (arrives | spent | (t[i] > end[i])));
    }
    found
}

/// Loads the rays that meet the box.
pub(crate) fn start_rays(
    frame: &FrameUniform,
    tile: Tile,
    starts: &mut RaySetup,
    wave: &mut RayBatch,
    out: &mut [Hit],
) {
    wave.clear();
    out[..tile.area()].fill(Hit::default());
    starts.fill(frame, tile);
    for i in 0..tile.area() {
        if starts.near[i] <= starts.far[i] {
            let [x, y, z] = &starts.direction;
            let direction = Vec3::new(x[i], y[i], z[i]);
            wave.push(i as u32, direction, (starts.near[i], starts.far[i]));
        }
    }
}

/// The result of a step for a batch of rays: a 1 for each that hit, and for each that ends.
pub(crate) struct TraceState {
    pub reached: [u8; LANES],
    pub ended: [u8; LANES],
}

impl Default for TraceState {
    fn default() -> Self {
        Self {
            reached: [0; LANES],
            ended: [0; LANES],
        }
    }
}

/// Writes the results of rays that end with this step, and removes them.
pub(crate) fn end_rays(
    wave: &mut RayBatch,
    first: usize,
    steps: u32,
    found: &TraceState,
    hits: &mut Vec<u32>,
    out: &mut [Hit],
) {
    for i in set_indices(&found.ended) {
        let ray = first + i;
        let hit = &mut out[wave.pixel[ray] as usize];
        hit.steps = steps;
        if found.reached[i] != 0 {
            hit.kind = if wave.side[ray] < 0.0 {
                abi::HIT_INSIDE
            } else {
                abi::HIT_OUTSIDE
            };
            hit.normal_t[3] = wave.t[ray];
            hits.push(wave.pixel[ray]);
        }
        wave.retire(ray);
    }
}

/// Computes the points around each hit, two along each axis, for its normal.
pub(crate) fn central_difference_points(
    frame: &FrameUniform,
    tile: Tile,
    hits: &[u32],
    points: &mut Points,
    out: &[Hit],
) {
    let bias = frame.normal_bias;
    points.clear();
    for &pixel in hits {
        let (x, y) = tile.pixel(pixel as usize);
        let p = primary_ray(frame, x, y).at(out[pixel as usize].normal_t[3]);
        let (low, high) = (p - bias, p + bias);
        points
            .x
            .extend_from_slice(&[high.x, low.x, p.x, p.x, p.x, p.x]);
        points
            .y
            .extend_from_slice(&[p.y, p.y, high.y, low.y, p.y, p.y]);
        points
            .z
            .extend_from_slice(&[p.z, p.z, p.z, p.z, high.z, low.z]);
    }
}

/// Computes the normals of hits from the distances around them.
pub(crate) fn set_normals(
    frame: &FrameUniform,
    tile: Tile,
    hits: &[u32],
    points: &Points,
    out: &mut [Hit],
) {
    for (&pixel, d) in hits.iter().zip(points.d.as_chunks::<DIFFERENCES>().0) {
        set_normal(frame, tile, pixel, d, out);
    }
}

/// Computes the normal of a hit from the distances around it, two along each axis.
#[inline]
pub(crate) fn set_normal(
    frame: &FrameUniform,
    tile: Tile,
    pixel: u32,
    d: &[f32; DIFFERENCES],
    out: &mut [Hit],
) {
    let hit = &mut out[pixel as usize];
    let side = if hit.kind == abi::HIT_INSIDE {
        -1.0
    } else {
        1.0
    };
    let (nx, ny, nz) = (
        (d[0] - d[1]) * side,
        (d[2] - d[3]) * side,
        (d[4] - d[5]) * side,
    );
    let length = (nx * nx + ny * ny + nz * nz).sqrt();
    let t = hit.normal_t[3];
    hit.normal_t = if length > 0.0 {
        let scale = 1.0 / length;
        [nx * scale, ny * scale, nz * scale, t]
    } else {
        // If all differences are equal, toward the viewer.
        let (x, y) = tile.pixel(pixel as usize);
        let [x, y, z] = (-primary_ray(frame, x, y).direction).to_array();
        [x, y, z, t]
    };
}

/// Sets the normal of a hit where the box clips a solid.
pub(crate) fn set_clip_normal(frame: &FrameUniform, ray: Ray, hit: &mut Hit) {
    let t = hit.normal_t[3];
    if hit.kind == abi::HIT_OUTSIDE
        && let Some(normal) = clip_normal(frame, ray, t)
    {
        hit.normal_t = normal.extend(t).to_array();
    }
}

/// Sets the normals of hits where the box clips a solid.
pub(crate) fn face_clips(frame: &FrameUniform, tile: Tile, hits: &[u32], out: &mut [Hit]) {
    for &pixel in hits {
        let (x, y) = tile.pixel(pixel as usize);
        set_clip_normal(frame, primary_ray(frame, x, y), &mut out[pixel as usize]);
    }
}

/// Intersects the ground where it is nearer.
pub(crate) fn intersect_ground(frame: &FrameUniform, tile: Tile, out: &mut [Hit]) {
    if frame.has_ground == 0 {
        return;
    }
    let width = tile.width as usize;
    for (row, out) in out[..tile.area()].chunks_mut(width).enumerate() {
        let mut lengths = [0.0; TILE_WIDTH as usize];
        let y = tile.first_row + row as u32;
        ground_lengths(frame, tile.first_x, y, &mut lengths[..width]);
        for (hit, &t) in out.iter_mut().zip(&lengths) {
            if t < frame.far && (hit.kind == abi::HIT_NONE || t < hit.normal_t[3]) {
                hit.kind = abi::HIT_GROUND;
                hit.normal_t = [0.0, 1.0, 0.0, t];
            }
        }
    }
}

/// Computes where the rays of a row's pixels from `first` on meet the ground from above. Rays that do not are infinite.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn ground_lengths(frame: &FrameUniform, first: u32, y: u32, out: &mut [f32]) {
    // As `primary_ray` does, with the same operations in the same order.
    let v = 1.0 - (y as f32 + frame.jitter_y) / frame.height as f32 * 2.0;
    let (forward, right, up) = (frame.forward, frame.right, frame.up);
    let (jitter, width) = (frame.jitter_x, frame.width as f32);
    let height = frame.ground_y - frame.eye[1];
    for (i, t) in out.iter_mut().enumerate() {
        let u = ((first + i as u32) as f32 + jitter) / width * 2.0 - 1.0;
        let axis = |k: usize| forward[k] + right[k] * u + up[k] * v;
        let (dx, dy, dz) = (axis(0), axis(1), axis(2));
        let down = dy / (dx * dx + dy * dy + dz * dz).sqrt();
        let length = height / down;
        let meets = (down <= -1e-6) & (length > 0.0);
        *t = if meets { length } else { f32::INFINITY };
    }
}
