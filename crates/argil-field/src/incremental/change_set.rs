//! What the last update of a program touched.

use super::piece::Operand;
use crate::part_grid::Part;
use argil_abi::Instruction;
use argil_math::Aabb;
use argil_scene::NodeId;
use rustc_hash::FxHashMap;
use std::collections::HashSet;

/// The instructions that the last update touched, before and after it.
#[derive(Debug, Default)]
pub struct ChangeSet {
    /// Operands before the update. Their parameters stay until the next update.
    pub(super) before: Vec<Operand>,
    /// Their nodes.
    pub(super) nodes: Vec<NodeId>,
    /// Operands of each part.
    pub(super) near: FxHashMap<Part, Vec<usize>>,
    /// Operands after the update.
    pub(super) after: HashSet<NodeId>,
    /// Ranges of parameters, ascending.
    pub(super) stretches: Vec<(u32, u32)>,
}

impl ChangeSet {
    /// Whether an instruction was touched, before or after the update.
    pub fn contains(&self, instr: &Instruction) -> bool {
        let at = self
            .stretches
            .partition_point(|&(begin, _)| begin <= instr.params);
        let last = at.checked_sub(1).map(|last| self.stretches[last]);
        last.is_some_and(|(_, end)| instr.params < end)
    }

    /// Whether a list contains a touched instruction. If it does not, its distances are unchanged.
    pub fn intersects(&self, list: &[Instruction]) -> bool {
        list.iter().any(|instr| self.contains(instr))
    }

    /// Returns the number of touched instructions in a list.
    pub fn count_in(&self, list: &[Instruction]) -> usize {
        list.iter().filter(|instr| self.contains(instr)).count()
    }
}

/// What an update did.
#[derive(Debug)]
pub(super) struct ChangeTracker {
    pub touched: Option<ChangeSet>,
    /// Whether the touched operands are known.
    pub is_collected: bool,
    /// Whether ranks were renumbered.
    pub renumbered: bool,
    /// The box of what it inserted, with room for blends.
    pub put: Aabb,
    /// Whether it touched an infinite solid, or one that clips.
    pub touched_ends: bool,
    /// Boxes outside which the facts about jumps did not change.
    pub loosened: Vec<Aabb>,
}

impl Default for ChangeTracker {
    fn default() -> Self {
        Self {
            touched: None,
            is_collected: false,
            renumbered: false,
            put: Aabb::EMPTY,
            touched_ends: false,
            loosened: Vec::new(),
        }
    }
}

impl ChangeTracker {
    /// Returns what was touched, or `None` if it may be anything.
    pub(super) fn collected(&self) -> Option<&ChangeSet> {
        self.touched.as_ref().filter(|_| self.is_collected)
    }
}
