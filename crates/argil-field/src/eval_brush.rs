//! Evaluates one brush for a batch of points: place the points, measure, combine. These are the interpreter's hot
//! loops.

use crate::combine::Joint;
use crate::interpreter_state::words;
use crate::scalar::Real;
use argil_abi as abi;

pub(crate) const HEADER: usize = abi::BRUSH_HEADER_WORDS as usize;

/// A brush's map from the point, and its joint.
#[derive(Clone)]
pub(crate) struct BrushParams {
    pub m: [f32; 12],
    pub scale: f32,
    pub joint: Joint,
}

impl BrushParams {
    #[inline(always)]
    pub(crate) fn read(params: &[f32], at: usize) -> Self {
        let h: &[f32; HEADER] = words(params, at);
        Self {
            m: *words(h, 0),
            scale: h[12],
            joint: Joint {
                k: h[13],
                inv_4k: h[14],
                sa: h[15],
                sb: h[16],
                sr: h[17],
                amount: 0.0,
            },
        }
    }
}

#[inline(always)]
pub(crate) fn translated<R: Real>(p: [R; 3], m: &[f32; 12]) -> [R; 3] {
    [p[0] + m[3], p[1] + m[7], p[2] + m[11]]
}

#[inline(always)]
pub(crate) fn mapped<R: Real>([x, y, z]: [R; 3], m: &[f32; 12]) -> [R; 3] {
    [
        x * m[0] + y * m[1] + z * m[2] + m[3],
        x * m[4] + y * m[5] + z * m[6] + m[7],
        x * m[8] + y * m[9] + z * m[10] + m[11],
    ]
}

/// The hot loop: place the points, measure, combine. A translated union, the common case, needs no scale and no
/// signs. It is a macro, because the compiler does not inline all functions that are arguments.
macro_rules! brush {
    ($numbers:ty, $point:expr, $acc:expr, $params:expr, $active:expr, $is_translation:expr, $words:expr, $shape:path) => {{
        let [xs, ys, zs] = $point;
        let (acc, b) = ($acc, $params);
        // Copies, so that the optimizer need not prove that the words and the lanes do not overlap.
        let (m, w) = (b.m, *$words);
        let blocks = ($active / SIMD_BLOCK).min(LANES / SIMD_BLOCK);
        let is_union = b.joint.sa > 0.0 && b.joint.sb > 0.0;
        match ($is_translation, is_union) {
            (true, true) => brush!(@points $numbers, [xs, ys, zs], acc, blocks, |p, before| {
                union_smooth(before, $shape(translated(p, &m), &w), &b.joint)
            }),
            (true, false) => brush!(@points $numbers, [xs, ys, zs], acc, blocks, |p, before| {
                combine_smooth(before, $shape(translated(p, &m), &w), &b.joint)
            }),
            (false, _) => brush!(@points $numbers, [xs, ys, zs], acc, blocks, |p, before| {
                combine_smooth(before, $shape(mapped(p, &m), &w) * b.scale, &b.joint)
            }),
        }
    }};
    (@points $numbers:ty, [$x:ident, $y:ident, $z:ident], $acc:ident, $blocks:ident, |$p:ident, $before:ident| $after:block) => {
        for block in 0..$blocks {
            for i in block * SIMD_BLOCK..(block + 1) * SIMD_BLOCK {
                let $p = [
                    <$numbers>::get($x, i),
                    <$numbers>::get($y, i),
                    <$numbers>::get($z, i),
                ];
                let $before = <$numbers>::get($acc, i);
                <$numbers>::set($acc, i, $after);
            }
        }
    };
}
pub(crate) use brush;
