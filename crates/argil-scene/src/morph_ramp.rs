//! Morphs that go farther in some places than in others.
//!
//! *Theory.* With distances a and b and a ramp t, the result is a + t · (b − a). Its slope is that of a and b, and
//! |b − a| times the ramp's. The difference is clamped, and the result is divided by the bound of its slope.

use crate::ramp::ramp;
use crate::validation::positive;
use crate::{OperatorKind, Ramp, ValidationError};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far the curve may leave the interval from 0 to 1, as easing curves that swing do.
const MAX_OVERSHOOT: f32 = 1.0;

/// Where a morph goes how far: its amount is multiplied by the value of a ramp, in the frame of the surrounding group.
///
/// ```
/// use argil_scene::{Brush, Curve, MorphRamp, Operator, Ramp, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::cylinder(0.5, 1.0))?;
/// let along = Ramp::Line { from: [0.0, -1.0, 0.0], to: [0.0, 1.0, 0.0], curve: Curve::linear() };
/// let ramp = MorphRamp { along, max_difference: 0.3 };
/// scene.push(Brush::new(Shape::cylinder(0.2, 1.0)).morph(1.0).with_ramp(ramp))?;
/// # Ok::<(), argil_scene::EditError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MorphRamp {
    /// The ramp.
    pub along: Ramp,
    /// The difference of the two distances is clamped to this value, in the group's unit. It should be how far the two
    /// surfaces are apart: larger values make distances less exact, and smaller ones change the surface.
    pub max_difference: f32,
}

impl MorphRamp {
    /// Checks the ramp, and that its values fit a morph.
    pub(crate) fn check(&self, kind: OperatorKind) -> Result<(), ValidationError> {
        ramp("ramp.along", &self.along)?;
        positive("ramp.max_difference", self.max_difference)?;
        if kind != OperatorKind::Morph {
            return Err(ValidationError::new("ramp", "only a morph has a ramp"));
        }
        let [low, high] = self.along.curve().range();
        if low < -MAX_OVERSHOOT || high > 1.0 + MAX_OVERSHOOT {
            let reason = format!(
                "the curve goes from {low} to {high}: a morph takes values from {} to {}",
                -MAX_OVERSHOOT,
                1.0 + MAX_OVERSHOOT
            );
            return Err(ValidationError::new("ramp.along", reason));
        }
        Ok(())
    }

    /// Returns the steepness of the result of a morph by `amount`: of the mean of both distances, and what the ramp
    /// adds.
    pub(crate) fn slopes(&self, amount: f32) -> [f32; 2] {
        [
            1.0 + 2.0 * self.beyond(amount),
            amount * self.along.steepness() * self.max_difference,
        ]
    }

    /// Returns the largest distance of the result's surface from the box of both solids.
    pub fn overshoot(&self, amount: f32) -> f32 {
        self.beyond(amount) * self.max_difference
    }

    fn beyond(&self, amount: f32) -> f32 {
        let [low, high] = self.along.curve().range().map(|share| amount * share);
        (-low).max(high - 1.0).max(0.0)
    }
}
