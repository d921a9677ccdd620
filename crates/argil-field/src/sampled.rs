//! Distances that are interpolated between samples, and ground from heights. `argil_scene::SampledGrid` defines the
//! words. `sampled.wgsl` is the twin.

use crate::scalar::{Real, SIMD_BLOCK, SimdBlock};
use argil_scene::{SAMPLED_HEADER, SAMPLED_SIDE, SAMPLED_SUMMARY};

const _: () = assert!(
    argil_abi::SAMPLED_HEADER as usize == SAMPLED_HEADER
        && argil_abi::SAMPLED_SUMMARY as usize == SAMPLED_SUMMARY,
    "both interpreters read what the scene holds"
);

/// Intervals along a cell with all samples.
const SIDE: f32 = SAMPLED_SIDE as f32;

/// Samples of a cell that has all, along a side.
const FINE_ROW: usize = SAMPLED_SIDE as usize + 1;

/// The kind of cells that have all samples.
const FINE_KIND: usize = SAMPLED_SIDE.trailing_zeros() as usize;

/// How far rounding can move a place, as a share of the coordinates of a level.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

/// Computes the distances of a block of points. Beyond all levels, the result is a lower bound: the larger of the
/// distance to the solid's box, and the hypotenuse over the way to the levels and the value at their side.
#[inline(always)]
pub(crate) fn sd_sampled<R: Real>([x, y, z]: [&mut SimdBlock<R>; 3], w: &[f32]) -> SimdBlock<R> {
    let layout = SampledLayout::of(w);
    let mut at = [[R::constant(0.0); SIMD_BLOCK]; 3];
    let mut beyond = 0.0;
    for (axis, along) in [&*x, &*y, &*z].into_iter().enumerate() {
        let near = rounding(w, axis);
        for i in 0..SIMD_BLOCK {
            let whole = (along[i] - w[axis]) * w[3];
            let inside = whole.clamp_to(0.0, w[4 + axis]);
            beyond += more_than(near, whole - inside).value().abs();
            at[axis][i] = at_sample(inside, near);
        }
    }
    // Most blocks are near the solid. The sum of a NaN is not 0.
    if beyond == 0.0 {
        return match stored(&at, w, &layout) {
            Some(samples) => samples,
            None => in_finest(at, w, &layout),
        };
    }
    let mut out = [R::constant(0.0); SIMD_BLOCK];
    for i in 0..SIMD_BLOCK {
        out[i] = sampled([x[i], y[i], z[i]], w, &layout);
    }
    out
}

/// Returns the samples at positions in cells of the finest level, if all are at some, in few cells that have all samples.
#[inline(always)]
fn stored<R: Real>(
    at: &[SimdBlock<R>; 3],
    w: &[f32],
    layout: &SampledLayout,
) -> Option<SimdBlock<R>> {
    let mut is_at_all = true;
    let mut samples = [[0.0; SIMD_BLOCK]; 3];
    for axis in 0..3 {
        for n in 0..SIMD_BLOCK {
            let sample = at[axis][n].value() * SIDE;
            samples[axis][n] = sample;
            is_at_all &= sample == sample.round_ties_even();
        }
    }
    if !is_at_all || R::HAS_GRADIENT {
        return None;
    }
    let (mut first, mut last) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let (mut least, mut most) = (samples[axis][0], samples[axis][0]);
        for &sample in &samples[axis] {
            least = Real::min(least, sample);
            most = Real::max(most, sample);
        }
        first[axis] = (least / SIDE) as usize;
        last[axis] = (most / SIDE) as usize;
        if last[axis] > first[axis] + 1 || last[axis] >= layout.count[axis] {
            return None;
        }
    }
    let [nx, ny, _] = layout.count;
    // Where the samples of a cell begin, or those of the next one along some axes.
    let mut begins = [0; 8];
    for (corner, begin) in begins.iter_mut().enumerate() {
        let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let [i, j, k] = [first[0] + i, first[1] + j, first[2] + k];
        if i <= last[0] && j <= last[1] && k <= last[2] {
            let entry = w[layout.table + (k * ny + j) * nx + i] as usize;
            if entry & 3 != FINE_KIND {
                return None;
            }
            *begin = layout.samples[FINE_KIND] + (entry >> 2) * FINE_ROW.pow(3);
        }
    }
    let mut index = [0.0; SIMD_BLOCK];
    let mut corner = [0.0; SIMD_BLOCK];
    let mut step = 1.0;
    let mut bit = 1.0;
    for axis in 0..3 {
        let begin = first[axis] as f32 * SIDE;
        for n in 0..SIMD_BLOCK {
            let inner = samples[axis][n] - begin;
            let is_next = if inner >= SIDE { 1.0 } else { 0.0 };
            index[n] += (inner - is_next * SIDE) * step;
            corner[n] += is_next * bit;
        }
        step *= FINE_ROW as f32;
        bit *= 2.0;
    }
    let mut out = [R::constant(0.0); SIMD_BLOCK];
    for n in 0..SIMD_BLOCK {
        let begin = begins[corner[n] as usize & 7];
        out[n] = R::constant(w[begin + index[n] as usize]);
    }
    Some(out)
}

