//! The minima of a polynomial of degree four. The function of `quartic.wgsl` is a twin.
//!
//! *Theory.* The derivative is a cubic that rises at both ends. Cardano's substitution, t = inflection + u, gives
//! u³ − 3 s² u + q. If |q| < 2 s³, there are two minima, each between one and two times s from the inflection. Otherwise
//! there is one.
//!
//! *Practice.* Square roots and the exponent's third give estimates, and Newton's method ends in the original
//! coefficients. Every device uses the same operations, because cosines and cube roots of libraries differ.

use crate::scalar::{Real, SIMD_BLOCK, SimdBlock};

/// Newton steps after an estimate. The twin has them one after another, because loops are costly on software GPUs.
const NEWTON_STEPS: usize = 3;

/// Half of the derivatives of polynomials of degree four, one for each point. The two higher coefficients depend on the
/// curve alone.
pub(crate) struct Cubics {
    pub constant: SimdBlock<f32>,
    pub linear: SimdBlock<f32>,
    pub quadratic: f32,
    pub cubic: f32,
}

/// Returns the parameters of the minima of each polynomial, twice the same if there is one. For a curve that is nearly
/// straight, the search starts at 0 and at 1, and finds those next to them.
#[inline(always)]
pub(crate) fn minima(c: &Cubics, is_straight: bool) -> [SimdBlock<f32>; 2] {
    let (c2, c3) = (c.quadratic, c.cubic);
    let mut first = [0.0; SIMD_BLOCK];
    let mut second = [1.0; SIMD_BLOCK];
    if !is_straight {
        let reciprocal = 1.0 / c3;
        let inflection = c2 * reciprocal * (-1.0 / 3.0);
        for i in 0..SIMD_BLOCK {
            // u³ − 3 s² u + q
            let s2 = inflection * inflection - c.linear[i] * reciprocal * (1.0 / 3.0);
            let q = ((c3 * inflection + c2) * inflection + c.linear[i]) * inflection;
            let q = (q + c.constant[i]) * reciprocal;
            let s = f32::sqrt(s2.positive_part());
            let k = q / (s * s * s);
            let has_two = s2 > 0.0 && q * q < 4.0 * s2 * s2 * s2;
            let below = s + s * f32::sqrt((2.0 + k).positive_part() * (1.0 / 3.5));
            let above = s + s * f32::sqrt((2.0 - k).positive_part() * (1.0 / 3.5));
            // A cube root within 5 %, by a third of the exponent.
            let length = Real::abs(q);
            let root = f32::from_bits(length.to_bits() / 3 + 0x2a51_4067);
            let far = root + s2 / root;
            let near = Real::min(root, length / Real::max(-3.0 * s2, 1e-30));
            let one = if s2 > 0.0 { far } else { near };
            let single = inflection - one.signed_as(q);
            first[i] = if has_two { inflection - below } else { single };
            second[i] = if has_two { inflection + above } else { single };
        }
    }
    for _ in 0..NEWTON_STEPS {
        for t in [&mut first, &mut second] {
            for (t, (&c0, &c1)) in t.iter_mut().zip(c.constant.iter().zip(&c.linear)) {
                let value = ((c3 * *t + c2) * *t + c1) * *t + c0;
                let slope = (3.0 * c3 * *t + 2.0 * c2) * *t + c1;
                let next = *t - value / slope;
                *t = if slope > 0.0 { next } else { *t };
            }
        }
    }
    [first, second]
}
