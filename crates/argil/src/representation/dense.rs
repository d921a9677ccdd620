//! Options of dense volumes.

use super::options::{BuildContext, BuildTimings, RepresentationOptions, Storage, checked};
use crate::BuildError;
use crate::memory::check_memory;
use argil_gpu::{DenseFill, GpuVolume};
use argil_volume::{Dense, Encoding, Volume, VoxelGrid};
use web_time::Instant;

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
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<(Storage, BuildTimings), BuildError> {
        let BuildContext {
            engine, program, ..
        } = *site;
        let encoding = checked(self.encoding)?;
        check_memory(
            engine,
            Dense::bytes_of(&voxel_grid, encoding.format, self.mips),
        )?;
        if let Some(field) = site.field {
            let made = GpuVolume::dense(field, program, voxel_grid, encoding, self.mips, self.fill);
            let (volume, stages) = made.await?;
            return Ok((Storage::Gpu(volume), BuildTimings::of_stages(stages)));
        }
        let start = Instant::now();
        let control = &engine.control;
        let dense = Dense::bake_with_control(program, voxel_grid, encoding, self.mips, control);
        let dense = dense.ok_or(BuildError::Cancelled)?;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let times = BuildTimings::of_stages(vec![("fill", ms)]);
        Ok((Storage::Cpu(dense.into()), times))
    }
}
