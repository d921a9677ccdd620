//! Lights, what surrounds a scene, fog, and how a picture is developed.

use crate::LoadedImage;
use crate::validation::{ValidationError, coordinate, each, not_negative, positive, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The most lights of a scene.
pub const MAX_LIGHTS: usize = 256;

/// The most light of any source, per color.
const MAX_LIGHT: f32 = 1e6;

/// A source of light. Colors are linear RGB, and may exceed 1. Lights are seen, and hide nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Light {
    /// A disc infinitely far away.
    Sun {
        /// Direction to its middle, as azimuth and elevation in degrees.
        direction_degrees: [f32; 2],
        /// Light on a surface that faces it.
        irradiance: [f32; 3],
        /// Angle between its sides in degrees, from 0.01 to 180. The larger, the softer the shadows.
        #[serde(default = "sun_angle")]
        angle_degrees: f32,
    },
    /// A sphere that shines in all directions.
    Point {
        /// Its center, in the scene's unit.
        at: [f32; 3],
        /// Light per solid angle. A surface at distance d that faces it receives this over d².
        intensity: [f32; 3],
        /// Its radius. The larger, the softer the shadows. A sphere of radius 0 is not seen.
        #[serde(default)]
        radius: f32,
    },
    /// A point light that shines into a cone.
    Spot {
        /// Its center, in the scene's unit.
        at: [f32; 3],
        /// The point that it shines at.
        target: [f32; 3],
        /// Light per solid angle along its axis.
        intensity: [f32; 3],
        /// Angle between the cone's sides in degrees, from 0.1 to 180.
        #[serde(default = "cone_angle")]
        angle_degrees: f32,
        /// The part of the cone over which light fades toward its side, from 0 to 1.
        #[serde(default = "cone_fade")]
        fade: f32,
        /// Its radius. The larger, the softer the shadows.
        #[serde(default)]
        radius: f32,
    },
    /// A rectangle that shines on the side of a point.
    Area {
        /// Its center, in the scene's unit.
        at: [f32; 3],
        /// The point that it shines at.
        target: [f32; 3],
        /// Width and height.
        size: [f32; 2],
        /// Light per area and solid angle: how bright the rectangle is seen.
        radiance: [f32; 3],
    },
}

fn sun_angle() -> f32 {
    0.53
}

fn cone_angle() -> f32 {
    60.0
}

fn cone_fade() -> f32 {
    0.2
}

impl Light {
    fn check(&self) -> Result<(), ValidationError> {
        let light = |path: &str, value| each(path, value, |p, v| within(p, v, 0.0, MAX_LIGHT));
        let aimed = |at: [f32; 3], target: [f32; 3]| {
            each("at", at, coordinate)?;
            each("target", target, coordinate)?;
            let reason = "the light is at the point that it shines at: move one of them";
            match at == target {
                true => Err(ValidationError::new("target", reason)),
                false => Ok(()),
            }
        };
        match *self {
            Self::Sun {
                direction_degrees,
                irradiance,
                angle_degrees,
            } => {
                each("direction_degrees", direction_degrees, coordinate)?;
                light("irradiance", irradiance)?;
                within("angle_degrees", angle_degrees, 0.01, 180.0)
            }
            Self::Point {
                at,
                intensity,
                radius,
            } => {
                each("at", at, coordinate)?;
                light("intensity", intensity)?;
                not_negative("radius", radius)
            }
            Self::Spot {
                at,
                target,
                intensity,
                angle_degrees,
                fade,
                radius,
            } => {
                aimed(at, target)?;
                light("intensity", intensity)?;
                within("angle_degrees", angle_degrees, 0.1, 180.0)?;
                within("fade", fade, 0.0, 1.0)?;
                not_negative("radius", radius)
            }
            Self::Area {
                at,
                target,
                size,
                radiance,
            } => {
                aimed(at, target)?;
                each("size", size, positive)?;
                light("radiance", radiance)
            }
        }
    }
}

