//! Divides a scene into pieces.
//!
//! *Theory.* A group that is only transformed, and that is united or subtracted, acts on what comes before it as
//! its operands do. Where one of them is far away, the group's distance does not depend on it. So such a group is
//! open: its operands are pieces, which can matter, jump and be edited by themselves, like those of the root. Any
//! other group is one piece with its contents.

use crate::regularity::{Regularity, joined};
use argil_scene::{
    BlendProfile, Extent, NodeDesc, NodeId, NodeKind, Operator, OperatorKind, Scene,
};

/// Maximum nesting of open groups, because each takes a slot of the interpreter's stack.
pub(crate) const MAX_OPEN_GROUPS: usize = 4;

/// The root, in [`OpenGroup::parent`] and [`Piece::group`].
pub(crate) const ROOT: u32 = 0;

/// Whether a group that contains a node can be open. Chamfers let values fall far, and a morph mixes everything.
pub(crate) fn leaves_open(entry: &NodeDesc) -> bool {
    let operator = &entry.operator;
    let is_chamfered = operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
    !is_chamfered && operator.kind != OperatorKind::Morph
}

/// Whether a group inside a number of open groups is open too.
pub(crate) fn is_open(scene: &Scene, node: NodeId, depth: usize) -> bool {
    let found_node = scene.node(node);
    let entry = found_node.at_current_time();
    depth < MAX_OPEN_GROUPS
        && matches!(entry.kind, NodeKind::Group)
        && entry.visible
        && leaves_open(entry)
        && matches!(
            entry.operator.kind,
            OperatorKind::Union | OperatorKind::Subtract
        )
        && entry.modifiers.iter().all(|m| m.affine().is_some())
        && found_node
            .children()
            .iter()
            .all(|&child| leaves_open(scene.node(child).at_current_time()))
}

/// Returns the length of a node's unit in its group's unit.
pub(crate) fn scale_of(entry: &NodeDesc) -> f32 {
    entry.modifiers.iter().map(|m| m.scale()).product()
}

/// Returns an operator in the scene's unit, given its group's scale.
pub(crate) fn scaled(operator: &Operator, scale: f32) -> Operator {
    Operator {
        blend: operator.blend * scale,
        ..*operator
    }
}

/// An open group.
pub(crate) struct OpenGroup {
    pub node: NodeId,
    /// The open group around it, by index, or [`ROOT`].
    pub parent: u32,
    /// Its operator, in the scene's unit.
    pub operator: Operator,
    /// The length of its unit in the scene's unit.
    pub scale: f32,
}

/// A piece.
#[derive(Clone, Copy)]
pub(crate) struct Piece {
    pub node: NodeId,
    /// The group that contains it.
    pub group: u32,
}

/// A node's pieces in the scene's order, and the open groups that contain them. The first group is the root.
pub(crate) struct Pieces {
    pub groups: Vec<OpenGroup>,
    pub all: Vec<Piece>,
}

impl Pieces {
    /// Returns the pieces of a scene.
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

    /// Adds the pieces of a node that is `depth` groups deep. Groups within are open up to [`MAX_OPEN_GROUPS`].
    pub(crate) fn add(&mut self, scene: &Scene, node: NodeId, group: u32, depth: usize) {
        if !is_open(scene, node, depth) {
            self.all.push(Piece { node, group });
            return;
        }
        let entry = scene.node(node).at_current_time();
        let outer = self.groups[group as usize].scale;
        let index = self.groups.len() as u32;
        self.groups.push(OpenGroup {
            node,
            parent: group,
            operator: scaled(&entry.operator, outer),
            scale: outer * scale_of(entry),
        });
        for &child in scene.node(node).children() {
            self.add(scene, child, index, depth + 1);
        }
    }
}

/// Returns the power of two that no finite side of an extent's box exceeds, if its frame's unit has length `scale`
/// in the scene. Returns 0 for an empty box. The box's position does not matter, because a point near its surface
/// has coordinates of that size.
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

/// Facts about a piece, in the scene's unit.
#[derive(Clone, Copy)]
pub(crate) struct PieceInfo {
    pub group: u32,
    pub operator: Operator,
    pub regularity: Regularity,
    pub extent: Extent,
    /// The largest distance by which a ramp moves the surface of a morph out of both solids' boxes.
    pub overshoot: f32,
}

/// Leaves out the first pieces, which have nothing to act on, unless they add.
pub(crate) fn acting(
    pieces: impl Iterator<Item = PieceInfo>,
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
) -> Vec<PieceInfo> {
    let outermost = |piece: &PieceInfo| {
        let (mut operator, mut group) = (piece.operator, piece.group);
        while group != ROOT {
            (operator, group) = (operator_of(group), parent_of(group));
        }
        operator.kind
    };
    pieces
        .skip_while(|piece| outermost(piece) != OperatorKind::Union)
        .collect()
}

/// Returns the overshoot of a node's ramp, in the unit of the group around it.
pub(crate) fn ramp_overshoot(entry: &NodeDesc) -> f32 {
    let amount = entry.operator.morph_amount;
    entry
        .ramp
        .as_ref()
        .map_or(0.0, |ramp| ramp.overshoot(amount))
}

/// Returns the groups that contain something, outermost first.
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
    /// Goes to a group. Calls `step` for each group that is left, innermost first, and then for each that is
    /// entered, outermost first.
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

/// Returns the regularity of all pieces, given in the scene's order.
pub(crate) fn regularity_of(
    pieces: &[PieceInfo],
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
) -> Regularity {
    let mut walk = PieceWalk::default();
    // For each entered group, and how much its boxes understate distances.
    let mut stack = vec![(Regularity::SMOOTH, 1.0f32)];
    let step = |stack: &mut Vec<(Regularity, f32)>, group: u32, enters: bool| {
        if enters {
            stack.push((Regularity::SMOOTH, 1.0));
        } else if let Some((inner, underestimate)) = stack.pop()
            && let Some((outer, most)) = stack.last_mut()
        {
            *outer = joined(*outer, inner.settled(underestimate), &operator_of(group));
            *most = most.max(underestimate);
        }
    };
    for piece in pieces {
        walk.go_to(piece.group, &parent_of, |group, enters| {
            step(&mut stack, group, enters)
        });
        if let Some((regularity, most)) = stack.last_mut() {
            *regularity = joined(*regularity, piece.regularity, &piece.operator);
            *most = most.max(piece.extent.lipschitz_inverse);
        }
    }
    walk.go_to(ROOT, &parent_of, |group, enters| {
        step(&mut stack, group, enters)
    });
    // Each piece has included its own underestimate.
    stack[0].0.settled(1.0)
}
