//! Skips groups that a sphere bounds, such as distant instances, and paint where only distances are asked for.

use crate::FAR;
use crate::combine::Joint;
use crate::interpreter_state::{InterpreterState, words};
use crate::material_mix::mark_group;
use crate::scalar::{LANES, Real};
use argil_abi as abi;
use glam::DVec3;

/// Returns the end of a group that changes nothing: paint, if only distances are carried, or a bounded group that is too far to
/// change a union in any lane. It marks the group, if marks are carried.
#[inline(always)]
pub(crate) fn skip_group<R: Real>(
    r: &mut InterpreterState<R>,
    params: &[f32],
    instructions: &[abi::Instruction],
    begin: usize,
    [materials, marks]: [bool; 2],
) -> Option<usize> {
    if instructions[begin].flags & abi::FLAG_PAINT != 0 {
        let is_needed = materials || marks;
        return (!is_needed).then(|| end_of_group(instructions, begin))?;
    }
    let &[cx, cy, cz, radius, factor] = words(params, instructions[begin].params as usize);
    let origin = r.current_origin().unwrap_or(DVec3::ZERO);
    let [cx, cy, cz] = [(cx, origin.x), (cy, origin.y), (cz, origin.z)]
        .map(|(center, origin)| (f64::from(center) - origin) as f32);
    let [xs, ys, zs] = &r.point;
    let mut least = f32::INFINITY;
    for i in 0..r.active.min(LANES) {
        let x = R::get(xs, i).value() - cx;
        let y = R::get(ys, i).value() - cy;
        let z = R::get(zs, i).value() - cz;
        let away = (x * x + y * y + z * z).sqrt() - radius;
        // Within the sphere, nothing is known.
        let bound = if away >= 0.0 { away * factor } else { -FAR };
        let clear = bound - R::get(&r.acc, i).value();
        least = if clear < least { clear } else { least };
    }
    let margin = if marks { r.margin } else { 0.0 };
    if least <= margin {
        return None;
    }
    let end = end_of_group(instructions, begin)?;
    if marks {
        let saved = std::mem::replace(&mut r.acc, R::splat(FAR));
        for place in [begin, end] {
            mark_group::<R>(r, place, &saved, &Joint::HARD_UNION, abi::COMBINE_SMOOTH);
        }
        r.acc = saved;
    }
    Some(end)
}

/// Returns where the group ends that begins at an instruction.
pub(crate) fn end_of_group(instructions: &[abi::Instruction], begin: usize) -> Option<usize> {
    let mut open = 0;
    let following = instructions.get(begin..)?.iter();
    let end = following.take_while(|instr| {
        match instr.op {
            abi::OP_PUSH_VALUE => open += 1,
            abi::OP_COMBINE => open -= 1,
            _ => {}
        }
        open > 0
    });
    Some(begin + end.count()).filter(|&end| end < instructions.len())
}
