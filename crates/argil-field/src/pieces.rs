//! What a scene is put together of, below its root.
//!
//! *Theory.* A group that is only moved, turned and scaled, and that is united or subtracted, acts on what is before it as its
//! operands do: where one of those is far away, the group's distance does not depend on it. So such a group is open: its operands
//! are pieces, which can matter, jump and be edited each by itself, as those of the root can. What is in any other group is one
//! piece.

use crate::regularity::{Regularity, joined};
use argil_scene::{
    BlendProfile, Extent, NodeDesc, NodeId, NodeKind, Operator, OperatorKind, Scene,
};

/// Groups within each other that are open at most: each takes a slot of the interpreter's stack.
pub(crate) const MAX_OPEN_GROUPS: usize = 4;

/// The root in [`OpenGroup::parent`] and [`Piece::group`].
pub(crate) const ROOT: u32 = 0;

/// Whether a group that holds a node can be open: chamfers let values fall far, and what morphs is a mixture of all.
pub(crate) fn leaves_open(entry: &NodeDesc) -> bool {
    let operator = &entry.operator;
    let is_chamfered = operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
    !is_chamfered && operator.kind != OperatorKind::Morph
}

/// Whether a group in so many others that are open is open too.
pub(crate) fn is_open(scene: &Scene, node: NodeId, depth: usize) -> bool {
    let own = scene.node(node);
    let entry = own.at_current_time();
    depth < MAX_OPEN_GROUPS
        && matches!(entry.kind, NodeKind::Group)
        && entry.visible
        && leaves_open(entry)
        && matches!(
            entry.operator.kind,
            OperatorKind::Union | OperatorKind::Subtract
        )
        && entry.modifiers.iter().all(|m| m.affine().is_some())
        && own
            .children()
            .iter()
            .all(|&child| leaves_open(scene.node(child).at_current_time()))
}

/// How much longer the world's unit is in a node's group than in the node.
pub(crate) fn scale_of(entry: &NodeDesc) -> f32 {
    entry.modifiers.iter().map(|m| m.scale()).product()
}

/// An operator as it is in the world, where its group is scaled.
pub(crate) fn scaled(operator: &Operator, scale: f32) -> Operator {
    Operator {
        blend: operator.blend * scale,
        ..*operator
    }
}

/// An open group.
pub(crate) struct OpenGroup {
    pub node: NodeId,
    /// The open group around it, by its place among all, or [`ROOT`].
    pub parent: u32,
    /// In the world's unit.
    pub operator: Operator,
    /// What a length in it is in the world.
    pub scale: f32,
}

/// A piece.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    pub node: NodeId,
    /// The group that it is in.
    pub group: u32,
}

/// A node's pieces in the scene's order, and the open groups that they are in. The first of those stands for the root.
pub(crate) struct Pieces {
    pub groups: Vec<OpenGroup>,
    pub all: Vec<Piece>,
}

impl Pieces {
    /// Of all of a scene.
    pub(crate) fn of(scene: &Scene) -> Self {
        let root = OpenGroup {
            node: Scene::ROOT,
            parent: ROOT,
            operator: Operator::default(),
            scale: 1.0,
        };
        let mut pieces = Self {
            groups: vec![root],
            all: Vec::new(),
        };
        for &child in scene.node(Scene::ROOT).children() {
            pieces.add(scene, child, ROOT, 0);
        }
        pieces
    }

    /// Adds those of a node in a group that is `depth` groups deep. The groups within are no deeper than [`MAX_OPEN_GROUPS`].
    pub(crate) fn add(&mut self, scene: &Scene, node: NodeId, group: u32, depth: usize) {
        if !is_open(scene, node, depth) {
            self.all.push(Piece { node, group });
            return;
        }
        let entry = scene.node(node).at_current_time();
        let outer = self.groups[group as usize].scale;
        let own = self.groups.len() as u32;
        self.groups.push(OpenGroup {
            node,
            parent: group,
            operator: scaled(&entry.operator, outer),
            scale: outer * scale_of(entry),
        });
        for &child in scene.node(node).children() {
            self.add(scene, child, own, depth + 1);
        }
    }
}