/// Returns how far rounding can move a place along an axis of a level, in cells.
#[inline(always)]
fn rounding(head: &[f32], axis: usize) -> f32 {
    ROUNDING * (head[axis].abs() * head[3] + head[4 + axis])
}

/// Returns how far a point is beyond a level. One that only rounding moved out of it is in it: beside it, the next level has cells
/// that this one covers.
#[inline(always)]
fn more_than<R: Real>(near: f32, beyond: R) -> R {
    if beyond.value().abs() <= near {
        R::constant(0.0)
    } else {
        beyond
    }
}

/// Moves a position in cells back to the sample that only rounding moved it away from. A world's samples in the same places then need
/// no interpolation.
#[inline(always)]
fn at_sample<R: Real>(at: R, near: f32) -> R {
    let value = at.value();
    let sample = (value * SIDE).round_ties_even();
    if (value * SIDE - sample).abs() <= SIDE * near {
        // Numbers keep their gradients.
        at - value + sample * (1.0 / SIDE)
    } else {
        at
    }
}

/// Interpolates between samples of the finest level, at positions in its cells. Gives the numbers of [`sampled`], in passes of which
/// all but the loads are SIMD.
#[inline(always)]
fn in_finest<R: Real>(
    mut at: [SimdBlock<R>; 3],
    w: &[f32],
    layout: &SampledLayout,
) -> SimdBlock<R> {
    let [nx, ny, nz] = layout.count;
    let coarse = layout.table + nx * ny * nz;
    let counts = [[w[4]; SIMD_BLOCK], [w[5]; SIMD_BLOCK], [w[6]; SIMD_BLOCK]];
    let cells = block_places(&mut at, &counts);
    let mut sides = [1.0; SIMD_BLOCK];
    let (mut first, mut row, mut layer) = ([0; SIMD_BLOCK], [0; SIMD_BLOCK], [0; SIMD_BLOCK]);
    for n in 0..SIMD_BLOCK {
        let (i, j, k) = (cells[0][n], cells[1][n], cells[2][n]);
        let (i, j, k) = (i as usize, j as usize, k as usize);
        let entry = w[layout.table + (k * ny + j) * nx + i] as usize;
        let kind = entry & 3;
        if kind == 0 {
            (row[n], layer[n]) = (nx + 1, (nx + 1) * (ny + 1));
            first[n] = coarse + k * layer[n] + j * row[n] + i;
        } else {
            let side = 1 << kind;
            sides[n] = side as f32;
            (row[n], layer[n]) = (side + 1, (side + 1) * (side + 1));
            first[n] = layout.samples[kind] + (entry >> 2) * layer[n] * row[n];
        }
    }
    // Cells without samples between their corners are one such cell, whose place is 0.
    for along in &mut at {
        for n in 0..SIMD_BLOCK {
            along[n] = along[n] * sides[n];
        }
    }
    let inner = block_places(&mut at, &[sides; 3]);
    let mut corners = [[0.0; SIMD_BLOCK]; 8];
    for n in 0..SIMD_BLOCK {
        let (i, j, k) = (inner[0][n], inner[1][n], inner[2][n]);
        let (i, j, k) = (i as usize, j as usize, k as usize);
        let begin = first[n] + k * layer[n] + j * row[n] + i;
        // One check of the length, instead of eight.
        let v = &w[begin..begin + layer[n] + row[n] + 2];
        let (near, far) = v.split_at(layer[n]);
        let (a, b) = near.split_at(row[n]);
        let (c, d) = far.split_at(row[n]);
        (corners[0][n], corners[1][n]) = (a[0], a[1]);
        (corners[2][n], corners[3][n]) = (b[0], b[1]);
        (corners[4][n], corners[5][n]) = (c[0], c[1]);
        (corners[6][n], corners[7][n]) = (d[0], d[1]);
    }
    let mut out = [R::constant(0.0); SIMD_BLOCK];
    for n in 0..SIMD_BLOCK {
        let [x, y, z] = [at[0][n], at[1][n], at[2][n]];
        let a = x * (corners[1][n] - corners[0][n]) + corners[0][n];
        let b = x * (corners[3][n] - corners[2][n]) + corners[2][n];
        let c = x * (corners[5][n] - corners[4][n]) + corners[4][n];
        let d = x * (corners[7][n] - corners[6][n]) + corners[6][n];
        let near = y * (b - a) + a;
        let far = y * (d - c) + c;
        out[n] = z * (far - near) + near;
    }
    out
}

