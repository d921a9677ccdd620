//! Distances that search along curves: paths and Bézier tubes. The functions of `curves.wgsl` are twins.
//!
//! *Theory.* The squared distance to a quadratic curve is a polynomial of degree four, with at most two minima. Their
//! parameters are roots of a cubic ([`minima`]). If a tube's radius changes, the nearest sphere minimizes a ratio-like
//! difference, distance minus radius. Each bound of it gives a polynomial of degree four, whose minimum is a better
//! bound. That converges faster than linearly to the global minimum, as in Dinkelbach, "On Nonlinear Fractional
//! Programming" (1967).
//!
//! A point is inside a path if a ray along +x crosses it an odd number of times. Each segment rises or falls
//! throughout, so it is crossed at most once. A half-open rule at its ends counts each crossing exactly once.
//!
//! *Practice.* Points come in blocks of [`SIMD_BLOCK`]. A search is skipped if none of a block's points can be
//! affected: for a brush that the accumulator beats, and for a segment that another beats. The outer loop runs over
//! segments and the inner one over points, so that the points become SIMD.

use crate::interpreter_state::words;
use crate::quartic::{Cubics, minima};
use crate::scalar::{Real, SIMD_BLOCK, SimdBlock};
use crate::shapes::{corner2, length2};
use argil_abi::PIECE_WORDS;

/// Bounds after which the nearest sphere of a tube is known.
const TAPER_STEPS: u32 = argil_abi::TAPER_STEPS;
/// The part of a length that a bound must gain, or its point is done.
const SMALL_GAIN: f32 = argil_abi::SMALL_GAIN;

/// Returns a lower bound of the distance from a point to anything in a box: the distance to the box, minus
/// rounding.
#[inline(always)]
pub(crate) fn box_distance(x: f32, y: f32, z: f32, w: &[f32; 6]) -> f32 {
    let gap = |c: f32, k: usize| Real::max(Real::max(w[k] - c, c - w[3 + k]), 0.0);
    let (gx, gy, gz) = (gap(x, 0), gap(y, 1), gap(z, 2));
    f32::sqrt(gx * gx + gy * gy + gz * gz) * 0.9999
}

/// Below this ratio of squares, the quadratic part of a curve is small beside its linear part.
const STRAIGHT: f32 = argil_abi::STRAIGHT_CURVE;

/// Returns the squared distance from (x, y) to a quadratic curve at a parameter from 0 to 1.
#[inline(always)]
fn squared2<R: Real>(x: R, y: R, t: f32, w: &[f32; 8]) -> R {
    let (e1x, e1y) = (w[3] - w[1], w[4] - w[2]);
    let (e2x, e2y) = (w[1] - 2.0 * w[3] + w[5], w[2] - 2.0 * w[4] + w[6]);
    let qx = R::constant(t * (t * e2x + 2.0 * e1x) + w[1]) - x;
    let qy = R::constant(t * (t * e2y + 2.0 * e1y) + w[2]) - y;
    qx * qx + qy * qy
}

/// Evaluates one segment of a path: lowers `best`, the squared distance, and flips `sign` where a ray along +x
/// crosses.
#[inline(always)]
fn piece<R: Real>(
    xs: &SimdBlock<R>,
    ys: &SimdBlock<R>,
    w: &[f32; 8],
    best: &mut SimdBlock<R>,
    sign: &mut [f32; SIMD_BLOCK],
) {
    let (ax, ay, bx, by, cx, cy) = (w[1], w[2], w[3], w[4], w[5], w[6]);
    if w[0] == 0.0 {
        let (ex, ey) = (cx - ax, cy - ay);
        let reciprocal = 1.0 / (ex * ex + ey * ey);
        let slant = if ey == 0.0 { 0.0 } else { ex / ey };
        for i in 0..SIMD_BLOCK {
            let (x, y) = (xs[i], ys[i]);
            let (px, py) = (x - ax, y - ay);
            let t = ((px * ex + py * ey) * reciprocal).clamp_to(0.0, 1.0);
            let (dx, dy) = (px - t * ex, py - t * ey);
            best[i] = best[i].min(dx * dx + dy * dy);
            let crosses =
                (ay <= y.value()) != (cy <= y.value()) && ax + py.value() * slant > x.value();
            sign[i] *= if crosses { -1.0 } else { 1.0 };
        }
        return;
    }
    let rising = if cy > ay { 1.0 } else { -1.0 };
    let (e1x, e1y) = (bx - ax, by - ay);
    let (e2x, e2y) = (ax - 2.0 * bx + cx, ay - 2.0 * by + cy);
    // The curve lies in the box of its three points.
    let (min_x, max_x) = (
        Real::min(ax, Real::min(bx, cx)),
        Real::max(ax, Real::max(bx, cx)),
    );
    let (min_y, max_y) = (Real::min(ay, cy), Real::max(ay, cy));
    let mut concerned = 0u32;
    for i in 0..SIMD_BLOCK {
        let (x, y) = (xs[i].value(), ys[i].value());
        // The parameter at the point's height: the root of a rising or falling parabola, without cancellation.
        let height = ay - y;
        let root = f32::sqrt((e1y * e1y - e2y * height).positive_part());
        let descent = e1y + rising * root;
        // Both are 0 at the height of a start that is level.
        let s = if descent == 0.0 {
            0.0
        } else {
            -height / descent
        };
        let s = s.clamp_to(0.0, 1.0);
        let crossing = ax + s * (2.0 * e1x + s * e2x);
        let crosses = (ay <= y) != (cy <= y) && crossing > x;
        sign[i] *= if crosses { -1.0 } else { 1.0 };
        let gap_x = Real::max(min_x - x, x - max_x).positive_part();
        let gap_y = Real::max(min_y - y, y - max_y).positive_part();
        concerned |= u32::from((gap_x * gap_x + gap_y * gap_y) * 0.9999 < best[i].value());
    }
    if concerned == 0 {
        return;
    }
    // The parameter needs no derivatives: at the nearest point, changing it changes nothing.
    let [ee, ef, ff] = [
        e1x * e1x + e1y * e1y,
        e1x * e2x + e1y * e2y,
        e2x * e2x + e2y * e2y,
    ];
    let mut cubics = Cubics {
        constant: [0.0; SIMD_BLOCK],
        linear: [0.0; SIMD_BLOCK],
        quadratic: 3.0 * ef,
        cubic: ff,
    };
    for i in 0..SIMD_BLOCK {
        let (x, y) = (ax - xs[i].value(), ay - ys[i].value());
        cubics.constant[i] = x * e1x + y * e1y;
        cubics.linear[i] = 2.0 * ee + (x * e2x + y * e2y);
    }
    for t in &minima(&cubics, ff <= 4.0 * STRAIGHT * ee) {
        for i in 0..SIMD_BLOCK {
            let t = t[i].clamp_to(0.0, 1.0);
            best[i] = best[i].min(squared2(xs[i], ys[i], t, w));
        }
    }
}

