//! Distances that are interpolated between samples, and ground from heights. `argil_scene::SampledGrid` defines the
//! words. `sampled.wgsl` is the twin.

use crate::scalar::{Real, SIMD_BLOCK, SimdBlock};
use argil_scene::{SAMPLED_HEADER, SAMPLED_SIDE};

const _: () = assert!(
    argil_abi::SAMPLED_HEADER as usize == SAMPLED_HEADER && argil_abi::SAMPLED_SIDE == SAMPLED_SIDE,
    "both interpreters read what the scene holds"
);

/// Computes the distances of a block of points. Outside the grid's box, the result is the hypotenuse over the way
/// to the box and the value at its side, which is a lower bound.
#[inline(always)]
pub(crate) fn sd_sampled<R: Real>([x, y, z]: [&mut SimdBlock<R>; 3], w: &[f32]) -> SimdBlock<R> {
    let mut out = [R::constant(0.0); SIMD_BLOCK];
    for i in 0..SIMD_BLOCK {
        out[i] = sampled([x[i], y[i], z[i]], w);
    }
    out
}

#[inline(always)]
fn sampled<R: Real>(p: [R; 3], w: &[f32]) -> R {
    let (nx, ny, nz) = (w[4] as usize, w[5] as usize, w[6] as usize);
    let mut gap = R::constant(0.0);
    let mut at = [R::constant(0.0); 3];
    let mut place = [0usize; 3];
    for axis in 0..3 {
        let count = w[4 + axis];
        let whole = (p[axis] - w[axis]) * w[3];
        let inside = whole.clamp_to(0.0, count);
        let beyond = whole - inside;
        gap = gap + beyond * beyond;
        let least = Real::min(inside.value().floor(), count - 1.0);
        place[axis] = least as usize;
        at[axis] = inside - least;
    }
    let [i, j, k] = place;
    let table = SAMPLED_HEADER;
    let coarse = table + nx * ny * nz;
    let own = w[table + (k * ny + j) * nx + i];
    let d = if own == 0.0 {
        let (row, layer) = (nx + 1, (nx + 1) * (ny + 1));
        interpolate(at, &w[coarse + k * layer + j * row + i..], row, layer)
    } else {
        let side = SAMPLED_SIDE as usize + 1;
        let mut inner = [0usize; 3];
        for axis in 0..3 {
            let fine = at[axis] * SAMPLED_SIDE as f32;
            let least = Real::min(fine.value().floor(), SAMPLED_SIDE as f32 - 1.0);
            inner[axis] = least as usize;
            at[axis] = fine - least;
        }
        let fine =
            coarse + (nx + 1) * (ny + 1) * (nz + 1) + (own as usize - 1) * side * side * side;
        let first = fine + (inner[2] * side + inner[1]) * side + inner[0];
        interpolate(at, &w[first..], side, side * side)
    };
    if gap.value() > 0.0 {
        let h = d.positive_part();
        // The gap is in cells.
        let cell = 1.0 / w[3];
        (gap * (cell * cell) + h * h).sqrt()
    } else {
        d
    }
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

#[inline(always)]
fn interpolate<R: Real>(t: [R; 3], v: &[f32], row: usize, layer: usize) -> R {
    let x = |i: usize| t[0] * (v[i + 1] - v[i]) + v[i];
    let y = |i: usize| {
        let (a, b) = (x(i), x(i + row));
        t[1] * (b - a) + a
    };
    let (a, b) = (y(0), y(layer));
    t[2] * (b - a) + a
}
