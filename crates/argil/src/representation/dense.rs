//! Options of dense volumes.

use super::options::{RepresentationOptions, checked};
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device, StageTimings};
use crate::memory::check_memory;
use argil_volume::{Dense, DenseFill, Encoding, Volume, VoxelGrid};

/// Options of a dense volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DenseOptions {
    /// Voxels along the longest side of the scene's box.
    pub resolution: u32,
    /// Format and band of samples.
    pub encoding: Encoding,
    /// Whether to build mips, whose band doubles with each level.
    pub mips: bool,
    /// How a GPU fills the texture.
    pub fill: DenseFill,
}

impl Default for DenseOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            encoding: Encoding::default(),
            mips: false,
            fill: DenseFill::default(),
        }
    }
}

impl RepresentationOptions for DenseOptions {
    const NAME: &'static str = "dense";
    const DESCRIPTION: &'static str = "One texture of distances";

    fn with_resolution(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Dense(dense) = volume else {
            return None;
        };
        Some(Self {
            resolution: dense.voxel_grid().size.max_element(),
            encoding: *dense.encoding(),
            mips: dense.levels().len() > 1,
            ..Self::default()
        })
    }

    async fn build(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<StageTimings, BuildError> {
        let encoding = checked(self.encoding)?;
        let bytes = Dense::bytes_of(&voxel_grid, encoding.format, self.mips);
        check_memory(site.engine, bytes)?;
        let built = device.build_dense(site, voxel_grid, encoding, self.mips, self.fill);
        built.await
    }
}
