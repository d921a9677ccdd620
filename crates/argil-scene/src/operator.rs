use crate::validation::{ValidationError, not_negative, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a brush or group acts on what stands above it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum OperatorKind {
    /// Add the operand.
    #[default]
    Union,
    /// Take the operand away.
    Subtract,
    /// Keep only what lies in the operand.
    Intersect,
    /// Keep the solid, take the operand's material where the operand is.
    Paint,
    /// Interpolate the distances towards the operand's.
    Morph,
}

/// The outline of a joint within the blend radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BlendProfile {
    /// `min(a, b) − max(0, k − |a − b|)² / (4k)`, the quadratic polynomial of Inigo Quilez's "smooth minimum".
    #[default]
    Smooth,
    /// A flat face across the joint: `min(a, b, (a + b − k) / √2)`, after the Mercury demo group's hg_sdf.
    Chamfer,
}

/// An operator with its blend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Operator {
    /// What it does.
    pub kind: OperatorKind,
    /// Blend radius k in the unit of the operator's own group; 0 is a hard joint.
    pub blend: f32,
    /// The joint's outline.
    pub profile: BlendProfile,
    /// How far a morph goes, from 0 (stay) to 1 (become the operand).
    pub morph_amount: f32,
}

impl Operator {
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        not_negative("blend", self.blend)?;
        within("amount", self.morph_amount, 0.0, 1.0)
    }

    /// The greatest distance by which a joint's surface can stand out from both of its operands.
    pub fn max_outward_offset(&self) -> f32 {
        match (self.kind, self.profile) {
            (OperatorKind::Union, BlendProfile::Smooth) => 0.25 * self.blend,
            (OperatorKind::Union, BlendProfile::Chamfer) => self.blend,
            _ => 0.0,
        }
    }
}
