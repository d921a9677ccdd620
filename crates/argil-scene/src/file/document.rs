//! The parts of a scene file, for the schema and for writing. Reading goes by [`super::read`].

use crate::{BlendProfile, Keyframe, Modifier, Operator, OperatorKind, Shape};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A brush, which has a shape, or a group, which has brushes.
#[derive(Clone, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Item {
    /// A name for people.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Whether it takes part.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub visible: bool,
    /// Whether editors leave it as it is.
    #[serde(default, skip_serializing_if = "is_default")]
    pub locked: bool,
    /// How it acts on what stands above it in its group.
    #[serde(default, skip_serializing_if = "is_default")]
    pub operator: OperatorKind,
    /// Blend radius of the joint.
    #[serde(default, skip_serializing_if = "is_positive_zero")]
    pub blend: f32,
    /// Outline of the joint.
    #[serde(default, skip_serializing_if = "is_default")]
    pub profile: BlendProfile,
    /// How far a morph goes, from 0 to 1.
    #[serde(default, skip_serializing_if = "is_positive_zero")]
    pub amount: f32,
    /// The name of one of the scene's materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Changes of the solid, the first first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modifiers: Vec<Modifier>,
    /// Values that change with time, in its order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
    /// The shape of a brush.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// What a group holds, in order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brushes: Option<Vec<Item>>,
}

fn yes() -> bool {
    true
}

/// The fields of an item other than `brushes`, as a file holds them: defaults are left out.
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

/// −0 is written, so that what is read again is the same bit for bit.
fn is_positive_zero(value: &f32) -> bool {
    value.to_bits() == 0
}
