//! Statistics of the operands that take part. They give the maximum after an operand is removed.

use super::piece::Operand;
use argil_scene::{OperatorKind, max_blend_propagation};
use std::collections::BTreeMap;

/// Counts of lengths by their bits.
#[derive(Debug, Default)]
pub(super) struct PieceCounts {
    magnitudes: BTreeMap<u32, u32>,
    /// Blend radii at the root.
    blends: BTreeMap<u32, u32>,
    /// Blend radii in open groups.
    inner_blends: BTreeMap<u32, u32>,
    chamfers: u32,
    pub morphs: u32,
}

fn count(counts: &mut BTreeMap<u32, u32>, value: f32, is_there: bool) {
    let bits = value.max(0.0).to_bits() & 0x7fff_ffff;
    let entry = counts.entry(bits).or_default();
    if is_there {
        *entry += 1;
    } else {
        *entry -= 1;
        if *entry == 0 {
            counts.remove(&bits);
        }
    }
}

fn maximum(counts: &BTreeMap<u32, u32>) -> f32 {
    counts
        .last_key_value()
        .map_or(0.0, |(&bits, _)| f32::from_bits(bits))
}

impl PieceCounts {
    /// Adds an operand in a number of open groups, or removes it.
    pub(super) fn count(&mut self, operand: &Operand, depth: usize, is_there: bool) {
        if !operand.takes_part {
            return;
        }
        count(&mut self.magnitudes, operand.magnitude, is_there);
        self.count_blend(operand.operator.blend, depth, is_there);
        let by = |counter: &mut u32| {
            if is_there {
                *counter += 1;
            } else {
                *counter -= 1;
            }
        };
        if operand.is_chamfered() {
            by(&mut self.chamfers);
        }
        if operand.operator.kind == OperatorKind::Morph {
            by(&mut self.morphs);
        }
    }

    /// Adds a joint's blend radius, or removes it.
    pub(super) fn count_blend(&mut self, blend: f32, depth: usize, is_there: bool) {
        let counts = if depth == 0 {
            &mut self.blends
        } else {
            &mut self.inner_blends
        };
        count(counts, blend, is_there);
    }

    /// Returns the largest magnitude.
    pub(super) fn magnitude(&self) -> f32 {
        maximum(&self.magnitudes)
    }

    /// Returns the maximum by which joints extend what they join.
    pub(super) fn max_outward_offset(&self) -> f32 {
        let inner = maximum(&self.inner_blends);
        // Open groups are no deeper.
        maximum(&self.blends) + if inner > 0.0 { 4.0 * inner } else { 0.0 }
    }

    /// Returns how far values can fall through the joints of the root, and of each open group, before rounding
    /// hides a change. `far` is the distance up to which values count.
    pub(super) fn blend_propagation(&self, far: f32) -> [f32; 2] {
        let [root, inner] = self.largest_blends();
        [
            max_blend_propagation(root, self.has_chamfers(), far),
            max_blend_propagation(inner, false, 0.0),
        ]
    }

    /// Returns the largest blend radii, at the root and in open groups.
    pub(super) fn largest_blends(&self) -> [f32; 2] {
        [maximum(&self.blends), maximum(&self.inner_blends)]
    }

    pub(super) fn has_chamfers(&self) -> bool {
        self.chamfers > 0
    }
}
