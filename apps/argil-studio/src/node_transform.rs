//! A node's transform: the translations, rotations and scales at the end of its modifiers, combined.

use argil::glam::{DQuat, DVec3, Vec3};
use argil::scene::{Modifier, NodeDesc, NodeId, Scene};

/// A transform that scales first, then rotates, then translates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeTransform {
    /// Uniform scale factor.
    pub scale: f64,
    /// Rotation about the origin.
    pub turn: DQuat,
    /// Translation.
    pub shift: DVec3,
}

impl Default for NodeTransform {
    fn default() -> Self {
        Self {
            scale: 1.0,
            turn: DQuat::IDENTITY,
            shift: DVec3::ZERO,
        }
    }
}

impl NodeTransform {
    /// Combines the transforms after the last modifier of another kind.
    pub(crate) fn of(entry: &NodeDesc) -> Self {
        Self::behind(entry, entry.modifiers.len() - own_length(entry))
    }

    /// Combines the transforms after the first `count` modifiers, and skips modifiers of other kinds.
    pub(crate) fn behind(entry: &NodeDesc, count: usize) -> Self {
        let mut pose = Self::default();
        for modifier in entry.modifiers.iter().skip(count) {
            pose.then(modifier);
        }
        pose
    }

    /// Combines a node's keyframes at the current time with the transforms of its groups, and skips modifiers of
    /// other kinds.
    pub(crate) fn around(scene: &Scene, node: NodeId) -> Self {
        let placed = scene.node(node);
        let mut pose = Self::behind(placed.at_current_time(), placed.desc().modifiers.len());
        let mut at = placed.parent();
        while let Some(group) = at {
            for modifier in &scene.node(group).at_current_time().modifiers {
                pose.then(modifier);
            }
            at = scene.node(group).parent();
        }
        pose
    }

    fn then(&mut self, modifier: &Modifier) {
        match *modifier {
            Modifier::Translate { by } => self.shift += Vec3::from(by).as_dvec3(),
            Modifier::Rotate { axis, degrees } => {
                let axis = Vec3::from(axis).as_dvec3().normalize_or(DVec3::Y);
                let turn = DQuat::from_axis_angle(axis, f64::from(degrees).to_radians());
                self.turn = turn * self.turn;
                self.shift = turn * self.shift;
            }
            Modifier::Scale { by } => {
                self.scale *= f64::from(by);
                self.shift *= f64::from(by);
            }
            _ => {}
        }
    }

    /// Replaces a node's transform.
    pub(crate) fn write(&self, entry: &mut NodeDesc) {
        let start = entry.modifiers.len() - own_length(entry);
        entry.modifiers.truncate(start);
        if (self.scale - 1.0).abs() > 1e-6 {
            entry.modifiers.push(Modifier::Scale {
                by: self.scale as f32,
            });
        }
        let (axis, angle) = self.turn.normalize().to_axis_angle();
        let degrees = angle.to_degrees();
        if degrees.abs() > 1e-5 {
            entry.modifiers.push(Modifier::Rotate {
                axis: axis.as_vec3().to_array(),
                degrees: degrees as f32,
            });
        }
        if self.shift.length() > 1e-9 {
            entry.modifiers.push(Modifier::Translate {
                by: self.shift.as_vec3().to_array(),
            });
        }
    }

    /// Transforms a point.
    pub(crate) fn apply(&self, point: DVec3) -> DVec3 {
        self.shift + self.turn * (self.scale * point)
    }

    /// Transforms a point by the inverse.
    pub(crate) fn unapply(&self, point: DVec3) -> DVec3 {
        (self.turn.inverse() * (point - self.shift)) / self.scale
    }

    /// Returns the transform that applies this one and then `outer`.
    pub(crate) fn and(&self, outer: &Self) -> Self {
        Self {
            scale: self.scale * outer.scale,
            turn: (outer.turn * self.turn).normalize(),
            shift: outer.apply(self.shift),
        }
    }

    /// Returns this transform relative to `outer`, so that [`NodeTransform::and`] of both restores it.
    pub(crate) fn within(&self, outer: &Self) -> Self {
        Self {
            scale: self.scale / outer.scale,
            turn: (outer.turn.inverse() * self.turn).normalize(),
            shift: outer.unapply(self.shift),
        }
    }
}

/// Returns the number of transforms at the end of a node's modifiers.
fn own_length(entry: &NodeDesc) -> usize {
    let is_pose = |m: &&Modifier| m.is_similarity();
    entry.modifiers.iter().rev().take_while(is_pose).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil::scene::{Brush, Group, Shape};

    #[test]
    fn a_pose_is_written_as_it_is_read() {
        let entry: NodeDesc = Brush::new(Shape::sphere(1.0))
            .with_modifier(Modifier::Round { radius: 0.1 })
            .at([1.0, 2.0, 3.0])
            .rotated([0.0, 1.0, 1.0], 40.0)
            .scaled(2.0)
            .at([0.0, -1.0, 0.0])
            .into();
        let pose = NodeTransform::of(&entry);
        let mut again = entry.clone();
        pose.write(&mut again);
        assert_eq!(again.modifiers.len(), 4);
        assert_eq!(again.modifiers[0], entry.modifiers[0]);
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(0.3, -2.0, 0.7)] {
            let mut p = point;
            for modifier in &entry.modifiers[1..] {
                let back = modifier.affine().expect("one of three");
                p = back.inverse().transform_point3(p);
            }
            assert!((pose.apply(point) - p).length() < 1e-6);
            assert!((NodeTransform::of(&again).apply(point) - p).length() < 1e-5);
            assert!((pose.unapply(p) - point).length() < 1e-6);
        }
    }

    #[test]
    fn keyframes_are_around_what_they_move() {
        let mut scene = Scene::new();
        let mut entry: NodeDesc = Brush::new(Shape::sphere(1.0)).at([1.0, 0.0, 0.0]).into();
        let key = |time, x| argil::scene::Keyframe {
            time,
            translate: Some([x, 0.0, 0.0]),
            scale: Some(2.0),
            ..Default::default()
        };
        entry.keyframes = vec![key(0.0, 0.0), key(1.0, 4.0)];
        let brush = scene.push(entry).expect("a brush").node;
        for (time, x) in [(0.0, 2.0), (0.5, 4.0), (1.0, 6.0)] {
            scene.set_time(time);
            let inner = NodeTransform::of(scene.node(brush).desc());
            let all = inner.and(&NodeTransform::around(&scene, brush));
            assert!(
                (all.shift - DVec3::new(x, 0.0, 0.0)).length() < 1e-6,
                "{time}"
            );
        }
    }

    #[test]
    fn a_pose_is_that_within_groups() {
        let mut scene = Scene::new();
        let group = Group::new()
            .rotated([0.0, 0.0, 1.0], 90.0)
            .at([5.0, 0.0, 0.0]);
        let group = scene.push(group).expect("a group").node;
        let brush = Brush::new(Shape::sphere(1.0)).at([1.0, 0.0, 0.0]);
        let brush = scene.push_into(group, brush).expect("a brush").node;
        let outer = NodeTransform::around(&scene, brush);
        let inner = NodeTransform::of(scene.node(brush).desc());
        let all = inner.and(&outer);
        assert!((all.shift - DVec3::new(5.0, 1.0, 0.0)).length() < 1e-6);
        assert!((all.within(&outer).shift - inner.shift).length() < 1e-9);
    }
}
