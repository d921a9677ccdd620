//! How a world is kept: a trait that each representation's options implement, in a file of their own, and the list of them.

mod bricks;
mod dense;
mod lattice;
mod memory;
mod mesh;
mod octree;

use crate::{BuildError, Engine, Scene};
use argil_field::Program;
use argil_gpu::{GpuField, GpuVolume};
use argil_march::Show;
use argil_volume::{Encoding, Lattice, Volume};

pub use bricks::BricksOptions;
pub use dense::DenseOptions;
pub(crate) use lattice::{focus, following, found_again};
pub(crate) use memory::budget_on;
pub use mesh::MeshViaOptions;
pub(crate) use mesh::{Drawable, Triangulated, triangles};
pub use octree::OctreeOptions;

/// Where a representation is built: what for, and on which device.
pub(crate) struct Site<'a> {
    pub engine: &'a Engine,
    /// The field on a GPU, if the engine has one.
    pub field: Option<&'a GpuField>,
    pub scene: &'a Scene,
    pub program: &'a Program,
}

/// The options of a representation: what it is called, how it lies, and how it is built on either device.
pub(crate) trait Options: Copy + Default {
    /// In a word, as the command says it.
    const WORD: &'static str;
    /// Whether voxels are counted from elsewhere than the box's corner, so that the box can grow.
    const IS_ENDLESS: bool = false;

    /// With so many voxels along the longest side.
    fn at(resolution: u32) -> Self;

    /// Voxels along the longest side.
    fn resolution(&self) -> u32;

    /// The edge of a voxel in the scene's unit, in place of that.
    fn voxel(&self) -> Option<f32> {
        None
    }

    /// Bytes that it may take.
    fn memory_budget(&self) -> Option<u64> {
        None
    }

    /// Whether there is something to be seen of what pictures show only of some.
    fn shows(&self, _show: Show) -> bool {
        false
    }

    /// As a volume was built, if it is of this kind.
    fn of(volume: &Volume) -> Option<Self>;

    /// Builds it.
    async fn build(
        &self,
        site: &Site<'_>,
        lattice: Lattice,
    ) -> Result<(Kept, BuildTimes), BuildError>;

    /// Builds it on a lattice, or on the scene's own.
    async fn build_on(
        &self,
        site: &Site<'_>,
        lattice: Option<Lattice>,
    ) -> Result<(Kept, BuildTimes), BuildError> {
        let lattice = match lattice {
            Some(lattice) if Self::IS_ENDLESS => lattice,
            Some(lattice) => lattice.rebased(),
            None => lattice::lattice_of(site.scene, site.program, self.resolution(), self.voxel())?,
        };
        self.build(site, lattice).await
    }
}

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
            pub(crate) fn of(volume: &Volume) -> Self {
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

/// What a build took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildTimes {
    /// In all: on a GPU by its time stamps, compiling apart; on the CPU, or a GPU in software, by the clock.
    pub duration_ms: f64,
    /// By stage.
    pub stages_ms: Vec<(&'static str, f64)>,
}

impl BuildTimes {
    pub(crate) fn of_stages(stages_ms: Vec<(&'static str, f64)>) -> Self {
        Self {
            duration_ms: stages_ms.iter().map(|(_, ms)| ms).sum(),
            stages_ms,
        }
    }
}

/// Where the distances are.
pub(crate) enum Kept {
    Field,
    Cpu(Volume),
    Gpu(GpuVolume),
    Mesh(Drawable),
}

impl Kept {
    /// Where voxels lie, or lay.
    pub fn lattice(&self) -> Option<Lattice> {
        match self {
            Self::Field => None,
            Self::Cpu(volume) => Some(*volume.lattice()),
            Self::Gpu(volume) => Some(*volume.lattice()),
            Self::Mesh(drawable) => Some(drawable.lattice),
        }
    }
}

fn checked(encoding: Encoding) -> Result<Encoding, BuildError> {
    let voxels = encoding.range.voxels();
    if (0.5..=4096.0).contains(&voxels) {
        Ok(encoding)
    } else {
        Err(BuildError::Range(voxels))
    }
}
