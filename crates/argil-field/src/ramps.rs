//! Curves and ramps, and what follows them: shifts, wraps, sections. `ramps.wgsl` is the twin.

use crate::domain_ops::rough_atan2;
use crate::scalar::{Real, sin_cos};
use argil_abi::WRAP_TRUSTED;
use std::f32::consts::TAU;

/// Words of a ramp before its curve: 0 for a line or 1 for a radius, and four factors. A line's value is a · x + b · y
/// + c · z + d, and a radius's is a · r + b.
pub(crate) const RAMP_WORDS: usize = 5;
/// Words of a wrap before its curve: start and length along x, radius, radius of the core, and the scale to the scene's
/// unit.
pub(crate) const WRAP_WORDS: usize = 5;
/// Words of an extrusion: half of its length, and the scale to the scene's unit.
pub(crate) const EXTRUDE_WORDS: usize = 2;

/// Evaluates a curve: the number of its pieces, then four coefficients for each.
#[inline(always)]
pub(crate) fn curve<R: Real>(t: R, words: &[f32]) -> R {
    let pieces = words[0];
    let along = t.clamp_to(0.0, 1.0) * pieces;
    let nth = Real::clamp_to(along.value().floor(), 0.0, pieces - 1.0);
    let u = along - nth;
    let own = &words[1 + 4 * nth as usize..][..4];
    u * (u * (u * own[3] + own[2]) + own[1]) + own[0]
}

/// Returns the value of a ramp at a point.
#[inline(always)]
pub(crate) fn ramp<R: Real>([x, y, z]: [R; 3], words: &[f32]) -> R {
    let place = if words[0] == 0.0 {
        x * words[1] + y * words[2] + z * words[3] + words[4]
    } else {
        (x * x + z * z).sqrt() * words[1] + words[2]
    };
    curve(place, &words[RAMP_WORDS..])
}

/// Moves a point back by a share of a vector.
#[inline(always)]
pub(crate) fn shift<R: Real>(p: [R; 3], words: &[f32]) -> [R; 3] {
    let share = ramp(p, &words[3..]);
    [
        p[0] - share * words[0],
        p[1] - share * words[1],
        p[2] - share * words[2],
    ]
}

/// Turns a point about the y axis into the plane z = 0.
#[inline(always)]
pub(crate) fn revolve<R: Real>([x, y, z]: [R; 3], offset: f32) -> [R; 3] {
    [(x * x + z * z).sqrt() - offset, y, R::constant(0.0)]
}

/// Unrolls the space around the y axis. The rough angle becomes exact by one step of Newton's method, with its
/// derivative.
#[inline(always)]
pub(crate) fn wrap<R: Real>([x, y, z]: [R; 3], words: &[f32]) -> [R; 3] {
    let rough = rough_atan2(-z.value(), x.value());
    let (s, c) = sin_cos(rough);
    let (across, along) = (-(z * c) - x * s, x * c - z * s);
    let turn = if along.value() > 0.0 {
        across / along
    } else {
        R::constant(0.0)
    };
    let place = curve((turn + rough) * (1.0 / TAU) + 0.5, &words[WRAP_WORDS..]);
    let r = (x * x + z * z).sqrt().max(R::constant(words[3]));
    [place * words[1] + words[0], y, r - words[2]]
}

/// Cuts off the core around the axis, in which the distance comes from its border.
#[inline(always)]
pub(crate) fn unwrap<R: Real>(d: R, [x, _, z]: [R; 3], words: &[f32]) -> R {
    let (core, scale) = (words[3], words[4]);
    let r = (x * x + z * z).sqrt();
    let gap = (-r + core) * scale;
    if r.value() >= core {
        d.max(gap)
    } else if r.value() >= WRAP_TRUSTED * core {
        gap.max(d - gap)
    } else {
        gap
    }
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
