//! What is known of a large group's operands without looking at each: an edit among 100,000 brushes must not.

use crate::{BlendProfile, NodeDesc, OperatorKind};
use std::collections::BTreeMap;

/// Groups of more operands than this are counted.
pub(crate) const SUMMARY_THRESHOLD: usize = 256;

/// The visible operands of a group.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GroupSummary {
    /// By the bits of the blend radius, which are ordered as the radii: how many have it.
    blends: BTreeMap<u32, u32>,
    chamfers: u32,
    morphs: u32,
}

impl GroupSummary {
    /// One operand more.
    pub(crate) fn add(&mut self, entry: &NodeDesc) {
        let Some([blend, chamfer, morph]) = parts(entry) else {
            return;
        };
        *self.blends.entry(blend).or_default() += 1;
        self.chamfers += chamfer;
        self.morphs += morph;
    }

    /// One operand less.
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

    /// The greatest blend radius.
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

/// The bits of the blend radius, 1 for a chamfer, 1 for a morph; nothing of what takes no part.
fn parts(entry: &NodeDesc) -> Option<[u32; 3]> {
    let operator = &entry.operator;
    let is_chamfer = operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
    let is_morph = operator.kind == OperatorKind::Morph;
    // Never negative, as entries are checked; -0 would be the greatest of all.
    let blend = operator.blend.max(0.0).to_bits() & 0x7fff_ffff;
    entry
        .visible
        .then_some([blend, u32::from(is_chamfer), u32::from(is_morph)])
}
