//! Facts about a large group's operands, so that an edit among 100,000 brushes need not visit each.

use crate::{BlendProfile, NodeDesc, OperatorKind};
use std::collections::BTreeMap;

/// Groups with more operands than this have a summary.
pub(crate) const SUMMARY_THRESHOLD: usize = 256;

/// A summary of a group's visible operands.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GroupSummary {
    /// The number of operands with each blend radius. Keys are the radius's bits, which sort like the radius.
    blends: BTreeMap<u32, u32>,
    chamfers: u32,
    morphs: u32,
}

impl GroupSummary {
    /// Adds an operand.
    pub(crate) fn add(&mut self, entry: &NodeDesc) {
        let Some([blend, chamfer, morph]) = parts(entry) else {
            return;
        };
        *self.blends.entry(blend).or_default() += 1;
        self.chamfers += chamfer;
        self.morphs += morph;
    }

    /// Removes an operand.
    pub(crate) fn remove(&mut self, entry: &NodeDesc) {
        let Some([blend, chamfer, morph]) = parts(entry) else {
            return;
        };
        if let Some(count) = self.blends.get_mut(&blend) {
            *count -= 1;
            if *count == 0 {
                self.blends.remove(&blend);
            }
        }
        self.chamfers -= chamfer;
        self.morphs -= morph;
    }

    /// Returns the largest blend radius.
    pub(crate) fn max_blend(&self) -> f32 {
        let greatest = self.blends.last_key_value();
        greatest.map_or(0.0, |(&bits, _)| f32::from_bits(bits))
    }

    pub(crate) fn has_chamfers(&self) -> bool {
        self.chamfers > 0
    }

    pub(crate) fn has_morphs(&self) -> bool {
        self.morphs > 0
    }
}

/// Returns the bits of the blend radius, 1 for a chamfer, and 1 for a morph. Returns `None` for hidden operands.
fn parts(entry: &NodeDesc) -> Option<[u32; 3]> {
    let operator = &entry.operator;
    let is_chamfer = operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
    let is_morph = operator.kind == OperatorKind::Morph;
    // Checks exclude negative radii, but −0 would sort as the largest.
    let blend = operator.blend.max(0.0).to_bits() & 0x7fff_ffff;
    entry
        .visible
        .then_some([blend, u32::from(is_chamfer), u32::from(is_morph)])
}
