//! How far the two solids of a morph are apart.

use crate::{Extents, NodeDesc, NodeId, NodeKind, OperatorKind, Scene, Shape};
use argil_math::Aabb;

impl Scene {
    /// Returns a value that the distances of a node and of all before it in its group differ by at most, in the group's
    /// unit: for [`MorphRamp::max_difference`](crate::MorphRamp::max_difference). Two solids differ by no more than their box is large, and two of a kind
    /// around the same point by no more than the corners of their boxes are apart. Infinite sides do not count.
    pub fn max_difference(&self, node: NodeId) -> f32 {
        let mut extents = Extents::of(self);
        let mut bounds_of = |id: NodeId| extents.node_bounds(id).aabb;
        let siblings = self.node(node).parent().map(|id| self.node(id).children());
        let earlier = siblings.unwrap_or_default().iter().copied();
        let before: Vec<NodeId> = earlier
            .take_while(|&id| id != node)
            .filter(|&id| self.node(id).at_current_time().visible)
            .collect();
        let whole = bounds_of(node);
        let others = before
            .iter()
            .fold(Aabb::EMPTY, |all, &id| all.union(bounds_of(id)));
        let entry = |id: NodeId| self.node(id).at_current_time();
        let apart = match before[..] {
            [only] if is_scaled_copy(entry(only), entry(node)) => corners_apart(others, whole),
            _ => finite_diagonal(others.union(whole)),
        };
        apart.max(1e-6)
    }
}

/// Whether two nodes are shapes of a kind that an axis-aligned scale about the same point maps onto each other.
fn is_scaled_copy(a: &NodeDesc, b: &NodeDesc) -> bool {
    let scales = |shape: &Shape| match shape {
        Shape::Sphere { .. } | Shape::Ellipsoid { .. } => true,
        Shape::Box { rounding, .. } | Shape::Cylinder { rounding, .. } => *rounding == 0.0,
        _ => false,
    };
    match (&a.kind, &b.kind) {
        (NodeKind::Shape(one), NodeKind::Shape(other)) => {
            let is_union = a.operator.kind == OperatorKind::Union;
            is_union && one.kind() == other.kind() && scales(one) && a.modifiers == b.modifiers
        }
        _ => false,
    }
}

/// Returns the largest distance between a corner of one box and the same corner of the other, along finite sides.
fn corners_apart(a: Aabb, b: Aabb) -> f32 {
    let along = |axis: usize| {
        let ends = [(a.min[axis], b.min[axis]), (a.max[axis], b.max[axis])];
        let apart = ends.map(|(one, other)| (one - other).abs());
        let finite = apart.into_iter().filter(|c| c.is_finite());
        finite.fold(0.0, f32::max)
    };
    glam::Vec3::from([0, 1, 2].map(along)).length()
}

/// Returns the diagonal of a box without its infinite sides.
fn finite_diagonal(all: Aabb) -> f32 {
    let sides = all.size().to_array();
    let finite = sides.map(|side| if side.is_finite() { side.max(0.0) } else { 0.0 });
    glam::Vec3::from(finite).length()
}
