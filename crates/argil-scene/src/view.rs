use crate::lighting::check_lights;
use crate::validation::{ValidationError, coordinate, each, within};
use crate::{AmbientOcclusion, CameraPath, CameraPose, Environment, Fog, Lens, Light, ToneCurve};
use argil_math::Aabb;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The view of a scene: camera, ground, lights and bounds, and how its picture is developed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct View {
    /// Pose of the camera. If neither it nor `bounds` is given, a camera from there that shows the whole surface.
    pub camera: CameraPose,
    /// Vertical field of view in degrees, from 1 to 170.
    pub field_of_view_degrees: f32,
    /// Whether there is a ground plane under the scene.
    pub ground: bool,
    /// Height of the ground plane. If it is missing, the plane touches the lowest point of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_height: Option<f32>,
    /// Minimum and maximum corner of the box to view. If it is missing, the scene's own box. Volumes of a
    /// scene with an infinite solid, such as a plane, end at this box. They omit brushes outside of it.
    #[serde(alias = "frame", skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Direction to the sun, as azimuth and elevation in degrees.
    pub sun_degrees: [f32; 2],
    /// Lights, up to 256. If they are missing, the sun. Images without paths have the first sun, and up to eight others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<Light>>,
    /// What is behind everything. Images without paths have three colors of an image: from above, from the horizon and from below.
    #[serde(skip_serializing_if = "Environment::is_sky")]
    pub environment: Environment,
    /// Fog around everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fog: Option<Fog>,
    /// The lens of stills. If it is missing, all is sharp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// Exposure in stops, from −20 to 20: each doubles the light.
    #[serde(skip_serializing_if = "is_zero")]
    pub exposure: f32,
    /// How light becomes colors.
    #[serde(skip_serializing_if = "is_default")]
    pub tone: ToneCurve,
    /// How the sky's light is reduced where surfaces are near, in images without paths.
    #[serde(skip_serializing_if = "is_default")]
    pub ambient_occlusion: AmbientOcclusion,
    /// Paths of cameras, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub paths: BTreeMap<String, CameraPath>,
}

impl Default for View {
    fn default() -> Self {
        Self {
            camera: CameraPose::Orbit([30.0, 20.0, 3.6]),
            field_of_view_degrees: 35.0,
            ground: false,
            ground_height: None,
            bounds: None,
            sun_degrees: [60.0, 50.0],
            lights: None,
            environment: Environment::Sky,
            fog: None,
            lens: None,
            exposure: 0.0,
            tone: ToneCurve::Aces,
            ambient_occlusion: AmbientOcclusion::Normal,
            paths: BTreeMap::new(),
        }
    }
}

fn is_zero(value: &f32) -> bool {
    value.to_bits() == 0
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
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
        check_lights(self.lights.as_deref().unwrap_or_default())?;
        self.environment
            .check()
            .map_err(|fault| fault.within("environment"))?;
        self.fog
            .map_or(Ok(()), |fog| fog.check())
            .map_err(|fault| fault.within("fog"))?;
        self.lens
            .map_or(Ok(()), |lens| lens.check())
            .map_err(|fault| fault.within("lens"))?;
        within("exposure", self.exposure, -20.0, 20.0)?;
        if let Some(height) = self.ground_height {
            coordinate("ground_height", height)?;
        }
        for (name, path) in &self.paths {
            path.check()
                .map_err(|fault| fault.within(&format!("paths.{name}")))?;
        }
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
