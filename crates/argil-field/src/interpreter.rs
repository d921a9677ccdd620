//! The interpreter on the CPU: one instruction at a time over [`LANES`] points. `interpreter.wgsl` is the twin, one
//! point at a time.

use crate::bounded_group::skip_group;
use crate::combine::{Joint, combine_chamfer, combine_morph, combine_smooth};
use crate::dispatch::measure;
use crate::domain_ops::{
    COPY_WORDS, RADIAL_WORDS, REPEAT_WORDS, TWIST_WORDS, bend, map_point, radial_points,
    repeat_axis, twist, unclamp,
};
use crate::eval_brush::{BrushParams, HEADER};
use crate::interpreter_state::{InterpreterState, words};
use crate::material_mix::{join_aside, mark_brush, mark_group, mix_materials, put_aside, weights};
use crate::places::placed;
use crate::prefetch::prefetch;
use crate::ramps::{
    EXTRUDE_WORDS, combine_ramped, extrude, revolve_points, shift_points, unwrap, wrap_points,
};
use crate::relative_points::{affine, displace, leave_origin, set_share};
use crate::scalar::{F32Lanes, LANES, Real};
use crate::{FAR, Program, WORLD_LIMIT};
use argil_abi as abi;

/// What a run carries besides distances.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Carried {
    Nothing,
    Materials,
    /// Which operand of each joint cannot matter around each lane's point: see `prune.rs`.
    Marks,
}

/// The number of instructions by which parameters are prefetched.
const AHEAD: usize = 4;

/// Runs a list of a program's instructions on the points in the state. With `APART`, each brush is measured by
/// itself and then joined, which everything carried needs; without, nothing is carried. What is carried is not a
/// type parameter, because each copy of this function takes seconds to compile.
#[inline(always)]
pub(crate) fn run<R: Real, const APART: bool>(
    program: &Program,
    instructions: &[abi::Instruction],
    r: &mut InterpreterState<R>,
    carried: Carried,
) {
    let materials = APART && carried == Carried::Materials;
    let marks = APART && carried == Carried::Marks;
    for i in lanes_of(r.active) {
        R::set(&mut r.acc, i, R::constant(r.start));
    }
    r.absolute_from = usize::MAX;
    let any_exiled = mask_outside_world::<R>(&mut r.point, &mut r.outside_world, r.active);
    let params = &program.params[..];
    // Caches hold the parameters of short lists.
    let is_long = instructions.len() > 64;
    let mut pc = 0;
    while let Some(&abi::Instruction {
        op,
        params: at,
        operand,
        ..
    }) = instructions.get(pc)
    {
        if is_long && let Some(later) = instructions.get(pc + AHEAD) {
            prefetch(params, later.params as usize);
        }
        pc += 1;
        let at = at as usize;
        if op < abi::OP_SHAPES_END {
            brush::<R, APART>(
                program,
                r,
                &instructions[pc - 1],
                pc - 1,
                [materials, marks],
            );
            continue;
        }
        match op {
            abi::OP_PUSH_VALUE => {
                let is_bounded = instructions[pc - 1].flags & abi::FLAG_BOUNDED != 0;
                match is_bounded.then(|| skip_group(r, params, instructions, pc - 1, marks)) {
                    Some(Some(end)) => pc = end + 1,
                    _ => save_value(r, materials),
                }
            }
            abi::OP_COMBINE => {
                combine(r, params, &instructions[pc - 1], pc - 1, [materials, marks])
            }
            abi::OP_PUSH_POINT => r.points.push(r.point.clone()),
            abi::OP_POP_POINT => restore_point(r),
            abi::OP_AFFINE => affine(r, params, at, instructions.get(pc)),
            abi::OP_MIRROR
            | abi::OP_ELONGATE
            | abi::OP_TWIST
            | abi::OP_BEND
            | abi::OP_FLATTEN
            | abi::OP_REVOLVE
            | abi::OP_SHIFT
            | abi::OP_WRAP => {
                leave_origin(r, params, &instructions[pc - 1]);
                change_domain(r, params, op, at);
            }
            abi::OP_REPEAT | abi::OP_RADIAL => {
                leave_origin(r, params, &instructions[pc - 1]);
                begin_copies(r, params, op, at, materials);
            }
            abi::OP_NEXT => {
                let begin = &instructions[operand as usize];
                if next(r, params, begin, materials) {
                    pc = operand as usize + 1;
                }
            }
            abi::OP_UNCLAMP => {
                restore_point(r);
                unclamp_values(r, words(params, at));
            }
            abi::OP_EXTRUDE => {
                restore_point(r);
                extrude_values(r, words(params, at));
            }
            abi::OP_UNWRAP => {
                restore_point(r);
                unwrap_values(r, &params[at..]);
            }
            abi::OP_RAMP => set_share(r, params, at),
            abi::OP_ROUND => round(r, words(params, at)),
            abi::OP_SHELL => shell(r, words(params, at)),
            abi::OP_DISPLACE => displace(r, words(params, at), operand),
            _ => {}
        }
    }
    if any_exiled {
        for i in lanes_of(r.active) {
            let d = if r.outside_world.0[i] > 0.0 {
                R::constant(FAR)
            } else {
                R::get(&r.acc, i)
            };
            R::set(&mut r.acc, i, d);
        }
    }
}

