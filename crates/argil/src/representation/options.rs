//! What each representation's options say, and what comes of a build.

use super::mesh_storage::MeshStorage;
use super::voxel_grid::voxel_grid_of;
use crate::{BuildError, Engine};
use argil_field::Program;
use argil_gpu::{GpuProgram, GpuVolume};
use argil_render::RenderMode;
use argil_scene::Scene;
use argil_volume::{Encoding, Volume, VoxelGrid};

/// Where a representation is built: what for, and on which device.
pub(crate) struct BuildContext<'a> {
    pub engine: &'a Engine,
    /// The field on a GPU, if the engine has one.
    pub field: Option<&'a GpuProgram>,
    pub scene: &'a Scene,
    pub program: &'a Program,
}

/// The options of a representation: what it is called, how it lies, and how it is built on either device.
pub(crate) trait RepresentationOptions: Copy + Default {
    /// In a word, as the command says it.
    const NAME: &'static str;
    /// What it is, in a line.
    const DESCRIPTION: &'static str;
    /// Whether voxels are counted from elsewhere than the box's corner, so that the box can grow.
    const IS_UNBOUNDED: bool = false;

    /// With so many voxels along the longest side.
    fn with_resolution(resolution: u32) -> Self;

    /// Voxels along the longest side.
    fn resolution(&self) -> u32;

    /// The edge of a voxel in the scene's unit, in place of that.
    fn voxel_size(&self) -> Option<f32> {
        None
    }

    /// Bytes that it may take.
    fn memory_budget(&self) -> Option<u64> {
        None
    }

    /// Whether there is something to be seen of what pictures show only of some.
    fn supports_mode(&self, _show: RenderMode) -> bool {
        false
    }

    /// As a volume was built, if it is of this kind.
    fn of(volume: &Volume) -> Option<Self>;

    /// Builds it.
    async fn build(
        &self,
        site: &BuildContext<'_>,
        lattice: VoxelGrid,
    ) -> Result<(Storage, BuildTimings), BuildError>;

    /// Builds it on a lattice, or on the scene's own.
    async fn build_on(
        &self,
        site: &BuildContext<'_>,
        lattice: Option<VoxelGrid>,
    ) -> Result<(Storage, BuildTimings), BuildError> {
        let lattice = match lattice {
            Some(lattice) if Self::IS_UNBOUNDED => lattice,
            Some(lattice) => lattice.rebased(),
            None => voxel_grid_of(
                site.scene,
                site.program,
                self.resolution(),
                self.voxel_size(),
            )?,
        };
        self.build(site, lattice).await
    }
}

/// What a build took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildTimings {
    /// In all: on a GPU by its time stamps, compiling apart; on the CPU, or a GPU in software, by the clock.
    pub duration_ms: f64,
    /// By stage.
    pub stages_ms: Vec<(&'static str, f64)>,
}

impl BuildTimings {
    pub(crate) fn of_stages(stages_ms: Vec<(&'static str, f64)>) -> Self {
        Self {
            duration_ms: stages_ms.iter().map(|(_, ms)| ms).sum(),
            stages_ms,
        }
    }
}

/// Where the distances are.
#[derive(Debug)]
pub(crate) enum Storage {
    Field,
    Cpu(Volume),
    Gpu(GpuVolume),
    Mesh(MeshStorage),
}

impl Storage {
    /// Where voxels lie, or lay.
    pub(crate) fn voxel_grid(&self) -> Option<VoxelGrid> {
        match self {
            Self::Field => None,
            Self::Cpu(volume) => Some(*volume.voxel_grid()),
            Self::Gpu(volume) => Some(*volume.lattice()),
            Self::Mesh(drawable) => Some(drawable.lattice),
        }
    }
}

pub(super) fn checked(encoding: Encoding) -> Result<Encoding, BuildError> {
    let voxels = encoding.band.voxels();
    if (0.5..=4096.0).contains(&voxels) {
        Ok(encoding)
    } else {
        Err(BuildError::Range(voxels))
    }
}