/// Splits places of a block as [`places`] does. The whole numbers stay `f32`, to be converted one by one.
#[inline(always)]
fn block_places<R: Real>(
    at: &mut [SimdBlock<R>; 3],
    count: &[[f32; SIMD_BLOCK]; 3],
) -> [[f32; SIMD_BLOCK]; 3] {
    let mut whole = [[0.0; SIMD_BLOCK]; 3];
    for axis in 0..3 {
        for n in 0..SIMD_BLOCK {
            let least = Real::min(at[axis][n].value().floor(), count[axis][n] - 1.0);
            whole[axis][n] = least;
            at[axis][n] = at[axis][n] - least;
        }
    }
    whole
}

/// Where the parts of a grid's words are.
struct SampledLayout {
    summary: usize,
    /// Samples of cells of each kind.
    samples: [usize; 4],
    /// Cells of the first level, and their number along each axis.
    table: usize,
    count: [usize; 3],
}

impl SampledLayout {
    #[inline(always)]
    fn of(w: &[f32]) -> Self {
        let summary = SAMPLED_HEADER * w[SAMPLED_HEADER - 1] as usize;
        let first = summary + SAMPLED_SUMMARY;
        let second = first + 27 * w[summary] as usize;
        let third = second + 125 * w[summary + 1] as usize;
        Self {
            summary,
            samples: [0, first, second, third],
            table: third + 729 * w[summary + 2] as usize,
            count: counts(w, 0),
        }
    }
}

/// Returns the number of a level's cells along each axis.
#[inline(always)]
fn counts(w: &[f32], head: usize) -> [usize; 3] {
    [
        w[head + 4] as usize,
        w[head + 5] as usize,
        w[head + 6] as usize,
    ]
}

#[inline(always)]
fn sampled<R: Real>(p: [R; 3], w: &[f32], layout: &SampledLayout) -> R {
    let summary = layout.summary;
    let mut table = layout.table;
    let mut count = layout.count;
    let mut head = 0;
    // The finest level that contains the point, or the last one.
    let (at, beyond) = loop {
        let mut at = [R::constant(0.0); 3];
        let mut beyond = [R::constant(0.0); 3];
        let mut is_in = true;
        for axis in 0..3 {
            let near = rounding(&w[head..], axis);
            let whole = (p[axis] - w[head + axis]) * w[head + 3];
            at[axis] = whole.clamp_to(0.0, w[head + 4 + axis]);
            beyond[axis] = more_than(near, whole - at[axis]);
            if head == 0 {
                at[axis] = at_sample(at[axis], near);
            }
            is_in &= beyond[axis].value() == 0.0;
        }
        if is_in || head + SAMPLED_HEADER == summary {
            break (at, beyond);
        }
        let [nx, ny, nz] = count;
        table += nx * ny * nz + (nx + 1) * (ny + 1) * (nz + 1);
        head += SAMPLED_HEADER;
        count = counts(w, head);
    };
    let [nx, ny, nz] = count;
    let mut t = at;
    let [i, j, k] = places(&mut t, [w[head + 4], w[head + 5], w[head + 6]]);
    let entry = w[table + (k * ny + j) * nx + i] as usize;
    let kind = entry & 3;
    let d = if kind == 0 {
        let (row, layer) = (nx + 1, (nx + 1) * (ny + 1));
        let coarse = table + nx * ny * nz;
        interpolate(t, &w[coarse + k * layer + j * row + i..], row, layer)
    } else {
        let side = (1 << kind) as f32;
        for t in &mut t {
            *t = *t * side;
        }
        let [i, j, k] = places(&mut t, [side; 3]);
        let row = (1 << kind) + 1;
        let layer = row * row;
        let samples = layout.samples[kind] + (entry >> 2) * layer * row;
        interpolate(t, &w[samples + k * layer + j * row + i..], row, layer)
    };
    let gap = beyond[0] * beyond[0] + beyond[1] * beyond[1] + beyond[2] * beyond[2];
    if gap.value() > 0.0 {
        let h = d.positive_part();
        // The gap is in cells.
        let cell = 1.0 / w[head + 3];
        let way = (gap * (cell * cell) + h * h).sqrt();
        way.max(box_distance(p, &w[summary + 4..]))
    } else {
        d
    }
}

