//! What the interpreter carries besides distances: materials, and the classification of operands.

use crate::FAR;
use crate::combine::{Joint, combine_smooth, weight_paint, weight_smooth};
use crate::interpreter_state::{InterpreterState, lanes_of};
use crate::marks::{CELLS_PER_BATCH, Marks, dominated};
use crate::scalar::{F32Lanes, LANES, Real, SIMD_BLOCK};
use argil_abi as abi;
use argil_math::bits_of;

/// Mixes another material into the current one, given its weights, in the lanes and properties in use.
#[inline(always)]
pub(crate) fn mix_materials<R: Real>(
    r: &mut InterpreterState<R>,
    other: impl Fn(usize, usize) -> f32,
    weights: &F32Lanes,
) {
    for (k, lanes) in r.material.iter_mut().enumerate().take(r.properties) {
        for i in lanes_of(r.active) {
            lanes.0[i] += (other(k, i) - lanes.0[i]) * weights.0[i];
        }
    }
}

/// Mixes the material that was saved last with the current one, which is the second if `is_second`.
#[inline(always)]
pub(crate) fn mix_saved<R: Real>(r: &mut InterpreterState<R>, is_second: bool, weights: &F32Lanes) {
    let Some(begin) = r.materials.len().checked_sub(r.properties) else {
        return;
    };
    for (lanes, saved) in r.material.iter_mut().zip(&r.materials[begin..]) {
        for i in lanes_of(r.active) {
            let (value, saved) = (&mut lanes.0[i], saved.0[i]);
            *value = if is_second {
                saved + (*value - saved) * weights.0[i]
            } else {
                *value + (saved - *value) * weights.0[i]
            };
        }
    }
    r.materials.truncate(begin);
}

#[inline(always)]
pub(crate) fn weights<R: Real>(
    a: &R::Lanes,
    b: &R::Lanes,
    j: &Joint,
    flags: u32,
    share: &R::Lanes,
    active: usize,
) -> F32Lanes {
    let mut out = f32::splat(0.0);
    if flags & abi::FLAG_KEEP_MATERIAL != 0 {
        return out;
    }
    for i in 0..active.min(LANES) {
        let (a, b) = (R::get(a, i).value(), R::get(b, i).value());
        out.0[i] = match flags & abi::COMBINE_MASK {
            abi::COMBINE_PAINT => weight_paint(b, j),
            abi::COMBINE_MORPH => j.amount,
            // A curve may swing beyond both ends.
            abi::COMBINE_RAMPED => Real::clamp_to(R::get(share, i).value(), 0.0, 1.0),
            _ => weight_smooth(a, b, j),
        };
    }
    out
}

/// Saves the accumulator of the lanes in use, and starts a new one.
#[inline(always)]
pub(crate) fn put_aside<R: Real>(r: &mut InterpreterState<R>) {
    for first in (0..r.active.min(LANES)).step_by(SIMD_BLOCK) {
        for i in first..first + SIMD_BLOCK {
            R::set(&mut r.aside, i, R::get(&r.acc, i));
            R::set(&mut r.acc, i, R::constant(FAR));
        }
    }
}

/// Combines a brush in the accumulator with the saved value.
#[inline(always)]
pub(crate) fn join_aside<R: Real>(r: &mut InterpreterState<R>, joint: &Joint) {
    for first in (0..r.active.min(LANES)).step_by(SIMD_BLOCK) {
        for i in first..first + SIMD_BLOCK {
            let d = combine_smooth(R::get(&r.aside, i), R::get(&r.acc, i), joint);
            R::set(&mut r.acc, i, d);
        }
    }
}

/// Records which operand of the joint at `pc` clearly cannot matter: the saved value, or the brush in the
/// accumulator.
#[inline(always)]
pub(crate) fn mark_brush<R: Real>(r: &mut InterpreterState<R>, pc: usize, j: &Joint, flags: u32) {
    // A loop has a distance per copy, so it stays whole.
    if r.loops.is_empty() {
        let marks = marks_of::<R>(&r.aside, &r.acc, j, flags, false, (r.active, r.margin));
        if let Some(place) = r.marks.get_mut(pc) {
            *place = marks;
        }
    }
}

/// Records the same for a group: `a`, or the accumulator.
#[inline(always)]
pub(crate) fn mark_group<R: Real>(
    r: &mut InterpreterState<R>,
    pc: usize,
    a: &R::Lanes,
    j: &Joint,
    flags: u32,
) {
    if r.loops.is_empty() {
        let marks = marks_of::<R>(a, &r.acc, j, flags, true, (r.active, r.margin));
        if let Some(place) = r.marks.get_mut(pc) {
            *place = marks;
        }
    }
}

