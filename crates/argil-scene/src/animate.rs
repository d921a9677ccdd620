//! Evaluates a scene's keyframes.

use crate::keyframe::{at, mix, mix_turns, rotation};
use crate::{Modifier, NodeDesc, NodeId, Scene};

impl NodeDesc {
    /// Returns the description with its keyframed values at a time in seconds.
    pub(crate) fn evaluated_at(&self, time: f32) -> Self {
        let mut posed = self.clone();
        let keys = std::mem::take(&mut posed.keyframes);
        if let Some(by) = at(&keys, time, |k| k.scale, mix) {
            posed.modifiers.push(Modifier::Scale { by });
        }
        if let Some(turn) = at(&keys, time, |k| k.rotate, mix_turns) {
            posed.modifiers.push(rotation(turn));
        }
        let mix_points = |a: [f32; 3], b: [f32; 3], t| std::array::from_fn(|i| mix(a[i], b[i], t));
        if let Some(by) = at(&keys, time, |k| k.translate, mix_points) {
            posed.modifiers.push(Modifier::Translate { by });
        }
        if let Some(amount) = at(&keys, time, |k| k.amount, mix) {
            posed.operator.morph_amount = amount;
        }
        if let Some(blend) = at(&keys, time, |k| k.blend, mix) {
            posed.operator.blend = blend;
        }
        posed
    }
}

impl Scene {
    /// Returns the scene's current time in seconds, initially 0.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// Returns the time of the last keyframe in seconds, or `None` if nothing is animated.
    pub fn duration(&self) -> Option<f32> {
        self.iter()
            .filter_map(|id| self.node(id).desc.keyframes.last())
            .map(|last| last.time)
            .reduce(f32::max)
    }

    /// Returns a copy of the scene at its current time, without keyframes.
    pub fn baked_at_current_time(&self) -> Self {
        let mut frozen = self.clone();
        for i in 0..frozen.nodes.len() {
            if let Some(posed) = &frozen.nodes[i].evaluated {
                let posed = (**posed).clone();
                let node = &mut frozen.nodes[i];
                (node.desc, node.evaluated) = (posed, None);
            }
        }
        frozen.time = 0.0;
        frozen
    }

    /// Sets the scene's time in seconds. Each node that moves becomes a [change](crate::SceneChange), but no undo
    /// step. A time that is not finite counts as 0.
    pub fn set_time(&mut self, time: f32) {
        self.time = if time.is_finite() { time } else { 0.0 };
        let moving: Vec<NodeId> = self
            .iter()
            .filter(|&id| !self.node(id).desc.keyframes.is_empty())
            .collect();
        for node in moving {
            let posed = self.node(node).desc.evaluated_at(self.time);
            if Some(&posed) != self.node(node).evaluated.as_deref() {
                self.pose(node, posed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AxisAngle, Ease, Keyframe};
    use glam::Vec3;

    fn keys(values: &[(f32, f32, Ease)]) -> Vec<Keyframe> {
        let key = |&(time, amount, ease)| Keyframe {
            time,
            ease,
            amount: Some(amount),
            ..Keyframe::default()
        };
        values.iter().map(key).collect()
    }

    #[test]
    fn values_go_from_key_to_key() {
        let keys = keys(&[
            (1.0, 0.0, Ease::Linear),
            (2.0, 1.0, Ease::Linear),
            (3.0, 0.0, Ease::Smooth),
            (4.0, 1.0, Ease::Hold),
        ]);
        let amount = |time| at(&keys, time, |k| k.amount, mix).expect("it is stated");
        let cases = [
            (0.0, 0.0),
            (1.0, 0.0),
            (1.25, 0.25),
            (2.0, 1.0),
            (2.25, 1.0 - 0.15625),
            (3.0, 0.0),
            (3.9, 0.0),
            (4.0, 1.0),
            (9.0, 1.0),
        ];
        for (time, expected) in cases {
            assert!((amount(time) - expected).abs() < 1e-6, "{time}");
        }
        assert_eq!(at(&keys, 1.0, |k| k.scale, mix), None);
    }

    #[test]
    fn what_comes_back_stands_as_at_the_time() {
        let mut scene = Scene::new();
        let mut sphere = crate::Brush::new(crate::Shape::sphere(0.1));
        for (time, x) in [(0.0, 0.0), (2.0, 1.0)] {
            sphere = sphere.with_keyframe(Keyframe {
                time,
                translate: Some([x, 0.0, 0.0]),
                ..Keyframe::default()
            });
        }
        let node = scene.push(sphere).expect("a valid brush").node;
        let before = scene.node(node).at_current_time().clone();
        scene
            .apply(crate::Edit::Remove { node })
            .expect("it is there");
        scene.set_time(1.0);
        assert!(scene.undo().is_some());
        let there = scene.node(node).at_current_time();
        assert_ne!(*there, before);
        assert_eq!(
            there.modifiers,
            [Modifier::Translate {
                by: [0.5, 0.0, 0.0]
            }]
        );
        assert_eq!(scene.duration(), Some(2.0));
        assert_eq!(scene.baked_at_current_time().duration(), None);
    }

    #[test]
    fn turns_about_one_axis_keep_their_rounds() {
        let turn = |axis, degrees| AxisAngle { axis, degrees };
        let y = [0.0, 1.0, 0.0];
        assert_eq!(
            mix_turns(turn(y, 0.0), turn(y, 720.0), 0.5).degrees,
            360.0,
            "two rounds"
        );
        let half = mix_turns(turn([1.0, 0.0, 0.0], 90.0), turn(y, 90.0), 0.5);
        let axis = Vec3::from(half.axis);
        assert!((axis.x - axis.y).abs() < 1e-6 && axis.z.abs() < 1e-6);
    }
}
