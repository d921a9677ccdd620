//! Values of a brush or group that change with time.
//!
//! A keyframe may set a translation, a rotation and a scale, which move the solid after its modifiers: first scale,
//! then rotation, then translation. It may also set the amount of a morph, and a blend radius. Each value is
//! interpolated between the keyframes that set it, and constant before the first and after the last of them. Other
//! values come from the node.

use crate::Modifier;
use crate::validation::{ValidationError, coordinate, not_negative, within};
use glam::{Quat, Vec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a value moves from the previous keyframe to this one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Ease {
    /// At constant speed.
    #[default]
    Linear,
    /// Slowly at both ends: `3t² − 2t³`.
    Smooth,
    /// It stays, and jumps at this keyframe.
    Hold,
}

/// A rotation about an axis through the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AxisAngle {
    /// The axis, of any length but 0.
    pub axis: [f32; 3],
    /// The angle in degrees. Between two keyframes about the same axis, it may exceed a full turn.
    pub degrees: f32,
}

/// Values at a time.
///
/// ```
/// use argil_scene::{Brush, Keyframe, Scene, Shape};
/// let at = |time, x| Keyframe { time, translate: Some([x, 0.0, 0.0]), ..Keyframe::default() };
/// let brush = Brush::new(Shape::sphere(0.5)).with_keyframe(at(0.0, 0.0)).with_keyframe(at(2.0, 3.0));
/// let mut scene = Scene::new();
/// scene.push(brush)?;
/// scene.set_time(1.0);
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time in seconds, later than the previous keyframe.
    pub time: f32,
    /// How the values reach this keyframe.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub ease: Ease,
    /// Translation of the solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<[f32; 3]>,
    /// Rotation of the solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<AxisAngle>,
    /// Scale of the solid, from 1e-4 to 1e4.
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

/// Maximum length of an animation in seconds: a day.
const MAX_SECONDS: f32 = 86_400.0;

impl Keyframe {
    fn check(&self) -> Result<(), ValidationError> {
        within("time", self.time, 0.0, MAX_SECONDS)?;
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

/// Checks keyframes.
pub(crate) fn check(keyframes: &[Keyframe]) -> Result<(), ValidationError> {
    for (i, keyframe) in keyframes.iter().enumerate() {
        let place = format!("keyframes[{i}]");
        keyframe.check().map_err(|fault| fault.within(&place))?;
        if i > 0 && keyframe.time <= keyframes[i - 1].time {
            let text = format!(
                "{} is not later than the keyframe before, {}",
                keyframe.time,
                keyframes[i - 1].time
            );
            return Err(ValidationError::new("time", text).within(&place));
        }
    }
    Ok(())
}

pub(crate) fn rotation(turn: AxisAngle) -> Modifier {
    let AxisAngle { axis, degrees } = turn;
    Modifier::Rotate { axis, degrees }
}

pub(crate) fn mix(a: f32, b: f32, t: f32) -> f32 {
    // Exact at both ends.
    a * (1.0 - t) + b * t
}

/// Interpolates two rotations: by the angle if they share an axis, else along the shortest path.
pub(crate) fn mix_turns(a: AxisAngle, b: AxisAngle, t: f32) -> AxisAngle {
    if a.axis == b.axis {
        let degrees = mix(a.degrees, b.degrees, t);
        return AxisAngle { degrees, ..a };
    }
    if t == 0.0 || t == 1.0 {
        return if t == 0.0 { a } else { b };
    }
    let quaternion = |turn: AxisAngle| {
        let axis = Vec3::from(turn.axis).normalize();
        Quat::from_axis_angle(axis, turn.degrees.to_radians())
    };
    let (axis, angle) = quaternion(a).slerp(quaternion(b), t).to_axis_angle();
    AxisAngle {
        axis: axis.to_array(),
        degrees: angle.to_degrees(),
    }
}

/// Interpolates a value at a time, from the keyframes that set it.
pub(crate) fn at<T: Copy>(
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
            // Before the first keyframe, there is nothing to come from.
            let is_first = std::ptr::eq(before.0, after.0);
            let t = if is_first { 0.0 } else { t };
            return Some(mix(before.1, after.1, t));
        }
        before = after;
    }
    Some(before.1)
}
