//! Values of a brush or group that change with time.
//!
//! A keyframe states some of: a translation, a rotation and a scale, which move the solid after its modifiers (scaled first,
//! then turned, then moved), the amount of a morph, and a blend radius. Each is interpolated on its own between the keyframes
//! that state it; before the first and after the last of them it stays. What no keyframe states is the entry's own.

use crate::fault::{Fault, coordinate, not_negative, within};
use crate::{Entry, Modifier, NodeId, Scene};
use glam::{Quat, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a value goes from the keyframe before to this one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Ease {
    /// By equal steps.
    #[default]
    Linear,
    /// Slowly at both ends: `3t² − 2t³`.
    Smooth,
    /// Not at all, until this one is reached.
    Hold,
}

/// A turn about an axis through the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// The axis; any length but 0.
    pub axis: [f32; 3],
    /// The angle. From one keyframe to the next about the same axis it may be more than a full turn.
    pub degrees: f32,
}

/// Values at a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Seconds, later than the keyframe before.
    pub time: f32,
    /// How the values below are reached.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub ease: Ease,
    /// Where the solid is moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<[f32; 3]>,
    /// How it is turned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<Turn>,
    /// How it is scaled, from 1e-4 to 1e4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f32>,
    /// How far a morph goes, from 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amount: Option<f32>,
    /// Blend radius of the joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blend: Option<f32>,
}

fn is_linear(ease: &Ease) -> bool {
    *ease == Ease::Linear
}

/// Most seconds of an animation: a day.
const MOST_SECONDS: f32 = 86_400.0;

impl Keyframe {
    fn check(&self) -> Result<(), Fault> {
        within("time", self.time, 0.0, MOST_SECONDS)?;
        let modifiers = [
            self.translate.map(|by| Modifier::Translate { by }),
            self.rotate.map(rotation),
            self.scale.map(|by| Modifier::Scale { by }),
        ];
        for (modifier, name) in modifiers.iter().zip(["translate", "rotate", "scale"]) {
            if let Some(modifier) = modifier {
                modifier.check().map_err(|fault| fault.within(name))?;
            }
        }
        if let Some(turn) = self.rotate {
            coordinate("rotate.degrees", turn.degrees)?;
        }
        if let Some(amount) = self.amount {
            within("amount", amount, 0.0, 1.0)?;
        }
        if let Some(blend) = self.blend {
            not_negative("blend", blend)?;
        }
        Ok(())
    }
}

/// Whether keyframes can be used; else what cannot.
pub(crate) fn check(keyframes: &[Keyframe]) -> Result<(), Fault> {
    for (i, keyframe) in keyframes.iter().enumerate() {
        let place = format!("keyframes[{i}]");
        keyframe.check().map_err(|fault| fault.within(&place))?;
        if i > 0 && keyframe.time <= keyframes[i - 1].time {
            let text = format!(
                "{} is not later than the keyframe before, {}",
                keyframe.time,
                keyframes[i - 1].time
            );
            return Err(Fault::new("time", text).within(&place));
        }
    }
    Ok(())
}

fn rotation(turn: Turn) -> Modifier {
    let Turn { axis, degrees } = turn;
    Modifier::Rotate { axis, degrees }
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    // Exact at both ends.
    a * (1.0 - t) + b * t
}

/// Between two turns: about a common axis by the angle, else the shortest way.
fn mix_turns(a: Turn, b: Turn, t: f32) -> Turn {
    if a.axis == b.axis {
        let degrees = mix(a.degrees, b.degrees, t);
        return Turn { degrees, ..a };
    }
    if t == 0.0 || t == 1.0 {
        return if t == 0.0 { a } else { b };
    }
    let quaternion = |turn: Turn| {
        let axis = Vec3::from(turn.axis).normalize();
        Quat::from_axis_angle(axis, turn.degrees.to_radians())
    };
    let (axis, angle) = quaternion(a).slerp(quaternion(b), t).to_axis_angle();
    Turn {
        axis: axis.to_array(),
        degrees: angle.to_degrees(),
    }
}

/// A value at a time, of the keyframes that state it.
fn at<T: Copy>(
    keyframes: &[Keyframe],
    time: f32,
    value: impl Fn(&Keyframe) -> Option<T>,
    mix: impl Fn(T, T, f32) -> T,
) -> Option<T> {
    let mut stated = keyframes.iter().filter_map(|k| Some((k, value(k)?)));
    let mut before = stated.next()?;
    for after in std::iter::once(before).chain(stated) {
        if time < after.0.time {
            let t = (time - before.0.time) / (after.0.time - before.0.time);
            let t = match after.0.ease {
                Ease::Linear => t,
                Ease::Smooth => t * t * (3.0 - 2.0 * t),
                Ease::Hold => 0.0,
            };
            // Before the first there is nothing to come from.
            let is_first = std::ptr::eq(before.0, after.0);
            let t = if is_first { 0.0 } else { t };
            return Some(mix(before.1, after.1, t));
        }
        before = after;
    }
    Some(before.1)
}

impl Entry {
    /// The entry as it acts at a time in seconds.
    pub(crate) fn posed(&self, time: f32) -> Self {
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
            posed.operator.amount = amount;
        }
        if let Some(blend) = at(&keys, time, |k| k.blend, mix) {
            posed.operator.blend = blend;
        }
        posed
    }
}

impl Scene {
    /// The time in seconds that the scene stands at: 0 until it is set.
    pub fn time(&self) -> f32 {
        self.time
    }

    /// The last keyframe's time in seconds; `None` of a scene in which nothing moves.
    pub fn duration(&self) -> Option<f32> {
        self.walk()
            .filter_map(|id| self.node(id).entry.keyframes.last())
            .map(|last| last.time)
            .reduce(f32::max)
    }

    /// The scene as it stands, without keyframes.
    pub fn frozen(&self) -> Self {
        let mut frozen = self.clone();
        for node in &mut frozen.nodes {
            if let Some(posed) = node.posed.take() {
                node.entry = *posed;
            }
        }
        frozen.time = 0.0;
        frozen
    }

    /// Let everything with keyframes stand as at a time. What moves becomes a [change](crate::Change) each; it is no step of
    /// the history. A time that is not finite is 0.
    pub fn set_time(&mut self, time: f32) {
        self.time = if time.is_finite() { time } else { 0.0 };
        let moving: Vec<NodeId> = self
            .walk()
            .filter(|&id| !self.node(id).entry.keyframes.is_empty())
            .collect();
        for node in moving {
            let posed = self.node(node).entry.posed(self.time);
            if Some(&posed) != self.node(node).posed.as_deref() {
                self.pose(node, posed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut ball = crate::Brush::new(crate::Shape::sphere(0.1));
        for (time, x) in [(0.0, 0.0), (2.0, 1.0)] {
            ball = ball.keyframe(Keyframe {
                time,
                translate: Some([x, 0.0, 0.0]),
                ..Keyframe::default()
            });
        }
        let node = scene.push(ball).expect("a valid brush").node;
        let own = scene.node(node).acting().clone();
        scene
            .apply(crate::Edit::Remove { node })
            .expect("it is there");
        scene.set_time(1.0);
        assert!(scene.undo());
        let there = scene.node(node).acting();
        assert_ne!(*there, own);
        assert_eq!(
            there.modifiers,
            [Modifier::Translate {
                by: [0.5, 0.0, 0.0]
            }]
        );
        assert_eq!(scene.duration(), Some(2.0));
        assert_eq!(scene.frozen().duration(), None);
    }

    #[test]
    fn turns_about_one_axis_keep_their_rounds() {
        let turn = |axis, degrees| Turn { axis, degrees };
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