/// Splits places into the whole number below, or the last one, and the rest.
#[inline(always)]
fn places<R: Real>(at: &mut [R; 3], count: [f32; 3]) -> [usize; 3] {
    let mut whole = [0usize; 3];
    for axis in 0..3 {
        let least = Real::min(at[axis].value().floor(), count[axis] - 1.0);
        whole[axis] = least as usize;
        at[axis] = at[axis] - least;
    }
    whole
}

/// Returns the distance to a box, from outside.
#[inline(always)]
fn box_distance<R: Real>(p: [R; 3], solid: &[f32]) -> R {
    let mut square = R::constant(0.0);
    for axis in 0..3 {
        let gap = p[axis] - p[axis].clamp_to(solid[axis], solid[axis + 3]);
        square = square + gap * gap;
    }
    square.sqrt()
}

/// Computes lower bounds of the distances of a block of points to ground from heights. The grid stores the ground's
/// largest slope, so the surface is at least as far as the vertical distance times the cosine of that slope.
/// Outside the box, the distance to the box is also a bound.
#[inline(always)]
pub(crate) fn sd_heightmap<R: Real>([x, y, z]: [&mut SimdBlock<R>; 3], w: &[f32]) -> SimdBlock<R> {
    let mut out = [R::constant(0.0); SIMD_BLOCK];
    for i in 0..SIMD_BLOCK {
        out[i] = heightmap([x[i], y[i], z[i]], w);
    }
    out
}

#[inline(always)]
fn heightmap<R: Real>([x, y, z]: [R; 3], w: &[f32]) -> R {
    let (half_x, half_z, height, base, share) = (w[0], w[1], w[2], w[3], w[4]);
    let grid = 5;
    let (nx, nz) = (w[grid + 4], w[grid + 6]);
    let along = |c: R, half: f32, n: f32| {
        let at = ((c + half) * ((n - 1.0) / (2.0 * half))).clamp_to(0.0, n - 1.0);
        let least = Real::min(at.value().floor(), n - 2.0);
        (least as usize, at - least)
    };
    let ((i, tx), (k, tz)) = (along(x, half_x, nx), along(z, half_z, nz));
    let row = nx as usize;
    let first = grid + SAMPLED_HEADER + k * row + i;
    let of = |v: usize| tx * (w[v + 1] - w[v]) + w[v];
    let (a, b) = (of(first), of(first + row));
    let ground = (tz * (b - a) + a) * height;
    let top = (y - ground) * share;
    let upright = (-y - base).max(y - height * w[grid + 3]);
    let gaps = [x.abs() - half_x, upright, z.abs() - half_z];
    let beyond = gaps.map(Real::positive_part);
    let squared = beyond[0] * beyond[0] + beyond[1] * beyond[1] + beyond[2] * beyond[2];
    let beside = if squared.value() > 0.0 {
        squared.sqrt()
    } else {
        gaps[0].max(gaps[1]).max(gaps[2])
    };
    top.max(beside)
}

/// Interpolates eight values, given the steps to the next row and the next layer. Without closures, which would be calls in a
/// hot loop.
#[inline(always)]
fn interpolate<R: Real>(t: [R; 3], v: &[f32], row: usize, layer: usize) -> R {
    // One check of the length, instead of eight.
    let v = &v[..layer + row + 2];
    let (near, far) = v.split_at(layer);
    let a = interpolate_layer(t, near, row);
    let b = interpolate_layer(t, far, row);
    t[2] * (b - a) + a
}

#[inline(always)]
fn interpolate_layer<R: Real>(t: [R; 3], v: &[f32], row: usize) -> R {
    let (near, far) = v.split_at(row);
    let a = t[0] * (near[1] - near[0]) + near[0];
    let b = t[0] * (far[1] - far[0]) + far[0];
    t[1] * (b - a) + a
}