/// Checks lights.
pub(crate) fn check_lights(lights: &[Light]) -> Result<(), ValidationError> {
    if lights.len() > MAX_LIGHTS {
        let count = lights.len();
        let reason = format!(
            "{count} lights are too many: a scene has up to {MAX_LIGHTS}; let materials emit light instead"
        );
        return Err(ValidationError::new("lights", reason));
    }
    for (index, light) in lights.iter().enumerate() {
        let fault = |fault: ValidationError| fault.within(&format!("lights[{index}]"));
        light.check().map_err(fault)?;
    }
    Ok(())
}

/// What is behind everything, and shines from all sides.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Environment {
    /// A blue sky.
    #[default]
    Sky,
    /// The same light from everywhere.
    Color {
        /// How bright it is, as linear RGB.
        radiance: [f32; 3],
    },
    /// An image of all directions: the azimuth is across, from −180° to 180°, and the elevation is upward (equirectangular).
    Image {
        /// Path of the file, from the scene's folder: HDR, EXR, PNG or JPEG.
        path: String,
        /// Turn around the y axis in degrees.
        #[serde(default)]
        turn_degrees: f32,
        /// Factor of its light.
        #[serde(default = "one")]
        strength: f32,
        /// The image, once it is loaded.
        #[serde(skip)]
        image: LoadedImage,
    },
}

fn one() -> f32 {
    1.0
}

impl Environment {
    pub(crate) fn is_sky(&self) -> bool {
        *self == Self::Sky
    }

    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        match self {
            Self::Sky => Ok(()),
            Self::Color { radiance } => {
                each("radiance", *radiance, |p, v| within(p, v, 0.0, MAX_LIGHT))
            }
            Self::Image {
                path,
                turn_degrees,
                strength,
                ..
            } => {
                crate::image_file::check(path).map_err(|fault| fault.within("path"))?;
                coordinate("turn_degrees", *turn_degrees)?;
                within("strength", *strength, 0.0, MAX_LIGHT)
            }
        }
    }
}

/// Fog that thins out upward. Light is scattered in it, so that lights make shafts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Fog {
    /// Share of light that is lost per unit of length at `height` (extinction), from 0 to 1000.
    pub density: f32,
    /// The height at which fog has this density.
    pub height: f32,
    /// How fast it thins out upward: over a length of 1 / `falloff`, to 37 %. 0 for the same density everywhere,
    /// which hides suns and the environment: such fog has no end.
    pub falloff: f32,
    /// Color of the share that is scattered and not absorbed, from 0 to 1.
    pub albedo: [f32; 3],
    /// Whether light is scattered forward (toward 1), backward (toward −1), or in all directions (0). From −0.95 to 0.95.
    pub anisotropy: f32,
}

impl Default for Fog {
    fn default() -> Self {
        Self {
            density: 0.1,
            height: 0.0,
            falloff: 0.5,
            albedo: [0.9, 0.9, 0.9],
            anisotropy: 0.3,
        }
    }
}

impl Fog {
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        within("density", self.density, 0.0, 1000.0)?;
        coordinate("height", self.height)?;
        within("falloff", self.falloff, 0.0, 1000.0)?;
        each("albedo", self.albedo, |p, v| within(p, v, 0.0, 1.0))?;
        within("anisotropy", self.anisotropy, -0.95, 0.95)
    }
}

/// How light becomes the colors of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ToneCurve {
    /// Contrast of film: a fit of the Academy Color Encoding System (Narkowicz 2015).
    #[default]
    Aces,
    /// Soft contrast, whose bright colors turn to white (AgX by Sobotka, as fitted by Wrensch, 2023).
    Agx,
    /// None: light above 1 is cut.
    None,
}

/// How the sky's light is reduced where surfaces are near, in images without paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AmbientOcclusion {
    /// By distances along the normal.
    #[default]
    Normal,
    /// By distances in six directions, which also tell from where light comes: the bent normal. It takes twice as many.
    BentNormal,
}

/// A camera's lens: only what is at one distance is sharp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Radius of the opening, in the scene's unit.
    pub aperture_radius: f32,
    /// Distance of what is sharp, along the view's axis. If it is missing, that of the middle of what is viewed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus_distance: Option<f32>,
}

impl Lens {
    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        not_negative("aperture_radius", self.aperture_radius)?;
        self.focus_distance
            .map_or(Ok(()), |distance| positive("focus_distance", distance))
    }
}