/// Measures a brush and joins it with the accumulator.
#[inline(always)]
fn brush<R: Real, const APART: bool>(
    program: &Program,
    r: &mut InterpreterState<R>,
    instr: &abi::Instruction,
    place: usize,
    [materials, marks]: [bool; 2],
) {
    let (flags, at) = (instr.flags, instr.params as usize);
    // What is carried needs the brush measured by itself first.
    let mut b = BrushParams::read(&program.params, at);
    if let Some(origin) = r.current_origin() {
        b.m = placed(&program.params, at, origin, &[]);
    }
    let joint = b.joint;
    if APART {
        b.joint = Joint::HARD_UNION;
        put_aside(r);
    }
    measure(program, r, instr.op, flags, &b, at + HEADER);
    if APART {
        if marks {
            mark_brush(r, place, &joint, flags);
        }
        if materials {
            let w = weights::<R>(&r.aside, &r.acc, &joint, flags, &r.share, r.active);
            let m = &program.materials[instr.operand as usize];
            let of = |k: usize| {
                if k < 4 {
                    m.base_roughness[k]
                } else {
                    m.emission_metallic[k - 4]
                }
            };
            mix_materials(&mut r.material, r.active, |k, _| of(k), &w);
        }
        join_aside(r, &joint);
    }
}

/// Pushes the accumulator onto the stack, and starts again with an empty one.
#[inline(always)]
fn save_value<R: Real>(r: &mut InterpreterState<R>, materials: bool) {
    r.values.push(std::mem::replace(&mut r.acc, R::splat(FAR)));
    if materials {
        r.materials.push((*r.material).clone());
    }
}

#[inline(always)]
fn restore_point<R: Real>(r: &mut InterpreterState<R>) {
    if let Some(point) = r.points.pop() {
        r.point = point;
    }
    if r.points.len() < r.absolute_from {
        r.absolute_from = usize::MAX;
    }
}

/// Joins the accumulator with the top of the stack.
#[inline(always)]
fn combine<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    instr: &abi::Instruction,
    place: usize,
    [materials, marks]: [bool; 2],
) {
    let flags = instr.flags;
    let w: &[f32; 6] = words(params, instr.params as usize);
    let j = Joint {
        k: w[0],
        inv_4k: w[1],
        sa: w[2],
        sb: w[3],
        sr: w[4],
        amount: w[5],
    };
    let Some(mut saved) = r.values.pop() else {
        return;
    };
    // From here, `saved` is a and the accumulator is b.
    if flags & abi::FLAG_SWAPPED != 0 {
        std::mem::swap(&mut saved, &mut r.acc);
    }
    if materials && let Some(mut other) = r.materials.pop() {
        if flags & abi::FLAG_SWAPPED != 0 {
            std::mem::swap(&mut other, &mut r.material);
        }
        let w = weights::<R>(&saved, &r.acc, &j, flags, &r.share, r.active);
        mix_materials(&mut other, r.active, |k, i| r.material[k].0[i], &w);
        *r.material = other;
    }
    if marks {
        mark_group::<R>(r, place, &saved, &j, flags);
    }
    for i in lanes_of(r.active) {
        let (a, b) = (R::get(&saved, i), R::get(&r.acc, i));
        let d = match flags & abi::COMBINE_MASK {
            abi::COMBINE_CHAMFER => combine_chamfer(a, b, &j),
            abi::COMBINE_PAINT => a,
            abi::COMBINE_MORPH => combine_morph(a, b, &j),
            abi::COMBINE_RAMPED => {
                let &[max_difference, inverse] = words(params, instr.params as usize + 6);
                combine_ramped(a, b, R::get(&r.share, i), max_difference, inverse)
            }
            _ => combine_smooth(a, b, &j),
        };
        R::set(&mut r.acc, i, d);
    }
}

