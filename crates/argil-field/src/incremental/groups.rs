//! The open groups of an incremental program.

use crate::lower::{EnclosingGroup, Frame};
use crate::pieces::{PieceWalk, ROOT};
use crate::spans::append;
use argil_abi::Instruction;
use argil_scene::{NodeId, Operator, OperatorKind, Scene};
use rustc_hash::{FxHashMap, FxHashSet};

/// The place of a piece or a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroupPosition {
    /// The open group, or the root.
    pub group: u32,
    pub frame: Frame,
    /// The length of its unit in the scene's unit.
    pub scale: f32,
    /// Number of groups around it.
    pub depth: usize,
    /// Whether all of them add.
    pub adds: bool,
}

impl GroupPosition {
    pub(super) const ROOT: Self = Self {
        group: ROOT,
        frame: Frame::OF_WORLD,
        scale: 1.0,
        depth: 0,
        adds: true,
    };
}

/// An open group.
#[derive(Debug)]
pub(super) struct LoweredGroup {
    pub node: NodeId,
    pub parent: u32,
    /// Its operator, in the scene's unit.
    pub operator: Operator,
    /// The place of its contents.
    pub inside: GroupPosition,
    pub open: Instruction,
    pub close: Instruction,
    /// Its range of the parameters.
    pub params: (u32, u32),
    /// The pieces and groups in it.
    pub children: FxHashSet<NodeId>,
}

impl LoweredGroup {
    /// Creates a group at a place, with parameters at an index.
    pub(super) fn new(
        node: NodeId,
        around: &EnclosingGroup,
        operator: Operator,
        outside: &GroupPosition,
        scale: f32,
        at: u32,
    ) -> Self {
        let moved = |instr: Instruction| Instruction {
            params: at,
            ..instr
        };
        Self {
            node,
            parent: outside.group,
            operator,
            inside: GroupPosition {
                group: ROOT,
                frame: around.frame,
                scale: outside.scale * scale,
                depth: outside.depth + 1,
                adds: outside.adds && operator.kind == OperatorKind::Union,
            },
            open: moved(around.open),
            close: moved(around.close),
            params: (at, around.params.len() as u32),
            children: FxHashSet::default(),
        }
    }
}

/// All open groups.
#[derive(Debug, Default)]
pub(super) struct GroupTree {
    all: FxHashMap<u32, LoweredGroup>,
    of: FxHashMap<NodeId, u32>,
    last: u32,
    /// Groups that the last update removed. Earlier programs still refer to them.
    gone: Vec<u32>,
}

impl GroupTree {
    /// Returns the index of a node that is an open group, or the root.
    pub(super) fn find(&self, node: NodeId) -> Option<u32> {
        if node == Scene::ROOT {
            return Some(ROOT);
        }
        self.of.get(&node).copied()
    }

    /// Returns an operator and those of the groups that contain its operand, innermost first.
    pub(super) fn joints_of(&self, operator: Operator, group: u32) -> Vec<Operator> {
        let mut joints = vec![operator];
        let mut at = group;
        while let Some(group) = self.get(at) {
            joints.push(group.operator);
            at = group.parent;
        }
        joints
    }

    /// Returns a group that is not the root.
    pub(super) fn get(&self, group: u32) -> Option<&LoweredGroup> {
        self.all.get(&group)
    }

    pub(super) fn parent_of(&self, group: u32) -> u32 {
        self.all
            .get(&group)
            .map_or(ROOT, |found_group| found_group.parent)
    }

    pub(super) fn operator_of(&self, group: u32) -> Operator {
        self.all
            .get(&group)
            .map_or_else(Operator::default, |found_group| found_group.operator)
    }

    /// Returns the place of a group's contents.
    pub(super) fn inside(&self, group: u32) -> GroupPosition {
        self.all
            .get(&group)
            .map_or(GroupPosition::ROOT, |found_group| found_group.inside)
    }

    pub(super) fn insert(&mut self, mut group: LoweredGroup) -> u32 {
        self.last += 1;
        let id = self.last;
        group.inside.group = id;
        self.of.insert(group.node, id);
        self.hold(group.parent, group.node);
        self.all.insert(id, group);
        id
    }

    /// Records that a group contains a node.
    pub(super) fn hold(&mut self, group: u32, node: NodeId) {
        if let Some(entry) = self.all.get_mut(&group) {
            entry.children.insert(node);
        }
    }

    /// Records that a group no longer contains a node.
    pub(super) fn release(&mut self, group: u32, node: NodeId) {
        if let Some(entry) = self.all.get_mut(&group) {
            entry.children.remove(&node);
        }
    }

    /// Removes a group. It stays until the next update.
    pub(super) fn remove(&mut self, group: u32) {
        if let Some(entry) = self.all.get(&group) {
            self.of.remove(&entry.node);
            let (parent, node) = (entry.parent, entry.node);
            self.release(parent, node);
            self.gone.push(group);
        }
    }

    /// Drops the groups that the last update removed. Returns their ranges of parameters.
    pub(super) fn remove_unused(&mut self) -> Vec<(u32, u32)> {
        let gone = std::mem::take(&mut self.gone);
        let removed = gone.into_iter().filter_map(|id| self.all.remove(&id));
        removed.map(|group| group.params).collect()
    }

    /// Returns the outermost group around the contents of a group, or the root for the root's.
    pub(super) fn outermost(&self, group: u32) -> u32 {
        let mut at = group;
        loop {
            match self.parent_of(at) {
                ROOT => return at,
                parent => at = parent,
            }
        }
    }
}

/// Writes a program with the joints of the groups around its pieces.
pub(super) struct ListWriter<'a> {
    groups: &'a GroupTree,
    walk: PieceWalk,
    out: &'a mut Vec<Instruction>,
}

impl<'a> ListWriter<'a> {
    pub(super) fn new(groups: &'a GroupTree, out: &'a mut Vec<Instruction>) -> Self {
        Self {
            groups,
            walk: PieceWalk::default(),
            out,
        }
    }

    /// Appends a piece.
    pub(super) fn put(&mut self, group: u32, instructions: &[Instruction]) {
        self.go_to(group);
        match instructions {
            [only] => self.out.push(*only),
            all => append(all, self.out),
        }
    }

    /// Returns the number of instructions.
    pub(super) fn len(&self) -> usize {
        self.out.len()
    }

    /// Leaves all groups.
    pub(super) fn end(&mut self) {
        self.go_to(ROOT);
    }

    fn go_to(&mut self, group: u32) {
        let (groups, out) = (self.groups, &mut *self.out);
        let parent_of = |group: u32| groups.parent_of(group);
        self.walk.go_to(group, parent_of, |group, enters| {
            if let Some(entry) = groups.get(group) {
                out.push(if enters { entry.open } else { entry.close });
            }
        });
    }
}
