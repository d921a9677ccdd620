//! The regularity of a field: its Lipschitz constant and its jumps.

use crate::node_map::NodeMap;
use argil_abi as abi;
use argil_math::Aabb;
use argil_scene::{
    BlendProfile, Extents, Modifier, NodeId, NodeKind, Operator, OperatorKind, Scene,
    evaluated_copies, half_angle_about_y, max_blend_propagation, nearest_is_own, wrap_copies,
    wrap_core,
};
use glam::Vec2;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

/// A bound on |d(p) − d(q)| for points p and q: `lipschitz` · |p − q| + `slack` + `hidden`.
///
/// If copies are joined only by hard operators, more is known about the sign. A copy that the field does not
/// evaluate is at least `isolation` away, so within that distance the sign changes as if nothing jumped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Regularity {
    pub lipschitz: f32,
    pub slack: f32,
    /// Jumps that change no sign within `isolation`.
    pub hidden: f32,
    pub isolation: f32,
    /// If there are hidden jumps: a copy's distance is at least the distance to its box, divided by this.
    pub underestimate: f32,
    /// The blend radii of later smooth joints: their sum, and the largest.
    pub blends: f32,
    pub blend: f32,
}

impl Regularity {
    pub(crate) const SMOOTH: Self = Self {
        lipschitz: 1.0,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::INFINITY,
        underestimate: 1.0,
        blends: 0.0,
        blend: 0.0,
    };

    /// Returns the regularity after scaling lengths by a factor.
    pub(crate) fn scaled(self, scale: f32) -> Self {
        Self {
            slack: self.slack * scale,
            hidden: self.hidden * scale,
            isolation: self.isolation * scale,
            blends: self.blends * scale,
            blend: self.blend * scale,
            ..self
        }
    }

    /// Returns the regularity under a smooth joint of a radius.
    fn blended_over(self, radius: f32) -> Self {
        if self.hidden == 0.0 {
            return self;
        }
        Self {
            blends: self.blends + radius,
            blend: self.blend.max(radius),
            ..self
        }
    }

    /// Returns the regularity with what smooth joints subtract from the isolation. A joint of radius k keeps the
    /// sign where the copy's distance is at least k: it subtracts (k − |a − b|)² / 4k, which is less than the other
    /// value then. Many joints add up to no more than values can fall. `underestimate` is the solid's.
    pub(crate) fn settled(self, underestimate: f32) -> Self {
        if self.hidden == 0.0 {
            return Self {
                underestimate: 1.0,
                ..self
            };
        }
        let underestimate = underestimate.max(self.underestimate);
        let falls = self
            .blends
            .min(max_blend_propagation(self.blend, false, 0.0));
        let isolation = self.isolation - 1.000_1 * underestimate * falls;
        let settled = Self {
            isolation,
            underestimate,
            blends: 0.0,
            blend: 0.0,
            ..self
        };
        if isolation > 0.0 {
            settled
        } else {
            settled.by_value()
        }
    }

    /// Returns the regularity where values matter, and not only signs.
    fn by_value(self) -> Self {
        Self {
            slack: self.slack + self.hidden,
            hidden: 0.0,
            isolation: f32::INFINITY,
            underestimate: 1.0,
            blends: 0.0,
            blend: 0.0,
            ..self
        }
    }
}

