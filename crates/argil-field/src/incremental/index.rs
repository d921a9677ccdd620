//! Finds the operands that can matter at a place: a coarse grid of parts on several levels, and a list of what
//! matters everywhere.

use super::groups::GroupTree;
use super::piece::Operand;
use crate::part_grid::{Part, PartGrid, parts_between};
use argil_abi::Instruction;
use argil_math::Aabb;
use argil_scene::{NodeId, OperatorKind};
use glam::IVec3;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// An operand in a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartEntry {
    pub rank: u64,
    pub node: NodeId,
    pub group: u32,
    /// The instruction of an operand that has only one. Most do, and their records are scattered in memory.
    pub instr: Option<Instruction>,
    /// The box in which it can matter.
    pub held: Aabb,
}

/// The operands that can matter in each part.
#[derive(Debug)]
pub(super) struct PartIndex {
    pub parts: PartGrid,
    /// The operands of each part, by rank.
    near: FxHashMap<Part, Vec<PartEntry>>,
    /// The levels in use, one bit each.
    levels: u32,
    /// Operands that matter wherever others do, by rank.
    pub everywhere: BTreeMap<u64, NodeId>,
    /// How far values can fall at the root and in each open group, as far as the boxes account for it.
    falls: [f32; 2],
}

impl PartIndex {
    /// Creates an empty index.
    pub(super) fn new(parts: PartGrid) -> Self {
        Self {
            parts,
            near: FxHashMap::default(),
            levels: 1,
            everywhere: BTreeMap::new(),
            falls: [0.0; 2],
        }
    }

    /// Whether the boxes account for values that fall this far.
    pub(super) fn has_room_for(&self, falls: [f32; 2]) -> bool {
        falls[0] <= self.falls[0] && falls[1] <= self.falls[1]
    }

    /// Empties the index, and accounts for values that fall this far.
    pub(super) fn begin(&mut self, falls: [f32; 2]) {
        // With some room, so that a growing blend does not repeat this each time.
        self.falls = std::array::from_fn(|i| self.falls[i].max(1.25 * falls[i]));
        self.near.clear();
        self.everywhere.clear();
    }

    /// Adds an operand.
    pub(super) fn enter(&mut self, node: NodeId, operand: &Operand, groups: &GroupTree) {
        let rank = operand.rank;
        let instr = match operand.instructions[..] {
            [only] => Some(only),
            _ => None,
        };
        let entry = PartEntry {
            rank,
            node,
            group: operand.group,
            instr,
            held: self.grown_box(operand, groups),
        };
        if self.is_everywhere(operand, groups) {
            self.everywhere.insert(rank, node);
        }
        for at in self.parts_of(operand, groups) {
            self.levels = self.levels.max(at.0 + 1);
            let list = self.near.entry(at).or_default();
            if let Err(place) = list.binary_search_by_key(&rank, |near| near.rank) {
                list.insert(place, entry);
            }
        }
    }

    /// Removes an operand.
    pub(super) fn remove(&mut self, operand: &Operand, groups: &GroupTree) {
        self.everywhere.remove(&operand.rank);
        for at in self.parts_of(operand, groups) {
            let Some(list) = self.near.get_mut(&at) else {
                continue;
            };
            if let Ok(place) = list.binary_search_by_key(&operand.rank, |near| near.rank) {
                list.remove(place);
            }
            if list.is_empty() {
                self.near.remove(&at);
            }
        }
    }

    /// Iterates over the operands of a part, and of the parts on other levels that contain it, each level by rank.
    pub(super) fn near_by_level(&self, part: IVec3) -> impl Iterator<Item = &[PartEntry]> {
        (0..self.levels).filter_map(move |level| {
            let entries = self.near.get(&(level, part >> (2 * level)));
            entries.map(Vec::as_slice)
        })
    }

    /// Returns all operands near a part, by rank.
    pub(super) fn near_in(&self, part: IVec3) -> Cow<'_, [PartEntry]> {
        let mut all = Cow::Borrowed(&[][..]);
        for entries in self.near_by_level(part) {
            if all.is_empty() {
                all = Cow::Borrowed(entries);
            } else {
                let joined = all.to_mut();
                joined.extend_from_slice(entries);
                joined.sort_by_key(|near| near.rank);
            }
        }
        all
    }

    /// Returns the box in which an operand can matter, unless it matters everywhere.
    pub(super) fn grown_box(&self, operand: &Operand, groups: &GroupTree) -> Aabb {
        let joints = groups.joints_of(operand.operator, operand.group);
        let outermost_first = joints.iter().rev();
        self.parts
            .reached_by(outermost_first, &operand.extent, self.falls)
    }

    pub(super) fn is_everywhere(&self, operand: &Operand, groups: &GroupTree) -> bool {
        let is_intersection = operand.operator.kind == OperatorKind::Intersect;
        let level = || self.parts.level_of(self.grown_box(operand, groups));
        operand.takes_part && (is_intersection || level().is_none())
    }

    /// Returns the parts in which an operand can matter.
    pub(super) fn parts_of(
        &self,
        operand: &Operand,
        groups: &GroupTree,
    ) -> impl Iterator<Item = Part> + use<> {
        let is_near = operand.takes_part && operand.operator.kind != OperatorKind::Intersect;
        let found = is_near
            .then(|| self.parts.level_of(self.grown_box(operand, groups)))
            .flatten();
        found.into_iter().flat_map(parts_between)
    }
}
