//! The minima of a polynomial of degree four. The function of `quartic.wgsl` is a twin.
//!
//! *Theory.* The derivative is a cubic that rises at both ends. Cardano's substitution, t = inflection + u, gives
//! u³ − 3 s² u + q. If |q| < 2 s³, there are two minima, each between one and two times s from the inflection. Otherwise
//! there is one.
//!
//! *Practice.* Square roots and the exponent's third give estimates, and Newton's method ends in the original
//! coefficients. Every device uses the same operations, because cosines and cube roots of libraries differ.

use crate::scalar::Real;

/// Newton steps after an estimate. The twin has them one after another, because loops are costly on software GPUs.
const NEWTON_STEPS: usize = 4;

/// Half of the derivative of a polynomial of degree four, from the constant coefficient on.
pub(crate) type Cubic = [f32; 4];

/// Returns the parameters of the minima, twice the same if there is one. For a curve that is nearly straight, the
/// search starts at 0 and at 1, and finds those next to them.
#[inline(always)]
pub(crate) fn minima(c: Cubic, is_straight: bool) -> [f32; 2] {
    let [c0, c1, c2, c3] = c;
    let reciprocal = 1.0 / c3;
    let inflection = c2 * reciprocal * (-1.0 / 3.0);
    // u³ − 3 s² u + q
    let s2 = inflection * inflection - c1 * reciprocal * (1.0 / 3.0);
    let q = (((c3 * inflection + c2) * inflection + c1) * inflection + c0) * reciprocal;
    let s = f32::sqrt(s2.positive_part());
    let k = q / (s * s * s);
    let has_two = s2 > 0.0 && q * q < 4.0 * s2 * s2 * s2;
    let beyond = |k: f32| s + s * f32::sqrt((2.0 + k).positive_part() * (1.0 / 3.5));
    // A cube root within 5 %, by a third of the exponent.
    let root = f32::from_bits(Real::abs(q).to_bits() / 3 + 0x2a51_4067);
    let one = if s2 > 0.0 {
        root + s2 / root
    } else {
        Real::min(root, Real::abs(q) / Real::max(-3.0 * s2, 1e-30))
    };
    let single = inflection - one.signed_as(q);
    let pick = |end: f32, of_two: f32| {
        let curved = if has_two { of_two } else { single };
        if is_straight { end } else { curved }
    };
    let mut t = [
        pick(0.0, inflection - beyond(k)),
        pick(1.0, inflection + beyond(-k)),
    ];
    for _ in 0..NEWTON_STEPS {
        for t in &mut t {
            let value = ((c3 * *t + c2) * *t + c1) * *t + c0;
            let slope = (3.0 * c3 * *t + 2.0 * c2) * *t + c1;
            let next = *t - value / slope;
            *t = if slope > 0.0 { next } else { *t };
        }
    }
    t
}