/// Returns the regularity of nodes, given each before its contents.
pub(crate) fn regularity(
    scene: &Scene,
    extents: &mut Extents<'_>,
    parents_first: &[NodeId],
) -> NodeMap<Regularity> {
    let mut all = NodeMap::of(parents_first, Regularity::SMOOTH);
    for &id in parents_first.iter().rev() {
        let entry = scene.node(id).at_current_time();
        let mut result = Regularity::SMOOTH;
        if let NodeKind::Shape(shape) = &entry.kind {
            result.lipschitz = shape.lipschitz();
        }
        if matches!(entry.kind, NodeKind::Group) {
            for &child in scene.node(id).children() {
                if extents.takes_part(child) {
                    let operand = scene.node(child).at_current_time();
                    result = joined(result, all[child], &operand.operator);
                }
            }
        }
        if !entry.modifiers.is_empty() {
            let stages = extents.modifier_stages(id);
            for (modifier, content) in entry.modifiers.iter().zip(&stages) {
                result = result.scaled(modifier.scale());
                if modifier.affine().is_some() {
                    continue;
                }
                result = result.by_value();
                if let Modifier::Instances { poses } = modifier {
                    result = result.scaled(poses.scales()[1]);
                    continue;
                }
                let (jump, isolation) = (jump(modifier, content), isolation(modifier, content));
                if isolation > 0.0 {
                    (result.hidden, result.isolation) = (jump, isolation);
                } else {
                    result.slack += jump;
                }
            }
        }
        // The root's comes from its pieces, which are all that an incremental program knows.
        if id != Scene::ROOT {
            all[id] = result.settled(extents.node_bounds(id).lipschitz_inverse);
        }
    }
    all
}

