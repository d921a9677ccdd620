//! What each representation's options say, and what comes of a build.

use super::lattice::lattice_of;
use super::mesh_kept::Drawable;
use crate::{BuildError, Engine, Scene};
use argil_field::Program;
use argil_gpu::{GpuField, GpuVolume};
use argil_march::Show;
use argil_volume::{Encoding, Lattice, Volume};

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
    /// What it is, in a line.
    const ABOUT: &'static str;
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
            None => lattice_of(site.scene, site.program, self.resolution(), self.voxel())?,
        };
        self.build(site, lattice).await
    }
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

pub(super) fn checked(encoding: Encoding) -> Result<Encoding, BuildError> {
    let voxels = encoding.range.voxels();
    if (0.5..=4096.0).contains(&voxels) {
        Ok(encoding)
    } else {
        Err(BuildError::Range(voxels))
    }
}
