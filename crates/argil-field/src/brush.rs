//! One brush against a batch of points: place the points, measure, combine. The interpreter's hot loops.

use crate::combine::{Joint, combine_smooth, matters, union_smooth};
use crate::curves::BLOCK;
use crate::real::{LANES, Real};
use crate::registers::{Registers, words};
use crate::{Program, curves, dispatch};
use argil_abi as abi;

pub(crate) const HEADER: usize = abi::BRUSH_HEADER_WORDS as usize;

/// A brush's map from the point and its joint.
pub(crate) struct Brush<'a> {
    pub m: &'a [f32; 12],
    pub scale: f32,
    pub joint: Joint,
}

impl<'a> Brush<'a> {
    #[inline(always)]
    pub fn read(params: &'a [f32], at: usize) -> Self {
        let h: &[f32; HEADER] = words(params, at);
        Self {
            m: words(h, 0),
            scale: h[12],
            joint: Joint {
                k: h[13],
                quarter: h[14],
                sa: h[15],
                sb: h[16],
                sr: h[17],
                amount: 0.0,
            },
        }
    }
}

#[inline(always)]
fn translated<R: Real>(p: [R; 3], m: &[f32; 12]) -> [R; 3] {
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

/// The hot loop: place the points, measure, combine. The common case, a translated union, is spared the multiplications
/// by a scale and signs of 1.
#[inline(always)]
pub(crate) fn brush<R: Real, const N: usize>(
    point: &[R::Lanes; 3],
    acc: &mut R::Lanes,
    b: &Brush<'_>,
    active: usize,
    is_translation: bool,
    w: &[f32; N],
    shape: impl Fn([R; 3], &[f32; N]) -> R,
) {
    let [xs, ys, zs] = point;
    // Copies: the optimiser then need not prove that the words lie apart from the lanes.
    let (m, w) = (*b.m, *w);
    let blocks = (active / BLOCK).min(LANES / BLOCK);
    let is_union = b.joint.sa > 0.0 && b.joint.sb > 0.0;
    match (is_translation, is_union) {
        (true, true) => {
            for block in 0..blocks {
                for i in block * BLOCK..(block + 1) * BLOCK {
                    let d = shape(
                        translated([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                        &w,
                    );
                    R::set(acc, i, union_smooth(R::get(acc, i), d, &b.joint));
                }
            }
        }
        (true, false) => {
            for block in 0..blocks {
                for i in block * BLOCK..(block + 1) * BLOCK {
                    let d = shape(
                        translated([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                        &w,
                    );
                    R::set(acc, i, combine_smooth(R::get(acc, i), d, &b.joint));
                }
            }
        }
        (false, _) => {
            for block in 0..blocks {
                for i in block * BLOCK..(block + 1) * BLOCK {
                    let d = shape(
                        mapped([R::get(xs, i), R::get(ys, i), R::get(zs, i)], &m),
                        &w,
                    ) * b.scale;
                    R::set(acc, i, combine_smooth(R::get(acc, i), d, &b.joint));
                }
            }
        }
    }
}

/// A brush whose shape searches along curves, block by block, where it can matter: not where the distance to the
/// shape's box already leaves the accumulator as it is.
#[inline(always)]
fn curve_brush<R: Real>(
    r: &mut Registers<R>,
    program: &Program,
    op: u32,
    b: &Brush<'_>,
    at: usize,
) {
    let j = &b.joint;
    let m = *b.m;
    let bounds: [f32; 6] = *words(&program.params, at);
    let [xs, ys, zs] = &r.point;
    for first in (0..r.active.min(LANES)).step_by(BLOCK) {
        let zero = [R::constant(0.0); BLOCK];
        let [mut x, mut y, mut z, mut a] = [zero; 4];
        let mut concerned = 0u32;
        for i in 0..BLOCK {
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
        let d = dispatch::searched::<R>(op, point, &program.params[at + 6..]);
        for i in 0..BLOCK {
            R::set(
                &mut r.acc,
                first + i,
                combine_smooth(a[i], d[i] * b.scale, j),
            );
        }
    }
}

/// Combine one brush with the accumulator.
#[inline(always)]
pub(crate) fn measure<R: Real>(
    program: &Program,
    r: &mut Registers<R>,
    op: u32,
    flags: u32,
    b: &Brush<'_>,
    at: usize,
) {
    if op >= abi::OP_SEARCHED {
        return curve_brush(r, program, op, b, at);
    }
    let is_translation = flags & abi::FLAG_TRANSLATION != 0;
    dispatch::plain(program, r, op, is_translation, b, at);
}
