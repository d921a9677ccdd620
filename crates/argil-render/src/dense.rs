//! Rays through a dense volume. `dense.wgsl` is the twin.
//!
//! *Theory.* Without mips, every step is at most the band. With mips, a ray reads the level on which the distance
//! is within the band. It climbs where a sample saturates, and descends where the next finer level is as
//! informative. Coarse levels never overstate the distance, so their steps need no test. Only the finest level
//! finds the surface.
//!
//! *Practice.* A tile's rays march together, each on its own level.

use crate::probe::FieldProbe;
use crate::ray_batch::{RETIRED, RayBatch};
use crate::source::{RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use crate::trace::{
    TraceState, central_difference_points, end_rays, face_clips, intersect_ground, set_normals,
    start_rays,
};
use argil_abi::{FrameUniform, Hit};
use argil_field::LANES;
use argil_volume::{Dense, MipSampler, SampleFormat, Texel};
use multiversion::multiversion;
use std::ops::Range;

/// A sample of at least this fraction of the band is saturated.
const SATURATED: f32 = argil_abi::SATURATED;
/// Below this fraction of the band, the next finer level, with half the band, is more precise.
const NEAR: f32 = argil_abi::DENSE_NEAR;

/// A dense volume, ready to be marched.
enum DenseRays<'a> {
    Eight(MipSampler<'a, i8>, f32),
    Sixteen(MipSampler<'a, i16>, f32),
}

impl RenderSource for Dense {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        let range = self.encoding().band_width(self.voxel_grid(), 0);
        let rays = match self.encoding().format {
            SampleFormat::Snorm8 => DenseRays::Eight(MipSampler::new(self)?, range),
            SampleFormat::Snorm16 => DenseRays::Sixteen(MipSampler::new(self)?, range),
        };
        Some(Box::new(rays))
    }
}

impl RayTracer for DenseRays<'_> {
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        _: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_dense(frame, tile, self, scratch, out);
    }
}

/// Traces the primary ray of each pixel of a tile into `out`, row by row.
fn trace_dense(
    frame: &FrameUniform,
    tile: Tile,
    volume: &DenseRays<'_>,
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
    hits.clear();
    start_rays(frame, tile, starts, wave, out);

    // March until every ray has hit, left the box, or used its steps.
    let mut steps = 0;
    let mut at_entry = 0;
    while wave.len() > 0 {
        steps += 1;
        let count = wave.len();
        for first in (0..count).step_by(LANES) {
            let range = first..(first + LANES).min(count);
            let mut found = TraceState::default();
            match volume {
                DenseRays::Eight(levels, length) => {
                    step_i8(frame, levels, *length, steps, wave, range, &mut found);
                }
                DenseRays::Sixteen(levels, length) => {
                    step_i16(frame, levels, *length, steps, wave, range, &mut found);
                }
            }
            end_rays(wave, first, steps, &found, hits, out);
        }
        if steps == 1 {
            at_entry = hits.len();
        }
        wave.compact();
    }

    // Normals by central differences.
    central_difference_points(frame, tile, hits, points, out);
    points.d.resize(points.x.len(), 0.0);
    for first in (0..points.x.len()).step_by(LANES) {
        let range = first..(first + LANES).min(points.x.len());
        let (x, y, z) = (
            &points.x[range.clone()],
            &points.y[range.clone()],
            &points.z[range.clone()],
        );
        let d = &mut points.d[range];
        match volume {
            DenseRays::Eight(levels, _) => measure_i8(levels, [x, y, z], d),
            DenseRays::Sixteen(levels, _) => measure_i16(levels, [x, y, z], d),
        }
    }
    set_normals(frame, tile, hits, points, out);
    face_clips(frame, tile, &hits[..at_entry], out);
    intersect_ground(frame, tile, out);
}

// `multiversion` does not accept generic functions, so each sample type has a wrapper below.

