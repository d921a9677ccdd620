use crate::Textures;
use crate::validation::{ValidationError, each, not_negative, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The appearance of a surface, in the metallic–roughness model. Colors are linear RGB.
///
/// ```
/// use argil_scene::Material;
/// let gold = Material { metallic: 1.0, roughness: 0.3, ..Material::colored([1.0, 0.77, 0.34]) };
/// assert!(gold.check().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Color of a dielectric, or reflectance of a metal, with components from 0 to 1.
    pub base_color: [f32; 3],
    /// Roughness, from 0 for a mirror to 1 for chalk.
    pub roughness: f32,
    /// Metalness, from 0 for a dielectric to 1 for a metal.
    pub metallic: f32,
    /// Emitted light, with components from 0 to 1000.
    pub emission: [f32; 3],
    /// Share of light that stills let through a dielectric, from 0 for plaster to 1 for glass.
    #[serde(skip_serializing_if = "is_positive_zero")]
    pub transmission: f32,
    /// Index of refraction of what lets light through, from 1 for air to 4.
    #[serde(skip_serializing_if = "is_default_index")]
    pub refractive_index: f32,
    /// The distance inside of it after which white light has the base color (absorption). 0 to color light at the surface instead.
    #[serde(skip_serializing_if = "is_positive_zero")]
    pub attenuation_distance: f32,
    /// Patterns and images in place of some of these values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub textures: Option<Box<Textures>>,
}

fn is_positive_zero(value: &f32) -> bool {
    value.to_bits() == 0
}

fn is_default_index(value: &f32) -> bool {
    *value == Material::REFRACTIVE_INDEX
}

impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: [0.62, 0.60, 0.57],
            roughness: 0.55,
            metallic: 0.0,
            emission: [0.0; 3],
            transmission: 0.0,
            refractive_index: Self::REFRACTIVE_INDEX,
            attenuation_distance: 0.0,
            textures: None,
        }
    }
}

impl Material {
    /// Index of refraction of window glass.
    pub const REFRACTIVE_INDEX: f32 = 1.5;

    /// Creates a rough dielectric of a color.
    pub fn colored(base_color: [f32; 3]) -> Self {
        Self {
            base_color,
            ..Self::default()
        }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValidationError> {
        each("base_color", self.base_color, |p, v| within(p, v, 0.0, 1.0))?;
        within("roughness", self.roughness, 0.0, 1.0)?;
        within("metallic", self.metallic, 0.0, 1.0)?;
        each("emission", self.emission, |p, v| within(p, v, 0.0, 1000.0))?;
        within("transmission", self.transmission, 0.0, 1.0)?;
        within("refractive_index", self.refractive_index, 1.0, 4.0)?;
        not_negative("attenuation_distance", self.attenuation_distance)?;
        let textures = self.textures.as_ref();
        textures
            .map_or(Ok(()), |textures| textures.check())
            .map_err(|fault| fault.within("textures"))
    }
}
