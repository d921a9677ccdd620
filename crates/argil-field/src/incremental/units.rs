//! Removes and inserts units: pieces, and open groups with their contents.

use super::change_set::ChangeSet;
use super::groups::LoweredGroup;
use super::piece::{Operand, PieceItem};
use super::{IncrementalProgram, RANK_STEP};
use crate::pieces::{ROOT, leaves_open};
use argil_scene::{Node, NodeId, Scene, SceneChange};
use rustc_hash::FxHashSet;

impl IncrementalProgram {
    /// Returns the units that changes affect.
    pub(super) fn units(&self, scene: &Scene, changes: &[SceneChange]) -> FxHashSet<NodeId> {
        let mut units = FxHashSet::default();
        for change in changes {
            let Some(node) = change.node else {
                continue;
            };
            units.extend(self.unit_of(scene, node));
            for parent in change.parents.into_iter().flatten() {
                if self.groups.find(parent).is_none() {
                    units.extend(self.unit_of(scene, parent));
                } else if parent != Scene::ROOT
                    && scene.get(node).is_some_and(|found_node| {
                        found_node.parent() == Some(parent)
                            && !leaves_open(found_node.at_current_time())
                    })
                {
                    // It is no longer open.
                    units.insert(parent);
                }
            }
        }
        units
    }

    /// Returns the open group that a node is, or the piece that contains it. Returns `None` if it is neither known
    /// nor in the scene.
    pub(super) fn unit_of(&self, scene: &Scene, node: NodeId) -> Option<NodeId> {
        if self.groups.find(node).is_some() {
            return Some(node);
        }
        let mut at = node;
        loop {
            // What was removed may be gone, if its history was dropped.
            let parent = scene.get(at).and_then(Node::parent);
            let is_apart = parent.is_some_and(|parent| self.groups.find(parent).is_some());
            if is_apart || self.operands.contains_key(&at) {
                return Some(at);
            }
            at = parent?;
        }
    }

    /// Returns the group for a unit, or `None` if it is not in the scene, or if another unit contains it.
    pub(super) fn group_for(
        &self,
        scene: &Scene,
        node: NodeId,
        units: &FxHashSet<NodeId>,
    ) -> Option<u32> {
        let group = self.groups.find(scene.get(node)?.parent()?)?;
        let mut at = node;
        while let Some(parent) = scene.node(at).parent() {
            if units.contains(&parent) {
                return None;
            }
            at = parent;
        }
        (at == Scene::ROOT).then_some(group)
    }

    /// Removes a unit, and records the joints of its groups as touched.
    pub(super) fn take_out(&mut self, node: NodeId, changes_made: &mut ChangeSet) {
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            if let Some(old) = self.remove(node) {
                self.groups.release(old.group, node);
                changes_made.before.push(old);
                changes_made.nodes.push(node);
                continue;
            }
            let found = self.groups.find(node).filter(|&group| group != ROOT);
            let Some((id, group)) = found.and_then(|id| Some((id, self.groups.get(id)?))) else {
                continue;
            };
            open.extend(&group.children);
            let (at, length) = group.params;
            changes_made.stretches.push((at, at + length));
            let (operator, depth) = (group.operator, group.inside.depth);
            self.counts.count_blend(operator.blend, depth - 1, false);
            self.length -= 2;
            self.groups.remove(id);
        }
    }

    /// Places the groups of a unit in a group, and tells its pieces which groups contain them. `stretches` are the
    /// ranges of the groups' parameters.
    pub(super) fn place(
        &mut self,
        items: Vec<PieceItem>,
        group: u32,
        stretches: &mut Vec<(u32, u32)>,
    ) -> Vec<(NodeId, Operand)> {
        let mut pieces = Vec::new();
        let mut at = group;
        for item in items {
            match item {
                PieceItem::Piece(node, operand) => {
                    self.groups.hold(at, node);
                    let operand = Operand {
                        group: at,
                        group_adds: self.groups.inside(at).adds,
                        ..*operand
                    };
                    pieces.push((node, operand));
                }
                PieceItem::Enter(node, around, operator, scale) => {
                    let outside = self.groups.inside(at);
                    let params = self.arena.put(&mut self.tables.params, &around.params);
                    stretches.push((params, params + around.params.len() as u32));
                    self.counts.count_blend(operator.blend, outside.depth, true);
                    self.length += 2;
                    let group = LoweredGroup::new(node, &around, operator, &outside, scale, params);
                    at = self.groups.insert(group);
                }
                PieceItem::Leave => at = self.groups.parent_of(at),
            }
        }
        pieces
    }

    /// Returns ranks for a number of pieces, between those of a node's neighbors in the scene: the rank before the
    /// first, and the step.
    pub(super) fn ranks_for(&mut self, scene: &Scene, node: NodeId, count: u64) -> (u64, u64) {
        for _ in 0..2 {
            let before = self.neighbor(scene, node, false).unwrap_or(0);
            let Some(after) = self.neighbor(scene, node, true) else {
                return (before, RANK_STEP);
            };
            let step = (after - before) / (count + 1);
            if step > 0 {
                return (before, step);
            }
            // No room: renumber everything.
            self.update.renumbered = true;
            let order = std::mem::take(&mut self.order);
            for (&node, index) in order.values().zip(1..) {
                if let Some(operand) = self.operands.get_mut(&node) {
                    operand.rank = index * RANK_STEP;
                    self.order.insert(operand.rank, node);
                }
            }
            self.index_all();
        }
        unreachable!("a step of 2³² has room for all pieces that there can be")
    }

    /// Returns the rank of the piece before or after a node.
    pub(super) fn neighbor(&self, scene: &Scene, node: NodeId, is_after: bool) -> Option<u64> {
        let mut at = node;
        loop {
            let parent = scene.node(at).parent()?;
            let siblings = scene.node(parent).children();
            let position = siblings.iter().rposition(|&n| n == at)?;
            let end = |&node: &NodeId| self.end_rank(scene, node, is_after);
            let found = if is_after {
                siblings[position + 1..].iter().find_map(end)
            } else {
                siblings[..position].iter().rev().find_map(end)
            };
            if found.is_some() || parent == Scene::ROOT {
                return found;
            }
            at = parent;
        }
    }

    /// Returns the rank of the first or the last piece of a node.
    pub(super) fn end_rank(&self, scene: &Scene, node: NodeId, is_first: bool) -> Option<u64> {
        if let Some(operand) = self.operands.get(&node) {
            return Some(operand.rank);
        }
        self.groups.find(node)?;
        let mut children = scene.node(node).children().iter();
        let end = |&node: &NodeId| self.end_rank(scene, node, is_first);
        if is_first {
            children.find_map(end)
        } else {
            children.rev().find_map(end)
        }
    }
}
