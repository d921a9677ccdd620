//! The trait that each representation's options implement, and the result of a build.

use super::voxel_grid::voxel_grid_of;
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, StageTimings};
use argil_render::RenderMode;
use argil_volume::{Encoding, RESOLUTION_RANGE, Volume, VoxelGrid};

/// Options of a representation: its name, and how a device builds it.
pub(crate) trait RepresentationOptions: Copy + Default {
    /// The name that the command line uses.
    const NAME: &'static str;
    /// A description in one line.
    const DESCRIPTION: &'static str;
    /// Whether voxels are counted from the world's origin, so that the grid can grow.
    const IS_UNBOUNDED: bool = false;
    /// Maximum voxels along the longest side.
    const MAX_RESOLUTION: u32 = *RESOLUTION_RANGE.end();

    /// Creates options with a number of voxels along the longest side.
    fn with_resolution(resolution: u32) -> Self;

    /// Returns the voxels along the longest side.
    fn resolution(&self) -> u32;

    /// Returns the edge of a voxel in the scene's unit, if it replaces the resolution.
    fn voxel_size(&self) -> Option<f32> {
        None
    }

    /// Returns the memory budget in bytes.
    fn memory_budget(&self) -> Option<u64> {
        None
    }

    /// Whether a render mode works with this representation.
    fn supports_mode(&self, _show: RenderMode) -> bool {
        false
    }

    /// Returns the options that a volume was built with, if it is of this kind.
    fn of(volume: &Volume) -> Option<Self>;

    /// Builds the representation on a voxel grid. The device stores it in place of what it stored.
    async fn build(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<StageTimings, BuildError>;

    /// Builds the representation on a given voxel grid, or on the scene's own.
    async fn build_on(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: Option<VoxelGrid>,
    ) -> Result<StageTimings, BuildError> {
        let voxel_grid = match voxel_grid {
            Some(voxel_grid) if Self::IS_UNBOUNDED => voxel_grid,
            Some(voxel_grid) => voxel_grid.with_origin_at_box(),
            None => voxel_grid_of(
                site.scene,
                site.program,
                self.resolution(),
                self.voxel_size(),
                Self::MAX_RESOLUTION,
            )?,
        };
        self.build(device, site, voxel_grid).await
    }
}

/// Timings of a build.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildTimings {
    /// Total duration in milliseconds: from the GPU's timestamps, without compilation, or from the clock on the CPU
    /// and on software GPUs.
    pub duration_ms: f64,
    /// Name and duration of each stage in milliseconds.
    pub stages_ms: Vec<(&'static str, f64)>,
}

impl BuildTimings {
    pub(crate) fn of_stages(stages_ms: StageTimings) -> Self {
        Self {
            duration_ms: stages_ms.iter().map(|(_, ms)| ms).sum(),
            stages_ms,
        }
    }
}

pub(super) fn checked(encoding: Encoding) -> Result<Encoding, BuildError> {
    let voxels = encoding.band.voxels();
    if (0.5..=4096.0).contains(&voxels) {
        Ok(encoding)
    } else {
        Err(BuildError::Band(voxels))
    }
}
