//! Loops over the copies of a repetition: which are evaluated, and which are too far.

use crate::FAR;
use crate::domain_ops::{COPY_WORDS, RADIAL_WORDS, REPEAT_WORDS, radial_points, repeat_axis};
use crate::interpreter_state::{InterpreterState, lanes_of, restore_point, save_value, words};
use crate::scalar::Real;
use argil_abi as abi;

/// Begins with the first of the copies to evaluate.
#[inline(always)]
pub(crate) fn begin_copies<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    op: u32,
    at: usize,
    materials: bool,
) {
    r.points.push(r.point.clone());
    save_value(r, materials, false);
    r.loops.push(0);
    candidate(r, params, op, at, 0);
}

/// Keeps the nearer of this copy and the nearest before it, and begins the next one. Returns whether there is one.
#[inline(always)]
pub(crate) fn next<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    begin: &abi::Instruction,
    materials: bool,
) -> bool {
    let active = r.active;
    let (Some(done), Some(least)) = (r.loops.last_mut(), r.values.last_mut()) else {
        return false;
    };
    *done += 1;
    let done = *done;
    for i in lanes_of(active) {
        let (a, b) = (R::get(least, i), R::get(&r.acc, i));
        let nearer = b.value() < a.value();
        R::set(least, i, if nearer { b } else { a });
        if materials
            && nearer
            && let Some(begin) = r.materials.len().checked_sub(r.properties)
        {
            for (kept, lanes) in r.materials[begin..].iter_mut().zip(r.material.iter()) {
                kept.0[i] = lanes.0[i];
            }
        }
    }
    let (op, at) = (begin.op, begin.params as usize);
    for copy in done..candidates(params, op, at) {
        candidate(r, params, op, at, copy);
        if is_too_far(r, params, op, at) {
            continue;
        }
        if let Some(done) = r.loops.last_mut() {
            *done = copy;
        }
        r.acc = R::splat(FAR);
        return true;
    }
    r.loops.pop();
    r.acc = r.values.pop().unwrap_or_else(|| R::splat(FAR));
    if materials && let Some(begin) = r.materials.len().checked_sub(r.properties) {
        for (carried, kept) in r.material.iter_mut().zip(r.materials.drain(begin..)) {
            *carried = kept;
        }
    }
    restore_point(r);
    false
}

/// Whether the current copy is farther than the nearest one so far, in every lane.
#[inline(always)]
fn is_too_far<R: Real>(r: &InterpreterState<R>, params: &[f32], op: u32, at: usize) -> bool {
    let Some(least) = r.values.last() else {
        return false;
    };
    let copy_words = at
        + if op == abi::OP_REPEAT {
            REPEAT_WORDS
        } else {
            RADIAL_WORDS
        };
    let w: &[f32; COPY_WORDS] = words(params, copy_words);
    let [xs, ys, zs] = &r.point;
    let mut is_near = 0u32;
    for i in lanes_of(r.active) {
        let beyond = |lanes: &R::Lanes, axis: usize| {
            let c = R::get(lanes, i).value();
            c - Real::clamp_to(c, w[axis], w[3 + axis])
        };
        let (x, y, z) = (beyond(xs, 0), beyond(ys, 1), beyond(zs, 2));
        // Within the box, nothing is known.
        let needed = Real::positive_part(R::get(least, i).value() + w[7]);
        let is_far = (x * x + y * y + z * z) * w[6] > needed * needed;
        is_near |= u32::from(!is_far);
    }
    is_near == 0
}

/// Returns the copies that a loop evaluates.
fn candidates(params: &[f32], op: u32, at: usize) -> u32 {
    if op == abi::OP_REPEAT {
        let w: &[f32; REPEAT_WORDS] = words(params, at);
        (w[12] * w[13] * w[14]) as u32
    } else {
        let w: &[f32; RADIAL_WORDS] = words(params, at);
        w[2] as u32
    }
}

/// Places the points relative to a loop's copy `j`.
#[inline(always)]
fn candidate<R: Real>(r: &mut InterpreterState<R>, params: &[f32], op: u32, at: usize, j: u32) {
    let active = r.active;
    let Some(saved) = r.points.last() else { return };
    if op == abi::OP_REPEAT {
        let [xs, ys, zs] = saved;
        let [px, py, pz] = &mut r.point;
        let w: &[f32; REPEAT_WORDS] = words(params, at);
        let (nx, ny) = (w[12] as u32, w[13] as u32);
        let (jx, jy, jz) = (
            (j % nx.max(1)) as f32,
            (j / nx.max(1) % ny.max(1)) as f32,
            (j / (nx * ny).max(1)) as f32,
        );
        for i in lanes_of(active) {
            R::set(px, i, repeat_axis(R::get(xs, i), jx, w, 0));
            R::set(py, i, repeat_axis(R::get(ys, i), jy, w, 1));
            R::set(pz, i, repeat_axis(R::get(zs, i), jz, w, 2));
        }
    } else {
        let w: &[f32; RADIAL_WORDS] = words(params, at);
        radial_points::<R>(saved, &mut r.point, j as f32, w, active);
    }
}