/// Takes one step of a batch of rays.
#[inline(always)]
fn step<T: Texel>(
    frame: &FrameUniform,
    levels: &MipSampler<'_, T>,
    length: f32,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut TraceState,
) {
    let n = range.len();
    let (epsilon, scale) = (frame.epsilon, frame.inv_lipschitz);
    let (is_first, is_last) = (steps == 1, steps >= frame.max_steps);
    let top = levels.count() as u32 - 1;
    // At the start of a ray, the distance of the surface is unknown.
    let above_finest = if is_first { top } else { top.min(1) };
    let mut p = [[0.0f32; LANES]; 3];
    let mut d = [0.0f32; LANES];
    for (k, p) in p.iter_mut().enumerate() {
        let (t, direction) = (&wave.t[range.clone()], &wave.direction[k][range.clone()]);
        for (p, (t, direction)) in p.iter_mut().zip(t.iter().zip(direction)) {
            *p = frame.eye[k] + direction * t;
        }
    }
    let (t, end) = (&mut wave.t[range.clone()], &wave.end[range.clone()]);
    let side = &mut wave.side[range.clone()];
    let level = &mut wave.level[range];
    let points = [&p[0][..n], &p[1][..n], &p[2][..n]];
    levels.distances(points, level, &mut d[..n]);
    if is_first {
        // A ray that enters the volume through a clipped solid hits there. A ray that starts inside continues.
        for i in 0..n {
            side[i] = if d[i] < 0.0 && t[i] <= 0.0 { -1.0 } else { 1.0 };
            d[i] = if d[i] < 0.0 && t[i] > 0.0 { 0.0 } else { d[i] };
        }
    }
    let mut gaps = [0.0f32; LANES];
    let gaps = &mut gaps[..n];
    for i in 0..n {
        let is_finest = level[i] == 0;
        let signed = d[i] * side[i];
        let above = if d[i] > 0.0 { d[i] } else { 0.0 };
        let gap = if is_finest { signed } else { above };
        let arrives = is_finest & ((gap < epsilon) | (is_last & (gap < frame.pixel_width * t[i])));
        t[i] += gap * scale;
        gaps[i] = gap;
        found.reached[i] = u8::from(arrives);
        found.ended[i] = u8::from((end[i] != RETIRED) & (arrives | is_last | (t[i] > end[i])));
    }
    if top == 0 {
        return;
    }

    // Up where the sample saturates, else down to where the distance is within the band.
    let mut lower = [0u32; LANES];
    let lower = &mut lower[..n];
    for k in 1..=top {
        let least = NEAR * length * (1u32 << k) as f32;
        for i in 0..n {
            let holds = (k <= level[i]) & (gaps[i] >= least);
            lower[i] = if holds { k } else { lower[i] };
        }
    }
    for i in 0..n {
        let current = level[i];
        let upper = if current == 0 {
            above_finest
        } else {
            top.min(current + 1)
        };
        let is_saturated = gaps[i] >= SATURATED * length * (1u32 << current) as f32;
        level[i] = if is_saturated { upper } else { lower[i] };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_i8(
    frame: &FrameUniform,
    levels: &MipSampler<'_, i8>,
    length: f32,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut TraceState,
) {
    step(frame, levels, length, steps, wave, range, found);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn step_i16(
    frame: &FrameUniform,
    levels: &MipSampler<'_, i16>,
    length: f32,
    steps: u32,
    wave: &mut RayBatch,
    range: Range<usize>,
    found: &mut TraceState,
) {
    step(frame, levels, length, steps, wave, range, found);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure_i8(levels: &MipSampler<'_, i8>, points: [&[f32]; 3], out: &mut [f32]) {
    levels.distances(points, &[0; LANES], out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure_i16(levels: &MipSampler<'_, i16>, points: [&[f32]; 3], out: &mut [f32]) {
    levels.distances(points, &[0; LANES], out);
}
