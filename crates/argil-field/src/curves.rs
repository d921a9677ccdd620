//! Distances that search along curves: outlines and Bézier tubes. Twins of the functions of the same names in
//! `shapes.wgsl`.
//!
//! *Theory.* The nearest point of a quadratic curve is a root of a cubic. A few samples find the right valley, and
//! Newton's method its floor; no trigonometry, and the same operations on every device. Inside an outline is where a
//! ray along +x crosses it an odd number of times; pieces rise or fall throughout, so each is crossed at most once and
//! a half-open rule on its ends counts every crossing exactly once.
//!
//! *Practice.* Loops run pieces outside and lanes inside, so that the lanes become SIMD.

use crate::real::{LANES, Real};
use argil_abi::PIECE_WORDS;

/// Newton steps after the samples.
const NEWTON_STEPS: usize = 4;
/// Intervals that a tube's curve is sampled at.
const TUBE_SAMPLES: usize = 16;

/// Squared distance from (x, y) to a quadratic curve at parameter t, with what a Newton step needs: q′·(q − p), and the
/// slope of that, kept positive.
#[inline(always)]
fn curve2<R: Real>(x: R, y: R, t: R, w: &[f32; 8]) -> (R, R, R) {
    let (e1x, e1y) = (w[3] - w[1], w[4] - w[2]);
    let (e2x, e2y) = (w[1] - 2.0 * w[3] + w[5], w[2] - 2.0 * w[4] + w[6]);
    let qx = t * (t * e2x + 2.0 * e1x) + w[1] - x;
    let qy = t * (t * e2y + 2.0 * e1y) + w[2] - y;
    let (vx, vy) = (t * (2.0 * e2x) + 2.0 * e1x, t * (2.0 * e2y) + 2.0 * e1y);
    let speed = vx * vx + vy * vy;
    let slope = speed + (qx * (2.0 * e2x) + qy * (2.0 * e2y));
    (qx * qx + qy * qy, qx * vx + qy * vy, slope.max(speed * 0.25 + 1e-12))
}

/// One piece of an outline: lower `best`, the squared distance, and flip `sign` where a ray along +x crosses.
#[inline(always)]
fn piece<R: Real>(xs: &R::Lanes, ys: &R::Lanes, w: &[f32; 8], best: &mut R::Lanes, sign: &mut R::Lanes) {
    let (ax, ay, bx, by, cx, cy) = (w[1], w[2], w[3], w[4], w[5], w[6]);
    if w[0] == 0.0 {
        let (ex, ey) = (cx - ax, cy - ay);
        let reciprocal = 1.0 / (ex * ex + ey * ey);
        let slant = if ey == 0.0 { 0.0 } else { ex / ey };
        for i in 0..LANES {
            let (x, y) = (R::get(xs, i), R::get(ys, i));
            let (px, py) = (x - ax, y - ay);
            let t = ((px * ex + py * ey) * reciprocal).clamp_to(0.0, 1.0);
            let (dx, dy) = (px - t * ex, py - t * ey);
            R::set(best, i, R::get(best, i).min(dx * dx + dy * dy));
            let crosses = (ay <= y.value()) != (cy <= y.value()) && ax + py.value() * slant > x.value();
            R::set(sign, i, R::get(sign, i) * if crosses { -1.0 } else { 1.0 });
        }
        return;
    }
    let rising = if cy > ay { 1.0 } else { -1.0 };
    let (e1x, e1y) = (bx - ax, by - ay);
    let (e2x, e2y) = (ax - 2.0 * bx + cx, ay - 2.0 * by + cy);
    for i in 0..LANES {
        let (x, y) = (R::get(xs, i), R::get(ys, i));
        let (d0, ..) = curve2(x, y, R::constant(0.0), w);
        let (d1, ..) = curve2(x, y, R::constant(0.5), w);
        let (d2, ..) = curve2(x, y, R::constant(1.0), w);
        let upper = if d2.value() < d1.value() { 1.0 } else { 0.5 };
        let start = if d0.value() < d1.value() && d0.value() < d2.value() { 0.0 } else { upper };
        let mut t = R::constant(start);
        for _ in 0..NEWTON_STEPS {
            let (_, pull, slope) = curve2(x, y, t, w);
            t = (t - pull / slope).clamp_to(0.0, 1.0);
        }
        let (d, ..) = curve2(x, y, t, w);
        R::set(best, i, R::get(best, i).min(d.min(d0.min(d2))));

        // Where the curve has the point's height: the root of a rising or falling parabola, free of cancellation.
        let height = ay - y.value();
        let root = f32::sqrt((e1y * e1y - e2y * height).positive_part());
        let s = (-height / (e1y + rising * root)).clamp_to(0.0, 1.0);
        let crossing = ax + s * (2.0 * e1x + s * e2x);
        let crosses = (ay <= y.value()) != (cy <= y.value()) && crossing > x.value();
        R::set(sign, i, R::get(sign, i) * if crosses { -1.0 } else { 1.0 });
    }
}

