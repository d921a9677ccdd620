//! The interpreter on the CPU: one instruction at a time over [`LANES`] points. `interpreter.wgsl` is the twin, one
//! point at a time.

use crate::bounded_group::skip_group;
use crate::combine::{Joint, combine_chamfer, combine_morph, combine_smooth};
use crate::copy_loops::{begin_copies, next};
use crate::dispatch::measure;
use crate::domain_changes::{change_domain, is_domain_change, offset, undo_domain};
use crate::eval_brush::{BrushParams, HEADER};
use crate::interpreter_state::{InterpreterState, lanes_of, restore_point, save_value, words};
use crate::material_mix::{
    join_aside, mark_brush, mark_group, mix_materials, mix_saved, put_aside, weights,
};
use crate::places::placed;
use crate::prefetch::prefetch;
use crate::ramps::combine_ramped;
use crate::relative_points::{affine, leave_origin, set_share};
use crate::scalar::{F32Lanes, Real};
use crate::textured_brush::mix_textured;
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
    let carries = [materials, marks];
    if !r.continues {
        begin(r);
    }
    // The least distance so far also skips what is farther within a group.
    let inherits = program.is_hard_union && !materials;
    r.absolute_from = usize::MAX;
    let any_exiled = mask_outside_world::<R>(&mut r.point, &mut r.outside_world, r.active);
    if materials && program.has_textures() {
        keep_points(r);
    }
    let params = &program.params[..];
    // Caches hold the parameters of short lists.
    let is_long = instructions.len() > 64;
    let mut pc = 0;
    while let Some(&abi::Instruction {
        op,
        flags,
        params: at,
        operand,
    }) = instructions.get(pc)
    {
        if is_long && let Some(later) = instructions.get(pc + AHEAD) {
            prefetch(params, later.params as usize);
        }
        pc += 1;
        let at = at as usize;
        if op < abi::OP_SHAPES_END {
            brush::<R, APART>(program, r, &instructions[pc - 1], pc - 1, carries);
            continue;
        }
        match op {
            abi::OP_PUSH_VALUE => {
                let may_skip = flags & (abi::FLAG_BOUNDED | abi::FLAG_PAINT) != 0;
                // A closure would be compiled without wide vectors.
                let end = if may_skip {
                    skip_group(r, params, instructions, pc - 1, carries)
                } else {
                    None
                };
                match end {
                    Some(end) => pc = end + 1,
                    None => save_value(r, materials, inherits),
                }
            }
            abi::OP_COMBINE => combine(r, params, &instructions[pc - 1], pc - 1, carries),
            abi::OP_PUSH_POINT => r.points.push(r.point.clone()),
            abi::OP_POP_POINT => restore_point(r),
            abi::OP_AFFINE => affine(r, params, at, instructions.get(pc)),
            op if is_domain_change(op) => {
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
            abi::OP_UNCLAMP | abi::OP_EXTRUDE | abi::OP_UNWRAP => undo_domain(r, params, op, at),
            abi::OP_RAMP => set_share(r, params, at),
            abi::OP_ROUND | abi::OP_SHELL | abi::OP_DISPLACE => {
                offset(r, params, &instructions[pc - 1])
            }
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

#[inline(always)]
fn begin<R: Real>(r: &mut InterpreterState<R>) {
    for i in lanes_of(r.active) {
        R::set(&mut r.acc, i, R::constant(r.start));
    }
}

/// Keeps where points are in the scene, for textures that are fixed to it.
fn keep_points<R: Real>(r: &mut InterpreterState<R>) {
    let origin = r.current_origin().unwrap_or_default().to_array();
    for (axis, origin) in origin.into_iter().enumerate() {
        for i in lanes_of(r.active) {
            r.at[axis].0[i] = (f64::from(R::get(&r.point[axis], i).value()) + origin) as f32;
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
            if flags >> abi::TEXTURES_SHIFT != 0 {
                mix_textured(program, r, instr, &b, &w);
            } else {
                let m = program.materials.appearance(instr.operand as usize);
                mix_materials(r, |k, _| m[k], &w);
            }
        }
        join_aside(r, &joint);
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
    if materials {
        let w = weights::<R>(&saved, &r.acc, &j, flags, &r.share, r.active);
        mix_saved(r, flags & abi::FLAG_SWAPPED == 0, &w);
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
