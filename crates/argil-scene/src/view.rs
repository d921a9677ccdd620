use crate::validation::{ValidationError, coordinate, each, within};
use argil_math::Aabb;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The view of a scene: camera, ground, sun and bounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct View {
    /// Pose of the camera.
    pub camera: CameraPose,
    /// Vertical field of view in degrees, from 1 to 170.
    pub field_of_view_degrees: f32,
    /// Whether there is a ground plane under the scene.
    pub ground: bool,
    /// Minimum and maximum corner of the box to view. If it is missing, the scene's own box. Volumes of a
    /// scene with an infinite solid, such as a plane, end at this box. They omit brushes outside of it.
    #[serde(alias = "frame", skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Direction to the sun, as azimuth and elevation in degrees.
    pub sun_degrees: [f32; 2],
}

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

impl Default for View {
    fn default() -> Self {
        Self {
            camera: CameraPose::Orbit([30.0, 20.0, 3.6]),
            field_of_view_degrees: 35.0,
            ground: false,
            bounds: None,
            sun_degrees: [60.0, 50.0],
        }
    }
}

impl View {
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        self.camera.check().map_err(|f| f.within("camera"))?;
        within(
            "field_of_view_degrees",
            self.field_of_view_degrees,
            1.0,
            170.0,
        )?;
        each("sun_degrees", self.sun_degrees, coordinate)?;
        if let Some([min, max]) = self.bounds {
            each("bounds[0]", min, coordinate)?;
            each("bounds[1]", max, coordinate)?;
            let size = Aabb::new(min.into(), max.into()).size();
            if size.min_element() < 0.0 || size.max_element() < 1e-6 {
                return Err(ValidationError::new(
                    "bounds",
                    "the first corner is not below the second",
                ));
            }
        }
        Ok(())
    }
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