/// Signed distances of the points (xs, ys) to an outline, into `best`; `sign` is scratch.
#[inline(always)]
pub(crate) fn sd_outline<R: Real>(
    xs: &R::Lanes,
    ys: &R::Lanes,
    pieces: &[f32],
    best: &mut R::Lanes,
    sign: &mut R::Lanes,
) {
    *best = R::splat(1e30);
    *sign = R::splat(1.0);
    for words in pieces.chunks_exact(PIECE_WORDS as usize) {
        if let Ok(words) = words.try_into() {
            piece::<R>(xs, ys, words, best, sign);
        }
    }
    for i in 0..LANES {
        R::set(best, i, R::get(best, i).sqrt().signed_as(R::get(sign, i)));
    }
}

/// Offset from the point to the curve at t.
#[inline(always)]
fn curve3<R: Real>(p: [R; 3], t: R, w: &[f32; 11]) -> [R; 3] {
    [0, 1, 2].map(|k| t * (t * w[6 + k] + w[3 + k]) + w[k] - p[k])
}

/// Distance to the ball at t.
#[inline(always)]
fn ball<R: Real>(p: [R; 3], t: R, w: &[f32; 11]) -> R {
    let [x, y, z] = curve3(p, t, w);
    (x * x + y * y + z * z).sqrt() - (t * w[10] + w[9])
}

/// Signed distances to a tube, into `best`; `at` is scratch. `w`: the curve's constant, linear and quadratic
/// coefficients, the radius at the start and what it gains.
#[inline(always)]
pub(crate) fn sd_bezier_tube<R: Real>(
    [xs, ys, zs]: [&R::Lanes; 3],
    w: &[f32; 11],
    best: &mut R::Lanes,
    at: &mut R::Lanes,
) {
    let step = 1.0 / TUBE_SAMPLES as f32;
    let point = |i: usize| [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
    *best = R::splat(1e30);
    *at = R::splat(0.0);
    for sample in 0..=TUBE_SAMPLES {
        let t = R::constant(sample as f32 * step);
        for i in 0..LANES {
            let d = ball(point(i), t, w);
            let nearer = d.value() < R::get(best, i).value();
            R::set(best, i, if nearer { d } else { R::get(best, i) });
            R::set(at, i, if nearer { t } else { R::get(at, i) });
        }
    }
    for i in 0..LANES {
        let p = point(i);
        let sampled = R::get(at, i);
        let (low, high) = ((sampled.value() - step).max(0.0), (sampled.value() + step).min(1.0));
        let mut t = sampled;
        for _ in 0..NEWTON_STEPS {
            let q = curve3(p, t, w);
            let v = [0, 1, 2].map(|k| t * (2.0 * w[6 + k]) + w[3 + k]);
            let speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let distance = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
            let pull = q[0] * v[0] + q[1] * v[1] + q[2] * v[2] - distance * w[10];
            let slope = speed + (q[0] * (2.0 * w[6]) + q[1] * (2.0 * w[7]) + q[2] * (2.0 * w[8]));
            t = (t - pull / slope.max(speed * 0.25 + 1e-12)).clamp_to(low, high);
        }
        R::set(best, i, R::get(best, i).min(ball(p, t, w)));
    }
}