/// Begins with the first of the copies to evaluate.
#[inline(always)]
fn begin_copies<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    op: u32,
    at: usize,
    materials: bool,
) {
    r.points.push(r.point.clone());
    save_value(r, materials);
    r.loops.push(0);
    candidate(r, params, op, at, 0);
}

/// Keeps the nearer of this copy and the nearest before it, and begins the next one. Returns whether there is one.
#[inline(always)]
fn next<R: Real>(
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
            && let Some(kept) = r.materials.last_mut()
        {
            for (kept, own) in kept.iter_mut().zip(r.material.iter()) {
                kept.0[i] = own.0[i];
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
    if materials && let Some(kept) = r.materials.pop() {
        *r.material = kept;
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
    let own = at
        + if op == abi::OP_REPEAT {
            REPEAT_WORDS
        } else {
            RADIAL_WORDS
        };
    let w: &[f32; COPY_WORDS] = words(params, own);
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

/// Folds or deforms the space of what follows.
#[inline(always)]
fn change_domain<R: Real>(r: &mut InterpreterState<R>, params: &[f32], op: u32, at: usize) {
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

/// Twists or bends the points, clamped to the box in which that is bounded.
#[inline(always)]
fn warp<R: Real>(
    r: &mut InterpreterState<R>,
    w: &[f32; TWIST_WORDS],
    turn: impl Fn([R; 3], f32) -> [R; 3],
) {
    r.points.push(r.point.clone());
    let [xs, ys, zs] = &mut r.point;
    for i in lanes_of(r.active) {
        let held = [
            R::get(xs, i).clamp_to(w[0], w[3]),
            R::get(ys, i).clamp_to(w[1], w[4]),
            R::get(zs, i).clamp_to(w[2], w[5]),
        ];
        let [x, y, z] = turn(held, w[6]);
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
fn unwrap_values<R: Real>(r: &mut InterpreterState<R>, words: &[f32]) {
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

/// Returns the lanes in use, so that the optimizer knows their number.
#[inline(always)]
fn lanes_of(active: usize) -> std::ops::Range<usize> {
    0..active.min(LANES)
}

/// Moves points outside the world to its origin, so that no arithmetic overflows, and marks their lanes with 1.
/// Returns whether there are any. Most batches have none, and are only read.
#[inline(always)]
fn mask_outside_world<R: Real>(
    [xs, ys, zs]: &mut [R::Lanes; 3],
    exiled: &mut F32Lanes,
    active: usize,
) -> bool {
    let is_in_world = |c: R| c.value().abs() <= WORLD_LIMIT;
    let mut outside = 0u32;
    for i in lanes_of(active) {
        let stays =
            is_in_world(R::get(xs, i)) & is_in_world(R::get(ys, i)) & is_in_world(R::get(zs, i));
        outside |= u32::from(!stays);
    }
    if outside == 0 {
        return false;
    }
    for i in lanes_of(active) {
        let [x, y, z] = [R::get(xs, i), R::get(ys, i), R::get(zs, i)];
        let stays = is_in_world(x) & is_in_world(y) & is_in_world(z);
        let keep = |c: R| if stays { c } else { R::constant(0.0) };
        R::set(xs, i, keep(x));
        R::set(ys, i, keep(y));
        R::set(zs, i, keep(z));
        exiled.0[i] = if stays { 0.0 } else { 1.0 };
    }
    true
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