/// Words of a spline tube's segment: its box and its curve.
const TUBE_WORDS: usize = argil_abi::TUBE_WORDS as usize;

/// Computes signed distances to a tube of several segments. Only segments whose boxes are near enough are searched.
/// `w`: their number, and then their words.
#[inline(always)]
pub(crate) fn sd_spline_tube<R: Real>(
    [xs, ys, zs]: [&mut SimdBlock<R>; 3],
    w: &[f32],
) -> SimdBlock<R> {
    let mut best = [R::constant(1e30); SIMD_BLOCK];
    let pieces = w[1..1 + w[0] as usize * TUBE_WORDS].chunks_exact(TUBE_WORDS);
    for piece in pieces {
        let held = words(piece, 0);
        let mut concerned = 0u32;
        for i in 0..SIMD_BLOCK {
            let gap = box_distance(xs[i].value(), ys[i].value(), zs[i].value(), held);
            concerned |= u32::from(gap <= best[i].value().positive_part());
        }
        if concerned == 0 {
            continue;
        }
        let d = sd_bezier_tube::<R>([xs, ys, zs], &piece[6..]);
        for i in 0..SIMD_BLOCK {
            best[i] = best[i].min(d[i]);
        }
    }
    best
}

/// Returns the iterations of a GPU's loops for a tube. A software GPU also takes a round of its loops for each
/// instruction of another kind.
pub(crate) fn bezier_tube_loops(_: &[f32]) -> u64 {
    16
}

/// Returns the iterations for a tube of several segments.
pub(crate) fn spline_tube_loops(words: &[f32]) -> u64 {
    2 + 17 * words.first().map_or(0, |&count| count as u64)
}

/// Returns the iterations for a path.
pub(crate) fn outline_loops(words: &[f32]) -> u64 {
    2 + 12 * words.first().map_or(0, |&count| count as u64)
}

/// Returns the iterations for samples, which need no search.
pub(crate) fn sampled_loops(_: &[f32]) -> u64 {
    1
}

/// Computes signed distances to a path revolved about y. `w`: the number of segments, one more word, the segments.
#[inline(always)]
pub(crate) fn sd_lathe<R: Real>([x, y, z]: [&mut SimdBlock<R>; 3], w: &[f32]) -> SimdBlock<R> {
    for i in 0..SIMD_BLOCK {
        x[i] = length2(x[i], z[i]);
    }
    sd_outline::<R>(x, y, pieces(w))
}

/// Computes signed distances to a path extruded along z. `w`: the number of segments, half of the length, the
/// segments.
#[inline(always)]
pub(crate) fn sd_extrusion<R: Real>([x, y, z]: [&mut SimdBlock<R>; 3], w: &[f32]) -> SimdBlock<R> {
    let mut d = sd_outline::<R>(x, y, pieces(w));
    for i in 0..SIMD_BLOCK {
        d[i] = corner2(d[i], z[i].abs() - w[1]);
    }
    d
}

#[inline(always)]
fn pieces(w: &[f32]) -> &[f32] {
    &w[2..2 + w[0] as usize * PIECE_WORDS as usize]
}