pub(crate) fn joined(a: Regularity, b: Regularity, operator: &Operator) -> Regularity {
    let is_boolean = operator.blend == 0.0
        && !matches!(operator.kind, OperatorKind::Paint | OperatorKind::Morph);
    let is_smooth = operator.profile == BlendProfile::Smooth
        && !matches!(operator.kind, OperatorKind::Paint | OperatorKind::Morph);
    let (a, b) = if is_boolean {
        (a, b)
    } else if is_smooth {
        (
            a.blended_over(operator.blend),
            b.blended_over(operator.blend),
        )
    } else {
        (a.by_value(), b.by_value())
    };
    let hard = Regularity {
        lipschitz: a.lipschitz.max(b.lipschitz),
        slack: a.slack.max(b.slack),
        hidden: a.hidden.max(b.hidden),
        isolation: a.isolation.min(b.isolation),
        underestimate: a.underestimate.max(b.underestimate),
        blends: a.blends.max(b.blends),
        blend: a.blend.max(b.blend),
    };
    let chamfered = operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
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

/// Returns the minimum distance, in steps, of the centers of copies that are not evaluated. A point evaluates its
/// own copy and the nearest neighbor, or the same number on each side.
fn steps_away(looked_at: u32) -> f32 {
    if looked_at <= 2 {
        1.0
    } else {
        0.5 * looked_at as f32
    }
}

/// Returns the isolation of radial copies. The centers of copies that are not evaluated are some steps away, and
/// the copies begin half of their angle nearer. On the axis, that is no distance, but a copy begins some way from
/// the axis. The minimum is the larger of the two where they are equal.
fn radial_isolation(count: u32, looked_at: u32, content: Aabb) -> f32 {
    let step = TAU / count as f32;
    let half = half_angle_about_y(content);
    let angle = steps_away(looked_at) * step - half;
    if angle <= 0.0 {
        return 0.0;
    }
    let sine = angle.min(FRAC_PI_2).sin();
    let nearest = Vec2::ZERO.clamp(
        Vec2::new(content.min.x, content.min.z),
        Vec2::new(content.max.x, content.max.z),
    );
    0.999 * nearest.length() * sine / (1.0 + sine)
}

/// Returns the largest jump. Where the set of nearest copies changes, their minimum jumps by at most the amount by
/// which the solid's distance underestimates the Euclidean one, and by at most the largest distance between points
/// of neighboring cells.
fn jump(modifier: &Modifier, content: &argil_scene::Extent) -> f32 {
    if let Modifier::Wrap {
        from,
        to,
        radius,
        ref curve,
    } = *modifier
    {
        let whole = content.under(std::slice::from_ref(modifier)).aabb;
        let size = if whole.is_finite() {
            2.0 * whole.half_diagonal()
        } else {
            radius
        };
        // Where the turn ends, a copy on one side is exchanged for one on the other.
        let copies = wrap_copies([from, to], curve, content.aabb);
        return copies.spacing * copies.sides as f32 + size;
    }
    let looked_at = evaluated_copies(modifier, content);
    let is_own = nearest_is_own(modifier, content);
    let takes_all = match *modifier {
        Modifier::Repeat { spacing, count } => (0..3).all(|axis| match count {
            Some(count) => is_own[axis] || count[axis] == looked_at[axis],
            None => is_own[axis] || spacing[axis] <= 0.0,
        }),
        Modifier::RadialRepeat { count } => is_own[0] || count == looked_at[0],
        _ => true,
    };
    if takes_all {
        return 0.0;
    }
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
    content.max_underestimate.min(width + size)
}

/// Returns the minimum distance of copies that a point does not evaluate, or 0 if it is unknown.
fn isolation(modifier: &Modifier, content: &argil_scene::Extent) -> f32 {
    if let Modifier::Wrap {
        from,
        to,
        radius,
        ref curve,
    } = *modifier
    {
        // Where the distance jumps, the core's border or a copy is this far away.
        let core = wrap_core(radius, content.aabb);
        let copies = wrap_copies([from, to], curve, content.aabb);
        let apart = ((1.0 - abi::WRAP_TRUSTED) * core).min(copies.gap);
        return 0.99 * apart / modifier.stretch(content);
    }
    if !content.aabb.is_finite() || content.aabb.is_empty() {
        return 0.0;
    }
    let (spacing, count) = match *modifier {
        Modifier::Repeat { spacing, count } => (spacing, count),
        Modifier::RadialRepeat { count } => {
            if nearest_is_own(modifier, content)[0] {
                return f32::INFINITY;
            }
            let looked_at = evaluated_copies(modifier, content)[0];
            return radial_isolation(count, looked_at, content.aabb);
        }
        _ => return 0.0,
    };
    let half = content.aabb.min.abs().max(content.aabb.max.abs());
    let looked_at = evaluated_copies(modifier, content);
    let is_own = nearest_is_own(modifier, content);
    (0..3)
        .filter(|&axis| match count {
            _ if is_own[axis] => false,
            Some(count) => count[axis] != looked_at[axis],
            None => spacing[axis] > 0.0,
        })
        .map(|axis| steps_away(looked_at[axis]) * spacing[axis] - half[axis])
        .fold(f32::INFINITY, f32::min)
        * 0.999
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Conservative: of a ring of boxes, those that a point does not look at are no nearer than the isolation; and not much
    /// farther at least.
    #[test]
    fn copies_that_are_not_looked_at_are_isolated() {
        for (count, looked_at, near, width) in [
            (8, 2, 0.44, 0.1),
            (3, 2, 0.2, 0.3),
            (32, 2, 0.6, 0.02),
            (5, 2, 0.05, 0.03),
            (16, 5, 0.3, 0.15),
            (40, 7, 0.3, 0.12),
        ] {
            let content = Aabb::new(
                Vec3::new(near, -0.2, -width),
                Vec3::new(near + 0.3, 0.2, width),
            );
            let isolation = radial_isolation(count, looked_at, content);
            assert!(isolation > 0.0, "{count}");
            let step = TAU / count as f32;
            let mut least = f32::INFINITY;
            for i in 0..200 {
                for k in 0..=100 {
                    let r = 2.0 * near * (i as f32 / 100.0);
                    let angle = 0.5 * step * (k as f32 / 100.0);
                    let side = looked_at / 2;
                    let last = count - (looked_at - 1) / 2;
                    for copy in (side + 1..last).map(|copy| copy as f32) {
                        let turned = angle - copy * step;
                        let p = Vec3::new(r * turned.cos(), 0.0, r * turned.sin());
                        least = least.min(p.distance(p.clamp(content.min, content.max)));
                    }
                }
            }
            assert!(least >= isolation, "{count}: {least} and {isolation}");
            assert!(least <= 2.5 * isolation, "{count}: {least} and {isolation}");
        }
        // A box around the axis, or wider than its sector, tells nothing.
        let around = Aabb::centered(Vec3::ONE);
        assert_eq!(radial_isolation(4, 2, around), 0.0);
        let wide = Aabb::new(Vec3::new(0.1, -0.1, -1.0), Vec3::new(0.2, 0.1, 1.0));
        assert_eq!(radial_isolation(32, 5, wide), 0.0);
    }
}
