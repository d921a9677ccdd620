//! The parts of a scene file, for the schema and for writing. [`super::read`] reads them.

use crate::{BlendProfile, Keyframe, Modifier, MorphRamp, Operator, OperatorKind, Shape};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A brush, which has a shape, or a group, which has brushes.
#[derive(Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Item {
    /// A human-readable name.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Whether it takes part in the solid.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub visible: bool,
    /// Whether editors protect it from changes.
    #[serde(default, skip_serializing_if = "is_default")]
    pub locked: bool,
    /// How it combines with everything before it in its group.
    #[serde(default, skip_serializing_if = "is_default")]
    pub operator: OperatorKind,
    /// Blend radius of the joint, in the scene's unit.
    #[serde(default, skip_serializing_if = "is_positive_zero")]
    pub blend: f32,
    /// Profile of the joint within the blend radius.
    #[serde(default, skip_serializing_if = "is_default")]
    pub profile: BlendProfile,
    /// How far a morph goes, from 0 to 1.
    #[serde(default, skip_serializing_if = "is_positive_zero")]
    pub amount: f32,
    /// Where a morph goes how far: the amount is multiplied by the value of a ramp.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ramp: Option<Box<MorphRamp>>,
    /// Name of one of the scene's materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Transforms and deformations, applied in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modifiers: Vec<Modifier>,
    /// Values that change with time, in order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
    /// The shape of a brush.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// The contents of a group, in order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brushes: Option<Vec<Item>>,
}

fn yes() -> bool {
    true
}

/// The fields of an item other than `brushes`. Default values are not written.
#[derive(Serialize)]
pub(super) struct Head<'a> {
    #[serde(skip_serializing_if = "str::is_empty")]
    pub name: &'a str,
    #[serde(skip_serializing_if = "Clone::clone")]
    pub visible: bool,
    #[serde(skip_serializing_if = "is_default")]
    pub locked: bool,
    #[serde(skip_serializing_if = "is_default")]
    pub operator: OperatorKind,
    #[serde(skip_serializing_if = "is_positive_zero")]
    pub blend: f32,
    #[serde(skip_serializing_if = "is_default")]
    pub profile: BlendProfile,
    #[serde(skip_serializing_if = "is_positive_zero")]
    pub amount: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ramp: Option<&'a MorphRamp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<&'a str>,
    #[serde(skip_serializing_if = "<[Modifier]>::is_empty")]
    pub modifiers: &'a [Modifier],
    #[serde(skip_serializing_if = "<[Keyframe]>::is_empty")]
    pub keyframes: &'a [Keyframe],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<&'a Shape>,
}

impl<'a> Head<'a> {
    pub(super) fn of(entry: &'a crate::NodeDesc) -> Self {
        let Operator {
            kind,
            blend,
            profile,
            morph_amount: amount,
        } = entry.operator;
        let shape = if let crate::NodeKind::Shape(shape) = &entry.kind {
            Some(shape)
        } else {
            None
        };
        Self {
            name: &entry.name,
            visible: entry.visible,
            locked: entry.locked,
            operator: kind,
            blend,
            profile,
            amount,
            ramp: entry.ramp.as_deref(),
            material: entry.material.as_deref(),
            modifiers: &entry.modifiers,
            keyframes: &entry.keyframes,
            shape,
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Whether a value is +0. The value −0 is written, so that reading it returns the same bits.
fn is_positive_zero(value: &f32) -> bool {
    value.to_bits() == 0
}
