//! Operators. `combine.wgsl` is the twin.

use crate::scalar::Real;

/// The words of an operator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// Blend radius.
    pub k: f32,
    /// 1 / (4 k), or 0 for a hard joint.
    pub inv_4k: f32,
    /// Signs: union +++, subtract −+−, intersect −−−.
    pub sa: f32,
    pub sb: f32,
    pub sr: f32,
    /// How far a morph goes.
    pub amount: f32,
}

impl Joint {
    /// The smaller of two distances.
    pub(crate) const HARD_UNION: Self = Self {
        k: 0.0,
        inv_4k: 0.0,
        sa: 1.0,
        sb: 1.0,
        sr: 1.0,
        amount: 0.0,
    };

    /// Whether it returns the smaller of two distances.
    pub(crate) fn is_hard_union(&self) -> bool {
        self.k == 0.0 && [self.sa, self.sb, self.sr] == [1.0; 3]
    }
}

/// Returns `sr · smin(sa · a, sb · b)` with the quadratic kernel.
#[inline(always)]
pub(crate) fn combine_smooth<R: Real>(a: R, b: R, j: &Joint) -> R {
    let (a, b) = (a * j.sa, b * j.sb);
    let h = (-(a - b).abs() + j.k).positive_part();
    (a.min(b) - h * h * j.inv_4k) * j.sr
}

/// Returns [`combine_smooth`] where every sign is +1, with the same bits.
#[inline(always)]
pub(crate) fn union_smooth<R: Real>(a: R, b: R, j: &Joint) -> R {
    let h = (-(a - b).abs() + j.k).positive_part();
    a.min(b) - h * h * j.inv_4k
}

/// Whether an operand whose box is `least` away can change the accumulated `a`. A union farther than a + k cannot,
/// and neither can a cut farther than k − a. Inside the box, anything is possible.
#[inline(always)]
pub(crate) fn matters(a: f32, least: f32, j: &Joint) -> bool {
    // sb is −1 for an intersection, which a far operand changes most.
    j.sb < 0.0 || least <= 0.0 || least < a * j.sa + j.k
}

/// Returns the combination with a flat face across the joint.
#[inline(always)]
pub(crate) fn combine_chamfer<R: Real>(a: R, b: R, j: &Joint) -> R {
    let (a, b) = (a * j.sa, b * j.sb);
    let face = (a + b - j.k) * std::f32::consts::FRAC_1_SQRT_2;
    let hard = a.min(b);
    (if j.k > 0.0 { hard.min(face) } else { hard }) * j.sr
}

#[inline(always)]
pub(crate) fn combine_morph<R: Real>(a: R, b: R, j: &Joint) -> R {
    a + (b - a) * j.amount
}

/// Returns the weight of b's material: the weight of b's distance in the quadratic kernel.
#[inline(always)]
pub(crate) fn weight_smooth(a: f32, b: f32, j: &Joint) -> f32 {
    let (a, b) = (a * j.sa, b * j.sb);
    let h = Real::positive_part(j.k - (a - b).abs()) * (2.0 * j.inv_4k);
    if b < a { 1.0 - h } else { h }
}

/// Returns the weight of paint: 1 inside, 0 outside, and linear over the blend radius around the surface.
#[inline(always)]
pub(crate) fn weight_paint(b: f32, j: &Joint) -> f32 {
    let soft = Real::clamp_to(0.5 - b * (4.0 * j.inv_4k), 0.0, 1.0);
    let hard = if b < 0.0 { 1.0 } else { 0.0 };
    if j.k > 0.0 { soft } else { hard }
}
