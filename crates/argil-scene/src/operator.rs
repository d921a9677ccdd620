use crate::validation::{ValidationError, not_negative, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a brush or group combines with everything before it in its group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum OperatorKind {
    /// Adds the operand.
    #[default]
    Union,
    /// Cuts the operand out.
    #[doc(alias = "difference")]
    #[doc(alias = "boolean")]
    #[doc(alias = "CSG")]
    Subtract,
    /// Keeps only what lies inside the operand.
    #[doc(alias = "intersection")]
    Intersect,
    /// Keeps the solid, and uses the operand's material where the operand is.
    Paint,
    /// Interpolates the distances toward the operand's.
    Morph,
}

/// The profile of a joint within the blend radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BlendProfile {
    /// A smooth joint: `min(a, b) − max(0, k − |a − b|)² / (4k)`, Inigo Quilez's quadratic polynomial smooth
    /// minimum.
    #[default]
    Smooth,
    /// A flat face across the joint: `min(a, b, (a + b − k) / √2)`, after hg_sdf of the Mercury demo group.
    Chamfer,
}

/// An operator with its blend.
///
/// ```
/// use argil_scene::{Operator, OperatorKind};
/// let cut = Operator { kind: OperatorKind::Subtract, blend: 0.1, ..Operator::default() };
/// assert!(cut.max_outward_offset() == 0.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Operator {
    /// The operation.
    pub kind: OperatorKind,
    /// Blend radius k, in the unit of the operator's own group. 0 makes a hard joint.
    pub blend: f32,
    /// The joint's profile.
    pub profile: BlendProfile,
    /// How far a morph goes, from 0 (no change) to 1 (the operand).
    pub morph_amount: f32,
}

impl Operator {
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        not_negative("blend", self.blend)?;
        within("amount", self.morph_amount, 0.0, 1.0)
    }

    /// Returns the largest distance by which a joint's surface can stand out from both operands.
    pub fn max_outward_offset(&self) -> f32 {
        match (self.kind, self.profile) {
            (OperatorKind::Union, BlendProfile::Smooth) => 0.25 * self.blend,
            (OperatorKind::Union, BlendProfile::Chamfer) => self.blend,
            _ => 0.0,
        }
    }
}