/// The power of two that no finite side of an extent's box exceeds, where its frame's unit is `scale` in the world; 0 where there is
/// none. Where the box is does not matter: a point near its surface has coordinates as great.
pub(crate) fn magnitude(extent: &Extent, scale: f32) -> f32 {
    if extent.aabb.is_empty() {
        return 0.0;
    }
    let sides = (extent.aabb.size() * scale).to_array().into_iter();
    let greatest = sides.filter(|side| side.is_finite()).fold(0.0, f32::max);
    if greatest > 0.0 {
        greatest.log2().ceil().exp2()
    } else {
        0.0
    }
}

/// What is said of a piece, in the world's unit.
#[derive(Clone, Copy)]
pub(crate) struct PieceInfo {
    pub group: u32,
    pub operator: Operator,
    pub regularity: Regularity,
    pub extent: Extent,
}

/// The groups that something is in, the outermost first.
pub(crate) fn chain<'a>(
    group: u32,
    parent_of: &impl Fn(u32) -> u32,
    out: &'a mut [u32; MAX_OPEN_GROUPS],
) -> &'a [u32] {
    let mut begin = MAX_OPEN_GROUPS;
    let mut at = group;
    while at != ROOT && begin > 0 {
        begin -= 1;
        out[begin] = at;
        at = parent_of(at);
    }
    &out[begin..]
}

/// A walk over pieces that enters and leaves their groups.
#[derive(Default)]
pub(crate) struct PieceWalk {
    open: Vec<u32>,
}

impl PieceWalk {
    /// Goes to a group: calls `step` with each that is left, innermost first, and then with each that is entered, outermost first.
    pub(crate) fn go_to(
        &mut self,
        group: u32,
        parent_of: impl Fn(u32) -> u32,
        mut step: impl FnMut(u32, bool),
    ) {
        if self.open.last().copied().unwrap_or(ROOT) == group {
            return;
        }
        let mut room = [ROOT; MAX_OPEN_GROUPS];
        let wanted = chain(group, &parent_of, &mut room);
        let same = self
            .open
            .iter()
            .zip(wanted)
            .take_while(|(a, b)| a == b)
            .count();
        while self.open.len() > same {
            if let Some(left) = self.open.pop() {
                step(left, false);
            }
        }
        for &entered in &wanted[same..] {
            self.open.push(entered);
            step(entered, true);
        }
    }
}

/// How regular all is that pieces make, which are told in the scene's order. Invisible ones are left out.
pub(crate) fn regularity_of(
    pieces: impl Iterator<Item = PieceInfo>,
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
) -> Regularity {
    let mut walk = PieceWalk::default();
    // Of each group that is entered, and how much its boxes tell too little.
    let mut stack = vec![(Regularity::SMOOTH, 1.0f32)];
    let step = |stack: &mut Vec<(Regularity, f32)>, group: u32, enters: bool| {
        if enters {
            stack.push((Regularity::SMOOTH, 1.0));
        } else if let Some((own, underestimate)) = stack.pop()
            && let Some((outer, most)) = stack.last_mut()
        {
            *outer = joined(*outer, own.settled(underestimate), &operator_of(group));
            *most = most.max(underestimate);
        }
    };
    for piece in pieces {
        walk.go_to(piece.group, &parent_of, |group, enters| {
            step(&mut stack, group, enters)
        });
        if let Some((own, most)) = stack.last_mut() {
            *own = joined(*own, piece.regularity, &piece.operator);
            *most = most.max(piece.extent.lipschitz_inverse);
        }
    }
    walk.go_to(ROOT, &parent_of, |group, enters| {
        step(&mut stack, group, enters)
    });
    // Each piece has told its own underestimate.
    stack[0].0.settled(1.0)
}
