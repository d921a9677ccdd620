//! How a world is kept: a trait that each representation's options implement, in a file of their own, and the list of them.

mod bricks;
mod dense;
mod lattice;
mod mesh;
mod mesh_kept;
mod octree;
mod options;

use crate::BuildError;
use argil_march::Show;
use argil_volume::{Lattice, Volume};

pub use bricks::BricksOptions;
pub use dense::DenseOptions;
pub(crate) use lattice::{focus, following, found_again};
pub use mesh::MeshViaOptions;
pub(crate) use mesh_kept::{Drawable, Triangulated, triangles};
pub use octree::OctreeOptions;
pub use options::BuildTimes;
use options::Options;
pub(crate) use options::{Kept, Site};

/// What follows of the list of representations.
macro_rules! representations {
    ($($(#[$doc:meta])* $name:ident($options:ident),)*) => {
        /// How a world is kept.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[non_exhaustive]
        pub enum Via {
            /// As it is: every distance is evaluated when it is asked for.
            #[default]
            Field,
            $($(#[$doc])* $name($options),)*
        }

        impl Via {
            /// All of them, with options as they come and so many voxels along the longest side.
            ///
            /// ```
            /// use argil::Via;
            /// let words: Vec<&str> = Via::all(64).iter().map(Via::word).collect();
            /// assert_eq!(words, ["field", "bricks", "dense", "octree", "mesh"]);
            /// ```
            pub fn all(resolution: u32) -> Vec<Self> {
                vec![Self::Field, $(Self::$name($options::at(resolution)),)*]
            }

            /// In a word: `field`, `bricks`, and so on.
            pub fn word(&self) -> &'static str {
                match self {
                    Self::Field => "field",
                    $(Self::$name(_) => $options::WORD,)*
                }
            }

            /// What it is, in a line.
            pub fn about(&self) -> &'static str {
                match self {
                    Self::Field => "The exact field",
                    $(Self::$name(_) => $options::ABOUT,)*
                }
            }

            /// Whether pictures can show that: light, normals and the like always, bricks and nodes of some.
            pub fn shows(&self, show: Show) -> bool {
                match self {
                    _ if !matches!(show, Show::Bricks | Show::Nodes) => true,
                    Self::Field => false,
                    $(Self::$name(options) => options.shows(show),)*
                }
            }

            /// Bytes that it may take, if that was said.
            pub(crate) fn memory_budget(&self) -> Option<u64> {
                match self {
                    Self::Field => None,
                    $(Self::$name(options) => options.memory_budget(),)*
                }
            }

            /// As a volume was built.
            pub fn of(volume: &Volume) -> Self {
                let mut via = Self::Field;
                $(if let Some(options) = $options::of(volume) {
                    via = Self::$name(options);
                })*
                via
            }

            /// Builds it on the engine's device, on a lattice or on the scene's own.
            pub(crate) async fn build(
                &self,
                site: &Site<'_>,
                lattice: Option<Lattice>,
            ) -> Result<(Kept, BuildTimes), BuildError> {
                match self {
                    Self::Field => Ok((Kept::Field, BuildTimes::default())),
                    $(Self::$name(options) => options.build_on(site, lattice).await,)*
                }
            }
        }

        $(
            impl From<$options> for Via {
                fn from(options: $options) -> Self {
                    Self::$name(options)
                }
            }

            impl From<u32> for $options {
                /// So many voxels along the longest side.
                fn from(resolution: u32) -> Self {
                    Self::at(resolution)
                }
            }
        )*
    };
}

representations! {
    /// As sparse bricks.
    Bricks(BricksOptions),
    /// As one texture.
    Dense(DenseOptions),
    /// As bricks under a tree.
    Octree(OctreeOptions),
    /// As triangles.
    Mesh(MeshViaOptions),
}

#[cfg(feature = "clap")]
impl clap::ValueEnum for Via {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: std::sync::LazyLock<Vec<Via>> = std::sync::LazyLock::new(|| Via::all(256));
        &ALL
    }

    fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
        Some(clap::builder::PossibleValue::new(self.word()).help(self.about()))
    }
}
