use crate::validation::{ValidationError, each, within};
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
}

impl Default for Material {
    fn default() -> Self {
        Self {
            base_color: [0.62, 0.60, 0.57],
            roughness: 0.55,
            metallic: 0.0,
            emission: [0.0; 3],
        }
    }
}

impl Material {
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
        each("emission", self.emission, |p, v| within(p, v, 0.0, 1000.0))
    }
}
