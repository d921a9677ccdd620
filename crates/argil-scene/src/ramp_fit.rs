//! How a morph with a ramp fits its two solids.

use crate::{Extents, MAX_LENGTH, NodeDesc, NodeId, NodeKind, OperatorKind, Ramp, Scene, Shape};
use argil_math::Aabb;
use glam::{DVec3, Vec3};

impl Scene {
    /// Returns a value that the distances of a node and of all before it in its group differ by at most, in the group's
    /// unit: for [`MorphRamp::max_difference`](crate::MorphRamp::max_difference). Two solids differ by no more than their box is large, and two of a kind
    /// around the same point by no more than points of one are apart from those of the other. Infinite sides do not
    /// count.
    pub fn max_difference(&self, node: NodeId) -> f32 {
        let before = self.visible_before(node);
        let mut extents = Extents::of(self);
        let mut bounds_of = |id: NodeId| extents.node_bounds(id).aabb;
        let whole = bounds_of(node);
        let others = before
            .iter()
            .fold(Aabb::EMPTY, |all, &id| all.union(bounds_of(id)));
        let entry = |id: NodeId| self.node(id).at_current_time();
        let is_similar = match before[..] {
            [only] => copies_apart(entry(only), entry(node)),
            _ => None,
        };
        is_similar
            .unwrap_or_else(|| finite_diagonal(others.union(whole)))
            .max(1e-6)
    }

    /// Returns the factor by which the result of a node's morph is divided, if that has a ramp.
    ///
    /// The derivative is the mean of both distances' gradients, plus the ramp's times their difference. Where both solids
    /// are endless along the ramp, the two parts are at right angles. The root's nodes can be edited alone, so no use
    /// is made of that among them.
    pub fn ramp_stretch(&self, node: NodeId) -> f32 {
        let entry = self.node(node).at_current_time();
        let Some(ramp) = &entry.ramp else { return 1.0 };
        let [value, change] = ramp.slopes(entry.operator.morph_amount);
        let is_across = self.node(node).parent() != Some(Self::ROOT)
            && match ramp.along {
                Ramp::Line { from, to, .. } => {
                    let line = (Vec3::from(to) - Vec3::from(from)).as_dvec3();
                    let endless = |id: &NodeId| is_endless(self.node(*id).at_current_time(), line);
                    endless(&node) && self.visible_before(node).iter().all(endless)
                }
                Ramp::Radius { .. } => false,
            };
        if is_across {
            value.hypot(change)
        } else {
            value + change
        }
    }

    /// Returns the visible nodes before a node in its group.
    fn visible_before(&self, node: NodeId) -> Vec<NodeId> {
        let siblings = self.node(node).parent().map(|id| self.node(id).children());
        let earlier = siblings.unwrap_or_default().iter().copied();
        earlier
            .take_while(|&id| id != node)
            .filter(|&id| self.node(id).at_current_time().visible)
            .collect()
    }
}

/// Whether the distance of a node does not change in a direction.
fn is_endless(desc: &NodeDesc, direction: DVec3) -> bool {
    let mut local = direction;
    for modifier in desc.modifiers.iter().rev() {
        let Some(own_from_outer) = modifier.affine() else {
            return false;
        };
        local = own_from_outer.matrix3 * local;
    }
    let local = local.normalize_or_zero().abs();
    let is_along = |axis: usize, length: f32| length >= MAX_LENGTH && local[axis] > 1.0 - 1e-12;
    match &desc.kind {
        NodeKind::Shape(Shape::Cylinder { half_height, .. }) => is_along(1, *half_height),
        NodeKind::Shape(Shape::Box { half_size, .. }) => {
            (0..3).any(|axis| is_along(axis, half_size[axis]))
        }
        _ => false,
    }
}

/// Returns how far points of two shapes are apart, if an axis-aligned scale about the same point maps one onto the
/// other.
fn copies_apart(a: &NodeDesc, b: &NodeDesc) -> Option<f32> {
    let (NodeKind::Shape(one), NodeKind::Shape(other)) = (&a.kind, &b.kind) else {
        return None;
    };
    let is_placed_is_similar = a.operator.kind == OperatorKind::Union
        && a.modifiers == b.modifiers
        && a.modifiers.iter().all(|m| m.affine().is_some());
    if !is_placed_is_similar {
        return None;
    }
    let apart = |a: f32, b: f32| {
        if a.min(b) >= MAX_LENGTH { 0.0 } else { a - b }
    };
    let sizes =
        |a: [f32; 3], b: [f32; 3]| Vec3::from([0, 1, 2].map(|i| apart(a[i], b[i]))).length();
    let difference = match (one, other) {
        (Shape::Sphere { radius: a }, Shape::Sphere { radius: b }) => (a - b).abs(),
        (Shape::Ellipsoid { radii: a }, Shape::Ellipsoid { radii: b }) => sizes(*a, *b),
        (
            Shape::Box {
                half_size: a,
                rounding: 0.0,
            },
            Shape::Box {
                half_size: b,
                rounding: 0.0,
            },
        ) => sizes(*a, *b),
        (
            Shape::Cylinder {
                radius: a,
                half_height: h,
                rounding: 0.0,
            },
            Shape::Cylinder {
                radius: b,
                half_height: g,
                rounding: 0.0,
            },
        ) => apart(*a, *b).hypot(apart(*h, *g)),
        _ => return None,
    };
    Some(difference * a.modifiers.iter().map(|m| m.scale()).product::<f32>())
}

/// Returns the diagonal of a box without its infinite sides.
fn finite_diagonal(all: Aabb) -> f32 {
    let sides = all.size().to_array();
    let finite = sides.map(|side| if side.is_finite() { side.max(0.0) } else { 0.0 });
    glam::Vec3::from(finite).length()
}
