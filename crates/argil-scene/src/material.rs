use crate::validation::{ValidationError, each, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a surface looks like, in the terms of the metallic–roughness model. Colors are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Color of a dielectric's body or a metal's reflection, components from 0 to 1.
    pub base_color: [f32; 3],
    /// From 0, a mirror, to 1, chalk.
    pub roughness: f32,
    /// From 0, a dielectric, to 1, a metal.
    pub metallic: f32,
    /// Light given off, components from 0 to 1000.
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
    /// A dull dielectric of a color.
    pub fn colored(base_color: [f32; 3]) -> Self {
        Self {
            base_color,
            ..Self::default()
        }
    }

    /// Whether every value is in its range.
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
