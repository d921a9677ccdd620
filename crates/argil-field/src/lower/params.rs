//! Parameters of instructions.

use crate::places::ENDLESS;
use argil_abi::{self as abi};
use argil_scene::{BlendProfile, Modifier, NodeDesc, NodeKind, OperatorKind};
use glam::{DAffine3, DVec3};

/// Lets the next instruction's parameters begin at a multiple of [`abi::PARAMS_ALIGNMENT`].
pub(super) fn align(params: &mut Vec<f32>) {
    let end = params
        .len()
        .next_multiple_of(abi::PARAMS_ALIGNMENT as usize);
    params.resize(end, 0.0);
}

/// Whether a node is one instruction: a shape that is only transformed, with a smooth or hard joint.
pub(super) fn is_single(entry: &NodeDesc) -> bool {
    let smooth = entry.operator.profile == BlendProfile::Smooth || entry.operator.blend == 0.0;
    matches!(entry.kind, NodeKind::Shape(_))
        && smooth
        && !matches!(
            entry.operator.kind,
            OperatorKind::Paint | OperatorKind::Morph
        )
        && entry.modifiers.iter().all(|m| m.affine().is_some())
}

/// Whether a modifier needs a loop, which keeps the nearest copy so far on the stack.
pub(super) fn is_loop(modifier: &Modifier) -> bool {
    match *modifier {
        Modifier::Repeat { spacing, count } => (0..3).any(|axis| has_copies(spacing, count, axis)),
        Modifier::RadialRepeat { .. } | Modifier::Wrap { .. } => true,
        _ => false,
    }
}

fn has_copies(spacing: [f32; 3], count: Option<[u32; 3]>, axis: usize) -> bool {
    count.map_or(spacing[axis] > 0.0, |c| c[axis] > 1)
}

/// Returns the flag by which a cut without a material of its own keeps the material.
pub(super) fn keep(entry: &NodeDesc) -> u32 {
    let cuts = matches!(
        entry.operator.kind,
        OperatorKind::Subtract | OperatorKind::Intersect
    );
    if cuts && entry.material.is_none() {
        abi::FLAG_KEEP_MATERIAL
    } else {
        0
    }
}

/// Returns the product of a node's own scales, because its joint is in the unit of the surrounding group.
pub(super) fn scale_of(entry: &NodeDesc) -> f64 {
    entry
        .modifiers
        .iter()
        .map(|m| f64::from(m.scale()))
        .product()
}

pub(super) fn affine_words(m: &DAffine3) -> [f32; 12] {
    let (x, y, z, t) = (
        m.matrix3.x_axis,
        m.matrix3.y_axis,
        m.matrix3.z_axis,
        m.translation,
    );
    let row = |pick: fn(DVec3) -> f64| {
        [
            pick(x) as f32,
            pick(y) as f32,
            pick(z) as f32,
            pick(t) as f32,
        ]
    };
    let rows = [row(|v| v.x), row(|v| v.y), row(|v| v.z)];
    std::array::from_fn(|i| rows[i / 4][i % 4])
}

/// Returns the words of a repetition, and the number of copies per point.
pub(super) fn repeat_words(
    spacing: [f32; 3],
    count: Option<[u32; 3]>,
    looked_at: [u32; 3],
) -> ([f32; 15], u64) {
    let mut words = [0.0; 15];
    let mut copies = 1u64;
    for axis in 0..3 {
        let many = has_copies(spacing, count, axis);
        let (offset, low, high) = match count {
            _ if !many => (0.0, 0.0, 0.0),
            Some(c) => (
                0.5 * (c[axis] - 1) as f32 * spacing[axis],
                0.0,
                (c[axis] - 1) as f32,
            ),
            None => (0.0, -ENDLESS, ENDLESS),
        };
        let candidates = u64::from(looked_at[axis]);
        let step = if many { spacing[axis] } else { 1.0 };
        for (slot, value) in [step, offset, low, high, candidates as f32]
            .into_iter()
            .enumerate()
        {
            words[3 * slot + axis] = value;
        }
        copies = copies.saturating_mul(candidates);
    }
    (words, copies)
}