/// Computes signed distances of the points (xs, ys) to a path.
#[inline(always)]
fn sd_outline<R: Real>(xs: &SimdBlock<R>, ys: &SimdBlock<R>, pieces: &[f32]) -> SimdBlock<R> {
    let mut best = [R::constant(1e30); SIMD_BLOCK];
    let mut sign = [1.0; SIMD_BLOCK];
    for words in pieces.chunks_exact(PIECE_WORDS as usize) {
        if let Ok(words) = words.try_into() {
            piece::<R>(xs, ys, words, &mut best, &mut sign);
        }
    }
    for i in 0..SIMD_BLOCK {
        best[i] = best[i].sqrt() * sign[i];
    }
    best
}

/// Returns the offset from a point to the curve's start.
#[inline(always)]
fn offset<R: Real>(p: [R; 3], w: &[f32; 11]) -> [R; 3] {
    [
        R::constant(w[0]) - p[0],
        R::constant(w[1]) - p[1],
        R::constant(w[2]) - p[2],
    ]
}

/// Returns the distance to the sphere at t, from the offset of the curve's start.
#[inline(always)]
fn sphere_distance<R: Real>(o: [R; 3], t: f32, w: &[f32; 11]) -> R {
    let x = o[0] + t * (t * w[6] + w[3]);
    let y = o[1] + t * (t * w[7] + w[4]);
    let z = o[2] + t * (t * w[8] + w[5]);
    (x * x + y * y + z * z).sqrt() - (t * w[10] + w[9])
}

/// Computes signed distances to a tube. `w`: the curve's constant, linear and quadratic coefficients, the radius at
/// the start, and its change.
#[inline(always)]
pub(crate) fn sd_bezier_tube<R: Real>(
    [xs, ys, zs]: [&mut SimdBlock<R>; 3],
    w: &[f32],
) -> SimdBlock<R> {
    let w: &[f32; 11] = words(w, 0);
    let dot = |a: usize, b: usize| w[a] * w[b] + w[a + 1] * w[b + 1] + w[a + 2] * w[b + 2];
    let (bb, bc, cc) = (dot(3, 3), dot(3, 6), dot(6, 6));
    let is_straight = cc <= STRAIGHT * bb;
    // The parameter needs no derivatives: at the nearest sphere, changing it changes nothing.
    let mut t = [0.0; SIMD_BLOCK];
    let mut least = [1e30; SIMD_BLOCK];
    let mut is_open = [true; SIMD_BLOCK];
    let mut cubics = Cubics {
        constant: [0.0; SIMD_BLOCK],
        linear: [0.0; SIMD_BLOCK],
        quadratic: 3.0 * bc,
        cubic: 2.0 * cc,
    };
    let steps = if w[10] == 0.0 { 1 } else { TAPER_STEPS };
    for step in 0..steps {
        // The first step ignores that the radius changes.
        let taper = if step == 0 { 0.0 } else { w[10] };
        let reciprocal = 1.0 / taper;
        let mut low = [0.0; SIMD_BLOCK];
        let mut high = [1.0; SIMD_BLOCK];
        for i in 0..SIMD_BLOCK {
            let o = offset([xs[i].value(), ys[i].value(), zs[i].value()], w);
            let along_linear = o[0] * w[3] + o[1] * w[4] + o[2] * w[5];
            let along_quadratic = o[0] * w[6] + o[1] * w[7] + o[2] * w[8];
            let reach = least[i] + w[9];
            cubics.constant[i] = along_linear - taper * reach;
            cubics.linear[i] = bb + 2.0 * along_quadratic - taper * taper;
            // Spheres smaller than a negative bound's length cannot be nearer.
            let edge = Real::clamp_to(-reach * reciprocal, 0.0, 1.0);
            low[i] = if taper > 0.0 { edge } else { 0.0 };
            high[i] = if taper < 0.0 { edge } else { 1.0 };
        }
        let before = least;
        for found in &minima(&cubics, is_straight) {
            for i in 0..SIMD_BLOCK {
                let found = found[i].clamp_to(low[i], high[i]);
                let o = offset([xs[i].value(), ys[i].value(), zs[i].value()], w);
                let d = sphere_distance(o, found, w);
                let nearer = d < least[i] && is_open[i];
                t[i] = if nearer { found } else { t[i] };
                least[i] = if nearer { d } else { least[i] };
            }
        }
        // What is left to gain after a step with the taper is no more than its own gain.
        let mut open = 0u32;
        for i in 0..SIMD_BLOCK {
            let gain = before[i] - least[i];
            is_open[i] &= step == 0 || gain > SMALL_GAIN * Real::abs(before[i] + w[9]);
            open |= u32::from(is_open[i]);
        }
        if open == 0 {
            break;
        }
    }
    let mut best = [R::constant(0.0); SIMD_BLOCK];
    for i in 0..SIMD_BLOCK {
        best[i] = sphere_distance(offset([xs[i], ys[i], zs[i]], w), t[i], w);
    }
    best
}
