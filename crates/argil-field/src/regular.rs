//! How regular a field is: its Lipschitz constant and its jumps.

use crate::by_node::ByNode;
use argil_scene::{Body, Extents, Modifier, NodeId, Operator, OperatorKind, Profile, Scene};
use std::f32::consts::FRAC_1_SQRT_2;

/// What can be said of |d(p) − d(q)| for points p and q: at most `lipschitz` · |p − q| + `slack` + `hidden`.
///
/// Where copies are joined with others by hard operators alone, more can be said of the sign: a copy that the field does
/// not look at is at least `isolation` away, so within that length the sign changes as if nothing jumped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Regularity {
    pub lipschitz: f32,
    pub slack: f32,
    /// Jumps that change no sign within `isolation`.
    pub hidden: f32,
    pub isolation: f32,
}

impl Regularity {
    pub const SMOOTH: Self = Self {
        lipschitz: 1.0,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::INFINITY,
    };

    /// The same where values matter and not only signs.
    fn by_value(self) -> Self {
        Self {
            slack: self.slack + self.hidden,
            hidden: 0.0,
            isolation: f32::INFINITY,
            ..self
        }
    }
}

/// Of the first of some nodes, which are it and all that it holds, each before what it holds.
pub(crate) fn regularity(
    scene: &Scene,
    extents: &mut Extents<'_>,
    parents_first: &[NodeId],
) -> Regularity {
    let mut all = ByNode::of(parents_first, Regularity::SMOOTH);
    for &id in parents_first.iter().rev() {
        let entry = scene.node(id).entry();
        let mut result = Regularity::SMOOTH;
        if matches!(entry.body, Body::Group) {
            for &child in scene.node(id).children() {
                let operand = scene.node(child).entry();
                if operand.visible {
                    result = joined(result, all[child], &operand.operator);
                }
            }
        }
        if !entry.modifiers.is_empty() {
            let stages = extents.stages(id);
            for (modifier, content) in entry.modifiers.iter().zip(&stages) {
                let scale = modifier.scale();
                result.slack *= scale;
                result.hidden *= scale;
                result.isolation *= scale;
                if modifier.affine().is_some() {
                    continue;
                }
                result = result.by_value();
                let (jump, isolation) = (jump(modifier, content), isolation(modifier, content));
                if isolation > 0.0 {
                    (result.hidden, result.isolation) = (jump, isolation);
                } else {
                    result.slack += jump;
                }
            }
        }
        all[id] = result;
    }
    parents_first
        .first()
        .map_or(Regularity::SMOOTH, |&root| all[root])
}

pub(crate) fn joined(a: Regularity, b: Regularity, operator: &Operator) -> Regularity {
    let is_boolean = operator.blend == 0.0
        && !matches!(operator.kind, OperatorKind::Paint | OperatorKind::Morph);
    let (a, b) = if is_boolean {
        (a, b)
    } else {
        (a.by_value(), b.by_value())
    };
    let hard = Regularity {
        lipschitz: a.lipschitz.max(b.lipschitz),
        slack: a.slack.max(b.slack),
        hidden: a.hidden.max(b.hidden),
        isolation: a.isolation.min(b.isolation),
    };
    let chamfered = operator.profile == Profile::Chamfer && operator.blend > 0.0;
    if chamfered && !matches!(operator.kind, OperatorKind::Paint | OperatorKind::Morph) {
        // The face is (a + b − k) / √2.
        Regularity {
            lipschitz: hard
                .lipschitz
                .max((a.lipschitz + b.lipschitz) * FRAC_1_SQRT_2),
            slack: hard.slack.max((a.slack + b.slack) * FRAC_1_SQRT_2),
            ..hard
        }
    } else {
        hard
    }
}

/// Where the set of nearest copies changes, the minimum over them can jump by what the solid's own distance falls short
/// of the Euclidean one; that is at most the greatest distance between points of neighbouring cells.
fn jump(modifier: &Modifier, content: &argil_scene::Extent) -> f32 {
    let width = match *modifier {
        Modifier::Repeat { spacing, .. } => glam::Vec3::from(spacing).length(),
        Modifier::RadialRepeat { .. } => {
            content.aabb.min.abs().max(content.aabb.max.abs()).length()
        }
        _ => return 0.0,
    };
    let size = if content.aabb.is_finite() {
        2.0 * content.aabb.half_diagonal()
    } else {
        0.0
    };
    content.shortfall.min(width + size)
}

/// How far the copies are, at least, that a point does not look at; 0 where that is not known.
fn isolation(modifier: &Modifier, content: &argil_scene::Extent) -> f32 {
    let Modifier::Repeat { spacing, count } = *modifier else {
        return 0.0;
    };
    if !content.aabb.is_finite() {
        return 0.0;
    }
    let half = content.aabb.min.abs().max(content.aabb.max.abs());
    (0..3)
        .filter(|&axis| count.is_none_or(|count| count[axis] != 1))
        .map(|axis| {
            // A point looks at its own copy and at the nearest neighbour, if not at more.
            if half[axis] <= 0.5 * spacing[axis] {
                spacing[axis] - half[axis]
            } else {
                0.0
            }
        })
        .fold(f32::INFINITY, f32::min)
        * 0.999
}
