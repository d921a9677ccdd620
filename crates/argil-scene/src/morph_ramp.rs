//! Morphs that go farther in some places than in others.
//!
//! *Theory.* With distances a and b and a ramp t, the result is a + t · (b − a). Its slope is that of a and b, and
//! |b − a| times the ramp's. The difference is clamped, and the result is divided by the bound of its slope.

use crate::ramp::ramp;
use crate::validation::positive;
use crate::{
    Extents, NodeDesc, NodeId, NodeKind, OperatorKind, Ramp, Scene, Shape, ValidationError,
};
use argil_math::Aabb;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far the curve may leave the interval from 0 to 1, as easing curves that swing do.
const MAX_OVERSHOOT: f32 = 1.0;

/// Where a morph goes how far: its amount is multiplied by the value of a ramp, in the frame of the surrounding group.
///
/// ```
/// use argil_scene::{Brush, Curve, MorphRamp, Operator, Ramp, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::cylinder(0.5, 1.0))?;
/// let along = Ramp::Line { from: [0.0, -1.0, 0.0], to: [0.0, 1.0, 0.0], curve: Curve::linear() };
/// let ramp = MorphRamp { along, max_difference: 0.3 };
/// scene.push(Brush::new(Shape::cylinder(0.2, 1.0)).morph(1.0).with_ramp(ramp))?;
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MorphRamp {
    /// The ramp.
    pub along: Ramp,
    /// The difference of the two distances is clamped to this value, in the group's unit. It should be how far the two
    /// surfaces are apart: larger values make distances less exact, and smaller ones change the surface.
    pub max_difference: f32,
}

impl MorphRamp {
    /// Checks the ramp, and that its values fit a morph.
    pub(crate) fn check(&self, kind: OperatorKind) -> Result<(), ValidationError> {
        ramp("ramp.along", &self.along)?;
        positive("ramp.max_difference", self.max_difference)?;
        if kind != OperatorKind::Morph {
            return Err(ValidationError::new("ramp", "only a morph has a ramp"));
        }
        let [low, high] = self.along.curve().range();
        if low < -MAX_OVERSHOOT || high > 1.0 + MAX_OVERSHOOT {
            let reason = format!(
                "the curve goes from {low} to {high}: a morph takes values from {} to {}",
                -MAX_OVERSHOOT,
                1.0 + MAX_OVERSHOOT
            );
            return Err(ValidationError::new("ramp.along", reason));
        }
        Ok(())
    }

    /// Returns the factor by which the result of a morph by `amount` is divided.
    pub fn stretch(&self, amount: f32) -> f32 {
        1.0 + 2.0 * self.beyond(amount) + amount * self.along.steepness() * self.max_difference
    }

    /// Returns the largest distance of the result's surface from the box of both solids.
    pub(crate) fn overshoot(&self, amount: f32) -> f32 {
        self.beyond(amount) * self.max_difference
    }

    fn beyond(&self, amount: f32) -> f32 {
        let [low, high] = self.along.curve().range().map(|share| amount * share);
        (-low).max(high - 1.0).max(0.0)
    }
}

impl Scene {
    /// Returns a value that the distances of a node and of all before it in its group differ by at most, in the group's
    /// unit: for [`MorphRamp::max_difference`]. Two solids differ by no more than their box is large, and two of a kind
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
