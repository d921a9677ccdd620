//! Points that are relative to an origin: see `places.rs`. They are until a map moves them into a solid's frame, or an
//! instruction needs them in the scene's space.

use crate::domain_ops::map_point;
use crate::eval_brush::mapped;
use crate::interpreter_state::{InterpreterState, words};
use crate::noise;
use crate::places::{placed, wrapped};
use crate::ramps::ramp_values;
use crate::scalar::{LANES, Real, SIMD_BLOCK};
use argil_abi as abi;

/// Amplitude, frequency and octaves of noise, the stretch, the most that noise can add, and the distance, divided by
/// the stretch, beyond which it does not matter.
const DISPLACE_WORDS: usize = 6;
/// The place of the octaves among them.
pub(crate) const OCTAVES_WORD: usize = 2;

/// Moves the points into a solid's frame, in which they are no longer relative to an origin. `next` is the next
/// instruction.
#[inline(always)]
pub(crate) fn affine<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    at: usize,
    next: Option<&abi::Instruction>,
) {
    let Some(origin) = r.current_origin() else {
        let m = words(params, at);
        map_point::<R>(&mut r.point, r.active, |p| mapped(p, m));
        return;
    };
    let m = placed(params, at, origin, repeat_after(params, next));
    map_point::<R>(&mut r.point, r.active, |p| mapped(p, &m));
    r.absolute_from = r.points.len();
}

/// Evaluates the ramp of the next morph, behind a map from the points.
#[inline(always)]
pub(crate) fn set_share<R: Real>(r: &mut InterpreterState<R>, params: &[f32], at: usize) {
    let m = match r.current_origin() {
        Some(origin) => placed(params, at, origin, &[]),
        None => *words(params, at),
    };
    let ramp = &params[at + m.len()..];
    let mut moved = r.point.clone();
    map_point::<R>(&mut moved, r.active, |p| mapped(p, &m));
    ramp_values::<R>(&moved, &mut r.share, r.active, ramp);
}

/// Returns the words of a repetition, if the next instruction is one.
fn repeat_after<'a>(params: &'a [f32], next: Option<&abi::Instruction>) -> &'a [f32] {
    match next {
        Some(next) if next.op == abi::OP_REPEAT => {
            params.get(next.params as usize..).unwrap_or(&[])
        }
        _ => &[],
    }
}

/// Makes the points relative to the scene's origin, before an instruction that needs that.
#[inline(always)]
pub(crate) fn leave_origin<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    next: &abi::Instruction,
) {
    let Some(origin) = r.current_origin() else {
        return;
    };
    let [x, y, z] = wrapped(origin.to_array(), repeat_after(params, Some(next)));
    map_point::<R>(&mut r.point, r.active, |p| {
        [
            p[0] + R::constant(x),
            p[1] + R::constant(y),
            p[2] + R::constant(z),
        ]
    });
    r.absolute_from = r.points.len();
}

/// Displaces at points relative to the scene's origin, which noise begins at.
#[inline(always)]
pub(crate) fn displace<R: Real>(
    r: &mut InterpreterState<R>,
    words: &[f32; DISPLACE_WORDS],
    seed: u32,
) {
    let Some(origin) = r.current_origin() else {
        return displace_here(r, words, seed);
    };
    let relative = r.point.clone();
    let offset = origin.as_vec3();
    map_point::<R>(&mut r.point, r.active, |p| {
        [
            p[0] + R::constant(offset.x),
            p[1] + R::constant(offset.y),
            p[2] + R::constant(offset.z),
        ]
    });
    displace_here(r, words, seed);
    r.point = relative;
}

/// Adds noise to the distances, which are divided by the stretch. What they would be without noise and without that,
/// less or more by the most that noise can add, bounds them: both keep the Lipschitz constant, and agree on the
/// surface. So distances far away are nearly true, and need no noise.
#[inline(always)]
fn displace_here<R: Real>(
    r: &mut InterpreterState<R>,
    &[amplitude, frequency, octaves, stretch, most, far]: &[f32; DISPLACE_WORDS],
    seed: u32,
) {
    let [xs, ys, zs] = &r.point;
    for first in (0..r.active.min(LANES)).step_by(SIMD_BLOCK) {
        let block = first..(first + SIMD_BLOCK).min(LANES);
        let mut noise = [R::constant(0.0); SIMD_BLOCK];
        let is_near = |i: usize| R::get(&r.acc, i).value().abs() < far;
        if block.clone().any(is_near) {
            let (mut amplitude, mut frequency, mut seed) = (amplitude, frequency, seed);
            for _ in 0..octaves as u32 {
                for (noise, i) in noise.iter_mut().zip(block.clone()) {
                    let p = [
                        R::get(xs, i) * frequency,
                        R::get(ys, i) * frequency,
                        R::get(zs, i) * frequency,
                    ];
                    *noise = *noise + noise::value_noise(p, seed) * amplitude;
                }
                (amplitude, frequency) = (0.5 * amplitude, 2.0 * frequency);
                seed = seed.wrapping_add(1);
            }
        }
        for (noise, i) in noise.into_iter().zip(block) {
            let d = R::get(&r.acc, i);
            let smooth = d * stretch;
            let held = (d + noise).max(smooth - most).min(smooth + most);
            R::set(&mut r.acc, i, held);
        }
    }
}
