//! The ways to store and render a scene, and the render modes.

use argil::render::RenderMode;
use argil::{DenseOptions, LevelsOptions, Representation};
use serde::{Deserialize, Serialize};

/// Voxels of the finest level, per voxel of the resolution: levels are that fine only where the camera is near.
const FINEST: u32 = 64;

/// A way to store and render a scene: one of the engine's representations, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Pipeline(&'static str);

impl Pipeline {
    /// Returns all pipelines.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        Representation::all(1).into_iter().map(Self::of)
    }

    /// Returns the exact field, which needs no build.
    pub(crate) fn field() -> Self {
        Self::of(Representation::Field)
    }

    fn of(via: Representation) -> Self {
        Self(via.name())
    }

    /// Returns the label.
    pub(crate) fn label(self) -> String {
        let (first, rest) = self.0.split_at(1);
        first.to_uppercase() + rest
    }

    /// Returns true if it has what a render mode shows.
    pub(crate) fn supports(self, show: RenderMode) -> bool {
        self.via(1).supports_mode(show)
    }

    /// Returns the engine's representation.
    pub(crate) fn via(self, resolution: u32) -> Representation {
        let all = Representation::all(resolution);
        let found = all.into_iter().find(|via| via.name() == self.0);
        match found.unwrap_or_default() {
            Representation::Dense(options) => Representation::Dense(DenseOptions {
                mips: true,
                ..options
            }),
            Representation::Levels(options) => Representation::Levels(LevelsOptions {
                resolution: FINEST * resolution,
                ..options
            }),
            via => via,
        }
    }
}

impl Default for Pipeline {
    fn default() -> Self {
        Self::of(LevelsOptions::default().into())
    }
}

impl Serialize for Pipeline {
    fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(&self.label())
    }
}

/// An unknown name becomes the default.
impl<'de> Deserialize<'de> for Pipeline {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let word = String::deserialize(from)?.to_lowercase();
        let found = Self::all().find(|pipeline| pipeline.0 == word);
        Ok(found.unwrap_or_default())
    }
}

/// Render modes and their labels.
pub(crate) const SHOWS: [(RenderMode, &str); 6] = [
    (RenderMode::Shaded, "Shaded"),
    (RenderMode::Normal, "Normal"),
    (RenderMode::Depth, "Depth"),
    (RenderMode::Heat, "Heat"),
    // A pipeline is also called bricks.
    (RenderMode::Bricks, "Brick colors"),
    (RenderMode::Levels, "Level colors"),
];
