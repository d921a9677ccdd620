//! Instructions that change the points of what follows, or undo that.

use crate::domain_ops::{TWIST_WORDS, bend, held, map_point, twist, unclamp};
use crate::interpreter_state::{InterpreterState, lanes_of, restore_point, words};
use crate::ramps::{
    EXTRUDE_WORDS, WRAP_WORDS, extrude, revolve_points, shift_points, unwrap, wrap_points,
};
use crate::relative_points::displace;
use crate::scalar::Real;
use argil_abi as abi;

/// Whether an instruction changes the points by more than an affine map.
#[inline(always)]
pub(crate) fn is_domain_change(op: u32) -> bool {
    matches!(
        op,
        abi::OP_MIRROR
            | abi::OP_ELONGATE
            | abi::OP_TWIST
            | abi::OP_BEND
            | abi::OP_FLATTEN
            | abi::OP_REVOLVE
            | abi::OP_SHIFT
            | abi::OP_WRAP
    )
}

/// Restores the points that a change has saved, and adapts the distances.
#[inline(always)]
pub(crate) fn undo_domain<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    op: u32,
    at: usize,
) {
    restore_point(r);
    match op {
        abi::OP_EXTRUDE => extrude_values(r, words(params, at)),
        abi::OP_UNWRAP => unwrap_values(r, words(params, at)),
        _ => unclamp_values(r, words(params, at)),
    }
}

/// Moves the surface outward, keeps a shell around it, or adds noise.
#[inline(always)]
pub(crate) fn offset<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    instr: &abi::Instruction,
) {
    let at = instr.params as usize;
    match instr.op {
        abi::OP_ROUND => round(r, words(params, at)),
        abi::OP_SHELL => shell(r, words(params, at)),
        _ => displace(r, words(params, at), instr.operand),
    }
}

/// Folds or deforms the space of what follows.
#[inline(always)]
pub(crate) fn change_domain<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    op: u32,
    at: usize,
) {
    match op {
        abi::OP_MIRROR => mirror(r, words(params, at)),
        abi::OP_ELONGATE => elongate(r, words(params, at)),
        abi::OP_TWIST => warp(r, words(params, at), twist),
        abi::OP_BEND => warp(r, words(params, at), bend),
        abi::OP_FLATTEN => {
            r.points.push(r.point.clone());
            r.point[2] = R::splat(0.0);
        }
        abi::OP_REVOLVE => revolve_points::<R>(&mut r.point, r.active, params[at]),
        abi::OP_SHIFT => shift_points::<R>(&mut r.point, &mut r.share, r.active, &params[at..]),
        _ => {
            r.points.push(r.point.clone());
            wrap_points::<R>(&mut r.point, &mut r.share, r.active, &params[at..]);
        }
    }
}

#[inline(always)]
fn mirror<R: Real>(r: &mut InterpreterState<R>, w: &[f32; 3]) {
    map_point::<R>(&mut r.point, r.active, |[x, y, z]| {
        let fold = |c: R, on: f32| if on > 0.0 { c.abs() } else { c };
        [fold(x, w[0]), fold(y, w[1]), fold(z, w[2])]
    });
}

#[inline(always)]
fn elongate<R: Real>(r: &mut InterpreterState<R>, w: &[f32; 3]) {
    map_point::<R>(&mut r.point, r.active, |[x, y, z]| {
        let pull = |c: R, by: f32| c - c.clamp_to(-by, by);
        [pull(x, w[0]), pull(y, w[1]), pull(z, w[2])]
    });
}

/// Twists or bends the points, clamped to where that is bounded.
#[inline(always)]
fn warp<R: Real>(
    r: &mut InterpreterState<R>,
    w: &[f32; TWIST_WORDS],
    turn: impl Fn([R; 3], f32) -> [R; 3],
) {
    r.points.push(r.point.clone());
    let [xs, ys, zs] = &mut r.point;
    for i in lanes_of(r.active) {
        let p = [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
        let [x, y, z] = turn(held(p, w), w[6]);
        R::set(xs, i, x);
        R::set(ys, i, y);
        R::set(zs, i, z);
    }
}

// Loops over points are functions here and not closures, because a closure that is not inlined loses the caller's
// vector instructions.

#[inline(always)]
fn unclamp_values<R: Real>(r: &mut InterpreterState<R>, w: &[f32; TWIST_WORDS]) {
    let [xs, ys, zs] = &r.point;
    for i in lanes_of(r.active) {
        let p = [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
        let d = unclamp(R::get(&r.acc, i), p, w);
        R::set(&mut r.acc, i, d);
    }
}

#[inline(always)]
fn extrude_values<R: Real>(r: &mut InterpreterState<R>, w: &[f32; EXTRUDE_WORDS]) {
    for i in lanes_of(r.active) {
        let d = extrude(R::get(&r.acc, i), R::get(&r.point[2], i), w);
        R::set(&mut r.acc, i, d);
    }
}

#[inline(always)]
fn unwrap_values<R: Real>(r: &mut InterpreterState<R>, words: &[f32; WRAP_WORDS]) {
    let [xs, ys, zs] = &r.point;
    for i in lanes_of(r.active) {
        let p = [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
        let d = unwrap(R::get(&r.acc, i), p, words);
        R::set(&mut r.acc, i, d);
    }
}

#[inline(always)]
fn round<R: Real>(r: &mut InterpreterState<R>, &[radius]: &[f32; 1]) {
    for i in lanes_of(r.active) {
        let d = R::get(&r.acc, i) - radius;
        R::set(&mut r.acc, i, d);
    }
}

#[inline(always)]
fn shell<R: Real>(r: &mut InterpreterState<R>, &[half_thickness]: &[f32; 1]) {
    for i in lanes_of(r.active) {
        let d = R::get(&r.acc, i).abs() - half_thickness;
        R::set(&mut r.acc, i, d);
    }
}
