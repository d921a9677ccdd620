//! What is asked of a device, and what it is: the same whether there is one or not.

use std::fmt;

/// What a graphics device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// Graphics in the processor's package.
    Integrated,
    /// A virtual machine's.
    Virtual,
    /// Software on the CPU, such as Mesa's lavapipe.
    Software,
    /// Not known.
    Other,
}

impl DeviceKind {
    /// Whether the automatic choice takes it.
    pub fn is_real_gpu(self) -> bool {
        matches!(self, Self::Discrete | Self::Integrated | Self::Virtual)
    }
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Discrete => "discrete GPU",
            Self::Integrated => "integrated GPU",
            Self::Virtual => "virtual GPU",
            Self::Software => "software",
            Self::Other => "other",
        })
    }
}

/// A graphics device.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: DeviceKind,
    /// The interface it is reached by, such as Vulkan.
    pub backend: String,
    /// The driver and its version.
    pub driver: String,
}

/// How the texture of a dense volume is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum DenseFill {
    /// A tile of 32³ texels a group, a column of 32 a thread.
    #[default]
    Tiled,
    /// The 2023 study's first way: one thread a group, one texel a thread.
    Naive,
}

/// How the list of bricks gets into ascending order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum BrickOrdering {
    /// Bits are set in Morton order, and a prefix sum counts them: nothing is sorted.
    #[default]
    #[cfg_attr(feature = "clap", value(alias = "counted"))]
    PrefixSum,
    /// The 2023 study's enumeration sort of a list in any order.
    #[cfg_attr(feature = "clap", value(alias = "enumerated"))]
    EnumerationSort,
}

/// Where vertices' normals come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceNormals {
    /// They have none.
    None,
    /// The samples' gradient, by central differences.
    Gradient,
    /// The field's, by central differences.
    #[default]
    Field,
    /// The triangles' own; only of corners that are not shared.
    Face,
}

/// How a volume is cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceOptions {
    /// The distance at which the surface is taken.
    pub iso: f32,
    /// Where normals come from.
    pub normals: SurfaceNormals,
    /// Whether vertices go to the exact surface of the field.
    pub project_to_field: bool,
    /// Whether each triangle has corners of its own.
    pub is_unindexed: bool,
}

/// Each stage of a build with its milliseconds.
pub type StageTimings = Vec<(&'static str, f64)>;
