//! What the last update of a program has touched.

use super::piece::Operand;
use crate::part_grid::Part;
use argil_abi::Instruction;
use argil_math::Aabb;
use argil_scene::NodeId;
use rustc_hash::FxHashMap;
use std::collections::HashSet;

/// What the last update has touched, as it was and as it is: by instructions of either.
#[derive(Debug, Default)]
pub struct ChangeSet {
    /// Operands as they were; their parameters stand until the next update.
    pub(super) before: Vec<Operand>,
    /// Those of each part.
    pub(super) near: FxHashMap<Part, Vec<usize>>,
    /// Operands as they are.
    pub(super) after: HashSet<NodeId>,
    /// Stretches of parameters, ascending.
    pub(super) stretches: Vec<(u32, u32)>,
}

impl ChangeSet {
    /// Whether an instruction was touched, or is as it was before it was.
    pub fn has(&self, instr: &Instruction) -> bool {
        let at = self
            .stretches
            .partition_point(|&(begin, _)| begin <= instr.params);
        let last = at.checked_sub(1).map(|last| self.stretches[last]);
        last.is_some_and(|(_, end)| instr.params < end)
    }

    /// Whether a list has an instruction that was touched: without one it gives the same distances as before.
    pub fn any(&self, list: &[Instruction]) -> bool {
        list.iter().any(|instr| self.has(instr))
    }

    /// How many instructions of a list were touched.
    pub fn count(&self, list: &[Instruction]) -> usize {
        list.iter().filter(|instr| self.has(instr)).count()
    }
}

/// What an update did.
#[derive(Debug)]
pub(super) struct ChangeTracker {
    pub touched: Option<ChangeSet>,
    /// Whether what was touched is known.
    pub is_collected: bool,
    /// Whether ranks were given anew.
    pub renumbered: bool,
    /// The boxes of what it put in, with room for blends.
    pub put: Aabb,
    /// Whether it touched what is endless or cuts.
    pub touched_ends: bool,
    /// Boxes outside of which it changed nothing of what is known of jumps.
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
    /// What was touched; nothing where that may be anything.
    pub(super) fn collected(&self) -> Option<&ChangeSet> {
        self.touched.as_ref().filter(|_| self.is_collected)
    }
}
