//! Selects the distance function of a shape: opcodes and the dispatch of both interpreters, from the table of
//! shapes.

use crate::combine::{combine_smooth, matters, union_smooth};
use crate::eval_brush::{BrushParams, brush, mapped, translated};
use crate::interpreter_state::{InterpreterState, words};
use crate::relative_points::OCTAVES_WORD;
use crate::scalar::{LANES, Real, SIMD_BLOCK, SimdBlock};
use crate::{Program, curves, sampled, shapes};
use argil_abi as abi;
use argil_scene::shape_table;
use std::fmt::Write;

/// Returns the loop iterations of a search on a GPU, given the shape's words.
type Loops = fn(&[f32]) -> u64;

macro_rules! dispatch {
    (
        plain {$(
            $(#[$doc:meta])*
            $shape:ident($function:ident) { $($parameters:tt)* }
            $(rule($rule:expr))?
            words($words:expr)
            bounds($bounds:expr)
            exact($exact:expr)
            example($example:expr);
        )*}
        searched {$(
            $(#[$searched_doc:meta])*
            $searched:ident($searched_function:ident, $loops:ident) { $($searched_parameters:tt)* }
            $(rule($searched_rule:expr))?
            words($searched_words:expr)
            bounds($searched_bounds:expr)
            exact($searched_exact:expr)
            example($searched_example:expr);
        )*}
    ) => {
        #[repr(u32)]
        enum Plain { $($shape),* }
        #[repr(u32)]
        enum Searched { $($searched),* }

        /// Opcodes of shapes, in the order of the table.
        #[allow(non_upper_case_globals, reason = "named as the shapes are")]
        pub(crate) mod op {
            use super::{Plain, Searched};
            use argil_abi as abi;
            $(pub(crate) const $shape: u32 = Plain::$shape as u32;)*
            $(pub(crate) const $searched: u32 = abi::OP_FIRST_ITERATIVE + Searched::$searched as u32;)*
        }

        /// The distance function of each opcode, with the same name in both languages.
        const FUNCTIONS: &[(u32, &str)] = &[
            $((op::$shape, stringify!($function)),)*
            $((op::$searched, stringify!($searched_function)),)*
        ];

        const SEARCHES: &[Loops] = &[$(curves::$loops),*];

        /// Combines one brush with the accumulator.
        #[inline(always)]
        pub(crate) fn measure<R: Real>(
            program: &Program,
            r: &mut InterpreterState<R>,
            op: u32,
            flags: u32,
            b: &BrushParams,
            at: usize,
        ) {
            let is_translation = flags & abi::FLAG_TRANSLATION != 0;
            match op {
                $(op::$shape => {
                    let w = words(&program.params, at);
                    let point = &r.point;
                    brush!(R, point, &mut r.acc, b, r.active, is_translation, w, shapes::$function);
                })*
                _ => curve_brush(r, program, op, b, at),
            }
        }

        /// Computes the distances of a block of points to a searched shape, in its frame.
        #[inline(always)]
        pub(crate) fn searched<R: Real>(op: u32, point: [&mut SimdBlock<R>; 3], words: &[f32]) -> SimdBlock<R> {
            use curves::*;
            use sampled::*;
            match op {
                $(op::$searched => $searched_function::<R>(point, words),)*
                _ => [R::constant(crate::FAR); SIMD_BLOCK],
            }
        }
    };
}

shape_table!(dispatch);

/// Combines a brush whose shape searches along curves, block by block. It skips blocks where the distance to the
/// shape's box leaves the accumulator unchanged.
#[inline(always)]
fn curve_brush<R: Real>(
    r: &mut InterpreterState<R>,
    program: &Program,
    op: u32,
    b: &BrushParams,
    at: usize,
) {
    let j = &b.joint;
    let m = b.m;
    let bounds: [f32; 6] = *words(&program.params, at);
    let [xs, ys, zs] = &r.point;
    for first in (0..r.active.min(LANES)).step_by(SIMD_BLOCK) {
        let zero = [R::constant(0.0); SIMD_BLOCK];
        let [mut x, mut y, mut z, mut a] = [zero; 4];
        let mut concerned = 0u32;
        for i in 0..SIMD_BLOCK {
            let lane = first + i;
            [x[i], y[i], z[i]] = mapped([R::get(xs, lane), R::get(ys, lane), R::get(zs, lane)], &m);
            a[i] = R::get(&r.acc, lane);
            let least =
                curves::box_distance(x[i].value(), y[i].value(), z[i].value(), &bounds) * b.scale;
            concerned |= u32::from(matters(a[i].value(), least, j));
        }
        if concerned == 0 {
            continue;
        }
        let point = [&mut x, &mut y, &mut z];
        let d = searched::<R>(op, point, &program.params[at + 6..]);
        for i in 0..SIMD_BLOCK {
            R::set(
                &mut r.acc,
                first + i,
                combine_smooth(a[i], d[i] * b.scale, j),
            );
        }
    }
}

const _: () = assert!(
    FUNCTIONS.len() - SEARCHES.len() <= abi::OP_FIRST_ITERATIVE as usize
        && SEARCHES.len() <= (abi::OP_SHAPES_END - abi::OP_FIRST_ITERATIVE) as usize,
    "each kind of shape has its range of opcodes"
);

/// Returns the loop iterations of one evaluation of a shape on a GPU.
pub(crate) fn loops(op: u32, words: &[f32]) -> u64 {
    let search = op.checked_sub(abi::OP_FIRST_ITERATIVE);
    let search = search.and_then(|index| SEARCHES.get(index as usize));
    search.map_or(1, |loops| loops(words))
}

/// Returns the name of a shape's WGSL function.
pub(crate) fn wgsl_function(op: u32) -> &'static str {
    let entry = FUNCTIONS.iter().find(|&&(known, _)| known == op);
    entry.map_or("", |&(_, name)| name)
}

/// The most common shapes. Compilers turn a `switch` into a chain of comparisons, so these are compared before it.
const COMMON: [u32; 5] = [op::Sphere, op::Box, op::Cylinder, op::Capsule, op::Torus];

/// The most shapes whose chain is short enough as it is.
const SHORT: usize = 8;

/// Returns WGSL that selects the function by opcode, among the `used` ones.
pub(crate) fn wgsl_dispatch(used: impl Fn(u32) -> bool) -> String {
    let mut text = "fn shape_distance(op: u32, p: vec3<f32>, w: u32) -> f32 {\n".to_owned();
    let length = FUNCTIONS.iter().filter(|(op, _)| used(*op)).count();
    let is_first = |op: &u32| length > SHORT && COMMON.contains(op);
    for op in COMMON.into_iter().filter(|op| used(*op) && is_first(op)) {
        let function = wgsl_function(op);
        // Writing to a string does not fail.
        let _ = writeln!(text, "    if op == {op}u {{ return {function}(p, w); }}");
    }
    text += "    switch op {\n";
    let is_other = |op: &u32| used(*op) && !is_first(op);
    for &(op, function) in FUNCTIONS.iter().filter(|(op, _)| is_other(op)) {
        let words = if op < abi::OP_FIRST_ITERATIVE {
            "w"
        } else {
            "w + 6u"
        };
        let _ = writeln!(
            text,
            "        case {op}u: {{ return {function}(p, {words}); }}"
        );
    }
    text + "        default: { return FAR; }\n    }\n}\n\n"
}

impl Program {
    /// Returns the maximum loop iterations of one evaluation on a GPU: one per instruction, plus those of copies,
    /// searches and octaves.
    pub fn max_iterations(&self) -> u64 {
        let mut total = 0u64;
        let mut copies = vec![1u64];
        for instr in &self.instructions {
            let times = copies.last().copied().unwrap_or(1);
            let iterations = if instr.op < abi::OP_SHAPES_END {
                let words = instr.params + abi::BRUSH_HEADER_WORDS + 6;
                loops(instr.op, self.params.get(words as usize..).unwrap_or(&[]))
            } else if instr.op == abi::OP_DISPLACE {
                let octaves = self.params.get(instr.params as usize + OCTAVES_WORD);
                1 + octaves.map_or(0, |&octaves| octaves as u64)
            } else {
                1
            };
            total = total.saturating_add(times.saturating_mul(iterations));
            if let Some(count) = self.copies_of(instr) {
                copies.push(times.saturating_mul(count));
            } else if instr.op == abi::OP_NEXT {
                copies.pop();
            }
        }
        total
    }
}
