//! Textures: patterns and images on surfaces.

use crate::LoadedImage;
use crate::validation::{ValidationError, each, positive, within};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The values of a texture, from 0 to 1 and without a unit.
///
/// Solid patterns fill space. Images and bricks are flat: they are projected along the axes that the surface faces most,
/// and blended (biplanar mapping, Quilez 2020; triplanar mapping, Golus 2017).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Pattern {
    /// Cubes that alternate between 0 and 1. A cube's side is half the texture's size.
    Checker,
    /// Stripes along x and y that alternate in z direction between 0 and 1, with soft sides.
    Stripes,
    /// Smooth random values, with finer ones added.
    Noise {
        /// Number of sizes of detail, each half as large as the one before, from 1 to 8.
        #[serde(default = "octaves")]
        octaves: u32,
    },
    /// Rings around the y axis, with grain.
    Wood,
    /// Veins of 0 between layers of 1.
    Marble,
    /// Rows of bricks, whose joints have 0. A brick is as wide as the texture's size, and half as high.
    Brick,
    /// An image, whose width is the texture's size.
    Image {
        /// Path of the file, from the scene's folder: PNG, JPEG, HDR or EXR.
        path: String,
        /// Number of axes along which it is projected.
        #[serde(default)]
        mapping: Mapping,
        /// The image, once it is loaded.
        #[serde(skip)]
        image: LoadedImage,
    },
}

fn octaves() -> u32 {
    4
}

/// How many axes a flat texture is projected along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mapping {
    /// The two that the surface faces most: sharper.
    #[default]
    Biplanar,
    /// All three: smoother where the surface turns.
    Triplanar,
}

/// What a texture is fixed to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TextureSpace {
    /// The brush: a texture moves, turns, bends and grows with it.
    #[default]
    Brush,
    /// The scene: surfaces move through it.
    World,
}

macro_rules! texture {
    ($(#[$doc:meta])* $name:ident, $value:ty, $low:expr, $high:expr) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(JsonSchema))]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            /// What varies.
            pub pattern: Pattern,
            /// Length after which the pattern repeats, in the unit of its space.
            pub size: f32,
            /// What it is fixed to.
            pub space: TextureSpace,
            /// The value where the pattern is 0.
            pub low: $value,
            /// The value where the pattern is 1.
            pub high: $value,
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    pattern: Pattern::Checker,
                    size: 1.0,
                    space: TextureSpace::Brush,
                    low: $low,
                    high: $high,
                }
            }
        }
    };
}

texture!(
    /// A texture of colors, as linear RGB.
    ColorTexture,
    [f32; 3],
    [0.0; 3],
    [1.0; 3]
);
texture!(
    /// A texture of numbers. An image counts by its luminance.
    ValueTexture,
    f32,
    0.0,
    1.0
);

/// The textures of a material. Each replaces one of the material's values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Textures {
    /// Base color, with components from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color: Option<ColorTexture>,
    /// Roughness, from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<ValueTexture>,
    /// Metalness, from 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metallic: Option<ValueTexture>,
    /// Height of the surface in the scene's unit, from −1000 to 1000. It turns normals, and moves nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bump: Option<ValueTexture>,
}

impl Textures {
    /// Returns whether there is none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the patterns.
    pub fn patterns(&self) -> impl Iterator<Item = &Pattern> {
        let values = [&self.roughness, &self.metallic, &self.bump];
        let values = values.into_iter().flatten().map(|texture| &texture.pattern);
        self.base_color
            .iter()
            .map(|texture| &texture.pattern)
            .chain(values)
    }

    /// Returns the patterns, to change them.
    pub fn patterns_mut(&mut self) -> impl Iterator<Item = &mut Pattern> {
        let values = [&mut self.roughness, &mut self.metallic, &mut self.bump];
        let values = values
            .into_iter()
            .flatten()
            .map(|texture| &mut texture.pattern);
        self.base_color
            .iter_mut()
            .map(|texture| &mut texture.pattern)
            .chain(values)
    }

    pub(crate) fn check(&self) -> Result<(), ValidationError> {
        if let Some(texture) = &self.base_color {
            let inner = || {
                pattern(&texture.pattern, texture.size)?;
                each("low", texture.low, |p, v| within(p, v, 0.0, 1.0))?;
                each("high", texture.high, |p, v| within(p, v, 0.0, 1.0))
            };
            inner().map_err(|fault: ValidationError| fault.within("base_color"))?;
        }
        let values = [
            ("roughness", &self.roughness, [0.0, 1.0]),
            ("metallic", &self.metallic, [0.0, 1.0]),
            ("bump", &self.bump, [-1000.0, 1000.0]),
        ];
        for (name, texture, [least, most]) in values {
            let Some(texture) = texture else { continue };
            let inner = || {
                pattern(&texture.pattern, texture.size)?;
                within("low", texture.low, least, most)?;
                within("high", texture.high, least, most)
            };
            inner().map_err(|fault: ValidationError| fault.within(name))?;
        }
        Ok(())
    }
}

fn pattern(pattern: &Pattern, size: f32) -> Result<(), ValidationError> {
    positive("size", size)?;
    match pattern {
        Pattern::Noise { octaves } => within("pattern.octaves", *octaves, 1, 8),
        Pattern::Image { path, .. } => {
            crate::image_file::check(path).map_err(|fault| fault.within("pattern.path"))
        }
        _ => Ok(()),
    }
}
