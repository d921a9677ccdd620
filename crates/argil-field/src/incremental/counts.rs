//! What is counted of the visible operands, so that the greatest is known when one goes.

use super::piece::Operand;
use argil_scene::{OperatorKind, max_blend_propagation};
use std::collections::BTreeMap;

/// See the module's page. Lengths are counted by their bits.
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
    let own = counts.entry(bits).or_default();
    if is_there {
        *own += 1;
    } else {
        *own -= 1;
        if *own == 0 {
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
    /// Count an operand that is so many open groups deep, or count it no more.
    pub(super) fn count(&mut self, operand: &Operand, depth: usize, is_there: bool) {
        if !operand.visible {
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

    /// Count a joint's blend radius, or count it no more.
    pub(super) fn count_blend(&mut self, blend: f32, depth: usize, is_there: bool) {
        let counts = if depth == 0 {
            &mut self.blends
        } else {
            &mut self.inner_blends
        };
        count(counts, blend, is_there);
    }

    /// The greatest magnitude.
    pub(super) fn magnitude(&self) -> f32 {
        maximum(&self.magnitudes)
    }

    /// By how much joints swell what they join, at most.
    pub(super) fn max_outward_offset(&self) -> f32 {
        let inner = maximum(&self.inner_blends);
        // Groups that are open are no deeper.
        maximum(&self.blends) + if inner > 0.0 { 4.0 * inner } else { 0.0 }
    }

    /// How far values can fall through the joints of the root, and of each open group, before anything of a change is lost in
    /// rounding; `far` is the length up to which distances count.
    pub(super) fn blend_propagation(&self, far: f32) -> [f32; 2] {
        let root = maximum(&self.blends);
        [
            max_blend_propagation(root, self.chamfers > 0, far),
            max_blend_propagation(maximum(&self.inner_blends), false, 0.0),
        ]
    }
}
