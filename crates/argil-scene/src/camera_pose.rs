//! Poses of cameras.

use crate::validation::{ValidationError, coordinate, each, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Position and direction of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CameraPose {
    /// Azimuth and elevation in degrees, and the distance in multiples of the radius of what is viewed.
    Orbit([f32; 3]),
    /// From a point toward a point.
    #[serde(alias = "look")]
    LookAt {
        /// Position of the camera.
        eye: [f32; 3],
        /// The point in the middle of the image.
        target: [f32; 3],
    },
}

impl CameraPose {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValidationError> {
        match *self {
            Self::Orbit([azimuth, elevation, distance]) => {
                coordinate("orbit[0]", azimuth)?;
                within("orbit[1]", elevation, -90.0, 90.0)?;
                within("orbit[2]", distance, 0.0, 1e4)
            }
            Self::LookAt { eye, target } => {
                each("look_at.eye", eye, coordinate)?;
                each("look_at.target", target, coordinate)?;
                if eye == target {
                    return Err(ValidationError::new(
                        "look_at.target",
                        "eye and target coincide",
                    ));
                }
                Ok(())
            }
        }
    }
}
