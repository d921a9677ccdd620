//! Curves and ramps, and what follows them: shifts, wraps, sections. `ramps.wgsl` is the twin.

use crate::domain_ops::rough_atan2;
use crate::scalar::{LANES, Real, sin_cos};
use crate::shapes::corner2;
use argil_abi::WRAP_TRUSTED;
use std::f32::consts::TAU;

// A scene tells the steepness down to this radius, so the evaluation must not trust distances further in.
const _: () = assert!(WRAP_TRUSTED == argil_scene::WRAP_TRUSTED);

/// Words of a ramp before its curve: 0 for a line or 1 for a radius, and four factors. A line's value is a · x + b · y
/// + c · z + d, and a radius's is a · r + b.
pub(crate) const RAMP_WORDS: usize = 5;
/// Words of a wrap before its curve: start and length along x, radius, radius of the core, the scale of distances to the
/// scene's unit, the solid's lowest and highest y, its largest radius, and the scale of lengths.
pub(crate) const WRAP_WORDS: usize = 9;
/// Words of an extrusion: half of its length, and the scale to the scene's unit.
pub(crate) const EXTRUDE_WORDS: usize = 2;

/// Replaces places from 0 to 1 by the values of a curve there: the number of its pieces, then four coefficients for each.
#[inline(always)]
fn follow_curve<R: Real>(places: &mut R::Lanes, active: usize, words: &[f32]) {
    let pieces = words[0];
    let piece_of = |along: R| Real::clamp_to(along.value().floor(), 0.0, pieces - 1.0);
    for i in 0..active.min(LANES) {
        let along = R::get(places, i).clamp_to(0.0, 1.0) * pieces;
        R::set(places, i, along);
    }
    let value = |u: R, cubic: &[f32; 4]| u * (u * (u * cubic[3] + cubic[2]) + cubic[1]) + cubic[0];
    let (table, _) = words[1..].as_chunks::<4>();
    let first = piece_of(R::get(places, 0));
    let mut others = 0u32;
    for i in 0..active.min(LANES) {
        others |= u32::from(piece_of(R::get(places, i)) != first);
    }
    let coefficients = |piece: f32| table.get(piece as usize).copied().unwrap_or_default();
    if others == 0 {
        let cubic = coefficients(first);
        for i in 0..active.min(LANES) {
            let u = R::get(places, i) - first;
            R::set(places, i, value(u, &cubic));
        }
    } else {
        for i in 0..active.min(LANES) {
            let along = R::get(places, i);
            let piece = piece_of(along);
            R::set(places, i, value(along - piece, &coefficients(piece)));
        }
    }
}

/// Computes the values of a ramp at points.
#[inline(always)]
pub(crate) fn ramp_values<R: Real>(
    [xs, ys, zs]: &[R::Lanes; 3],
    out: &mut R::Lanes,
    active: usize,
    words: &[f32],
) {
    let &[kind, a, b, c, d] = head(words);
    if kind == 0.0 {
        for i in 0..active.min(LANES) {
            let place = R::get(xs, i) * a + R::get(ys, i) * b + R::get(zs, i) * c + d;
            R::set(out, i, place);
        }
    } else {
        for i in 0..active.min(LANES) {
            let (x, z) = (R::get(xs, i), R::get(zs, i));
            R::set(out, i, (x * x + z * z).sqrt() * a + b);
        }
    }
    follow_curve::<R>(out, active, &words[RAMP_WORDS..]);
}

/// Returns the first words of a list.
#[inline(always)]
fn head<const N: usize>(words: &[f32]) -> &[f32; N] {
    words.first_chunk().unwrap_or(&[0.0; N])
}

// These are loops and not closures for `map_point`, because a closure that is not inlined loses the caller's vector
// instructions.

/// Moves points back by a share of a vector.
#[inline(always)]
pub(crate) fn shift_points<R: Real>(
    point: &mut [R::Lanes; 3],
    shares: &mut R::Lanes,
    active: usize,
    words: &[f32],
) {
    ramp_values::<R>(point, shares, active, &words[3..]);
    let by: &[f32; 3] = head(words);
    for (lanes, &by) in point.iter_mut().zip(by) {
        for i in 0..active.min(LANES) {
            let moved = R::get(lanes, i) - R::get(shares, i) * by;
            R::set(lanes, i, moved);
        }
    }
}

/// Turns points about the y axis into the plane z = 0.
#[inline(always)]
pub(crate) fn revolve_points<R: Real>([xs, _, zs]: &mut [R::Lanes; 3], active: usize, offset: f32) {
    for i in 0..active.min(LANES) {
        let (x, z) = (R::get(xs, i), R::get(zs, i));
        R::set(xs, i, (x * x + z * z).sqrt() - offset);
        R::set(zs, i, R::constant(0.0));
    }
}

/// Unrolls the space around the y axis. The rough angle becomes exact by one step of Newton's method, with its
/// derivative.
#[inline(always)]
pub(crate) fn wrap_points<R: Real>(
    [xs, _, zs]: &mut [R::Lanes; 3],
    places: &mut R::Lanes,
    active: usize,
    words: &[f32],
) {
    let &[from, length, radius, core] = head(words);
    for i in 0..active.min(LANES) {
        let (x, z) = (R::get(xs, i), R::get(zs, i));
        let rough = rough_atan2(-z.value(), x.value());
        let (s, c) = sin_cos(rough);
        let (across, along) = (-(z * c) - x * s, x * c - z * s);
        let turn = if along.value() > 0.0 {
            across / along
        } else {
            R::constant(0.0)
        };
        R::set(places, i, (turn + rough) * (1.0 / TAU) + 0.5);
        R::set(
            zs,
            i,
            (x * x + z * z).sqrt().max(R::constant(core)) - radius,
        );
    }
    follow_curve::<R>(places, active, &words[WRAP_WORDS..]);
    for i in 0..active.min(LANES) {
        R::set(xs, i, R::get(places, i) * length + from);
    }
}

/// Cuts off the core around the axis, in which the distance comes from its border. The distance is at least that to a
/// cylinder around the solid, because near the core the solid's own is divided by a large stretch.
#[inline(always)]
pub(crate) fn unwrap<R: Real>(d: R, [x, y, z]: [R; 3], words: &[f32; WRAP_WORDS]) -> R {
    let &[_, _, _, core, scale, low, high, radius, length_scale] = words;
    let r = (x * x + z * z).sqrt();
    let around = corner2(r - radius, (-y + low).max(y - high)) * length_scale;
    let gap = (-r + core) * scale;
    let solid = if r.value() >= core {
        d.max(gap)
    } else if r.value() >= WRAP_TRUSTED * core {
        gap.max(d - gap)
    } else {
        gap
    };
    solid.max(around)
}

/// Ends the distance of a section along z.
#[inline(always)]
pub(crate) fn extrude<R: Real>(d: R, z: R, &[half, scale]: &[f32; EXTRUDE_WORDS]) -> R {
    let beyond = (z.abs() - half) * scale;
    let (outside, above) = (d.positive_part(), beyond.positive_part());
    if outside.value() > 0.0 && above.value() > 0.0 {
        (outside * outside + above * above).sqrt()
    } else {
        d.max(beyond)
    }
}

/// Returns a morph whose share follows a ramp.
#[inline(always)]
pub(crate) fn combine_ramped<R: Real>(
    a: R,
    b: R,
    share: R,
    max_difference: f32,
    inverse: f32,
) -> R {
    let difference = (b - a).clamp_to(-max_difference, max_difference);
    (a + difference * share) * inverse
}