#[inline(always)]
fn marks_of<R: Real>(
    a: &R::Lanes,
    b: &R::Lanes,
    j: &Joint,
    flags: u32,
    is_group: bool,
    (active, margin): (usize, f32),
) -> Marks {
    let (mut drop_a, mut drop_b) = ([0; CELLS_PER_BATCH], [0; CELLS_PER_BATCH]);
    let mut mark = |i: usize| {
        let (a, b) = (R::get(a, i).value(), R::get(b, i).value());
        let (is_a, is_b) = dominated(a, b, j, flags, is_group, margin);
        (drop_a[i], drop_b[i]) = (u8::from(is_a), u8::from(is_b));
    };
    // Two constant lengths, so that both vectorize.
    if active <= SIMD_BLOCK {
        (0..SIMD_BLOCK).for_each(&mut mark);
    } else {
        (0..CELLS_PER_BATCH).for_each(&mut mark);
    }
    Marks {
        drop_a: bits_of(&drop_a),
        drop_b: bits_of(&drop_b),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Evaluator, Program};
    use argil_abi::GpuMaterial;
    use argil_scene::Scene;

    /// Red, green and blue solids in groups, in loops, and blended. `glass` makes materials longer.
    fn colors(glass: &str, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let sphere = |color: &str, x: f32, more: &str| {
            format!(
                r#"{{"shape": {{"type": "sphere", "radius": 0.4}}, "material": "{color}" {more},
                "modifiers": [{{"type": "translate", "by": [{x}, 0, 0]}}]}}"#
            )
        };
        let group = |items: &[String], more: &str| {
            format!(r#"{{"brushes": [{}] {more}}}"#, items.join(","))
        };
        let smooth = r#", "blend": 0.4"#;
        let apart =
            r#", "modifiers": [{"type": "repeat", "spacing": [0, 0, 3], "count": [1, 1, 3]}]"#;
        let inner = group(&[sphere("green", 1.0, ""), sphere("blue", 2.0, "")], "");
        let blended = group(
            &[sphere("red", 4.7, ""), sphere("blue", 5.3, smooth)],
            smooth,
        );
        let all = group(&[sphere("red", 0.0, ""), inner, blended], apart);
        // A group before another, which it cuts.
        let cut =
            r#", "operator": "subtract", "modifiers": [{"type": "translate", "by": [0, 0.4, 0]}]"#;
        let cutter = group(&[sphere("green", 2.0, ""), sphere("red", 9.0, "")], cut);
        let text = format!(
            r#"{{"argil": 1, "materials": {{"red": {{"base_color": [1, 0, 0] {glass}}}, "green": {{"base_color": [0, 1, 0]}},
            "blue": {{"base_color": [0, 0, 1]}}}}, "brushes": [{all}, {cutter}]}}"#
        );
        let scene = Scene::from_json(&text, "test").unwrap_or_else(|error| panic!("{error}"));
        let program = Program::lower(&scene).expect("a program");
        let mut evaluator = Evaluator::new(&program);
        let of = |p: &[f32; 3]| {
            let (mut d, mut found) = ([0.0], [GpuMaterial::default()]);
            evaluator.materials(&[p[0]], &[p[1]], &[p[2]], &mut d, &mut found);
            let [r, g, b, _] = found[0].base_roughness;
            [r, g, b]
        };
        points.iter().map(of).collect()
    }

    #[test]
    fn materials_are_those_of_the_solids() {
        let (red, green, blue) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let cases = [
            ([0.0, -0.4, 0.0], red),
            ([1.0, -0.4, 0.0], green),
            ([2.0, -0.4, 0.0], blue),
            // In the hollow of the cut, whose group has no material of its own.
            ([2.0, 0.001, 0.0], blue),
            // Other copies.
            ([1.0, 0.4, 3.0], green),
            ([2.0, 0.4, -3.0], blue),
            // Blended: at both ends, and in the middle.
            ([4.3, 0.0, 0.0], red),
            ([5.7, 0.0, 3.0], blue),
            ([5.0, 0.3, 0.0], [0.5, 0.0, 0.5]),
        ];
        let points = cases.map(|(point, _)| point);
        for glass in ["", r#", "transmission": 1"#] {
            for ((point, expected), found) in cases.iter().zip(colors(glass, &points)) {
                let apart = (0..3).map(|k| (found[k] - expected[k]).abs());
                let apart = apart.fold(0.0, f32::max);
                assert!(apart < 0.02, "{point:?}: {found:?}, expected {expected:?}");
            }
        }
    }
}
