//! Representations of worlds: one file for the options of each, and the list of all.

mod bricks;
mod dense;
mod levels;
mod mesh;
mod mesh_counts;
mod octree;
mod options;
mod voxel_grid;

use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device};
use argil_render::RenderMode;
use argil_volume::{Volume, VoxelGrid};

pub use bricks::BricksOptions;
pub use dense::DenseOptions;
pub use levels::LevelsOptions;
pub use mesh::MeshRenderOptions;
pub use mesh_counts::MeshCounts;
pub use octree::OctreeOptions;
pub use options::BuildTimings;
use options::RepresentationOptions;
pub(crate) use voxel_grid::{clip_box, has_outgrown, sampled_box, updated_grid};

/// Generates [`Representation`] and its conversions from a list.
macro_rules! representations {
    ($($(#[$doc:meta])* $name:ident($options:ident),)*) => {
        /// How a world stores its geometry.
        ///
        /// `From` converts options, such as [`BricksOptions`].
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[non_exhaustive]
        pub enum Representation {
            /// The program itself. Each distance is evaluated when asked.
            #[default]
            Field,
            $($(#[$doc])* $name($options),)*
        }

        impl Representation {
            /// Returns all representations with default options and a resolution in voxels along the longest side.
            ///
            /// ```
            /// use argil::Representation;
            /// let names: Vec<&str> = Representation::all(64).iter().map(Representation::name).collect();
            /// assert_eq!(names, ["field", "bricks", "levels", "dense", "octree", "mesh"]);
            /// ```
            pub fn all(resolution: u32) -> Vec<Self> {
                vec![Self::Field, $(Self::$name($options::with_resolution(resolution)),)*]
            }

            /// Returns the name that the command line uses: `field`, `bricks`, and so on.
            pub fn name(&self) -> &'static str {
                match self {
                    Self::Field => "field",
                    $(Self::$name(_) => $options::NAME,)*
                }
            }

            /// Describes the representation in one line.
            pub fn description(&self) -> &'static str {
                match self {
                    Self::Field => "The exact field",
                    $(Self::$name(_) => $options::DESCRIPTION,)*
                }
            }

            /// Whether a render mode works with this representation. Only some have bricks, nodes or levels to show.
            pub fn supports_mode(&self, mode: RenderMode) -> bool {
                match self {
                    _ if !matches!(mode, RenderMode::Bricks | RenderMode::Nodes | RenderMode::Levels) => true,
                    Self::Field => false,
                    $(Self::$name(options) => options.supports_mode(mode),)*
                }
            }

            /// Returns the memory budget in bytes, if one was set.
            pub(crate) fn memory_budget(&self) -> Option<u64> {
                match self {
                    Self::Field => None,
                    $(Self::$name(options) => options.memory_budget(),)*
                }
            }

            /// Returns the options that a volume was built with.
            pub fn of(volume: &Volume) -> Self {
                let mut via = Self::Field;
                $(if let Some(options) = $options::of(volume) {
                    via = Self::$name(options);
                })*
                via
            }

            /// Builds the representation on a device, on a given voxel grid or on the scene's own.
            pub(crate) async fn build(
                &self,
                device: &mut AnyDevice,
                site: &BuildContext<'_>,
                voxel_grid: Option<VoxelGrid>,
            ) -> Result<BuildTimings, BuildError> {
                let stages = match self {
                    Self::Field => {
                        device.clear();
                        Vec::new()
                    }
                    $(Self::$name(options) => options.build_on(device, site, voxel_grid).await?,)*
                };
                Ok(BuildTimings::of_stages(stages))
            }
        }

        $(
            impl From<$options> for Representation {
                fn from(options: $options) -> Self {
                    Self::$name(options)
                }
            }

            impl From<u32> for $options {
                /// Sets the number of voxels along the longest side.
                fn from(resolution: u32) -> Self {
                    Self::with_resolution(resolution)
                }
            }
        )*
    };
}

representations! {
    /// Sparse bricks.
    Bricks(BricksOptions),
    /// Bricks of all sizes.
    Levels(LevelsOptions),
    /// A dense volume in one texture.
    Dense(DenseOptions),
    /// Bricks under an octree.
    Octree(OctreeOptions),
    /// Triangles.
    Mesh(MeshRenderOptions),
}

#[cfg(feature = "clap")]
impl clap::ValueEnum for Representation {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: std::sync::LazyLock<Vec<Representation>> =
            std::sync::LazyLock::new(|| Representation::all(256));
        &ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.name()).help(self.description()))
    }
}
