//! Options of sparse bricks.

use super::options::{RepresentationOptions, checked};
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device, StageTimings};
use crate::memory::{budget_on, without_budget};
use argil_render::RenderMode;
use argil_volume::{BrickLayout, BrickSettings, Volume, VoxelGrid};

/// Options of sparse bricks.
///
/// ```
/// use argil::BricksOptions;
/// let options = BricksOptions { voxel_size: Some(0.01), ..BricksOptions::default() };
/// assert_eq!(BricksOptions::from(512).resolution, 512);
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BricksOptions {
    /// Voxels along the longest side of the scene's box.
    pub resolution: u32,
    /// Edge of a voxel in the scene's unit, instead of `resolution`.
    pub voxel_size: Option<f32>,
    /// Brick size and encoding.
    pub settings: BrickSettings,
    /// Maximum bytes of bricks and tables. `None` allows what is free.
    pub memory_budget: Option<u64>,
}

impl Default for BricksOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            voxel_size: None,
            settings: BrickSettings::default(),
            memory_budget: None,
        }
    }
}

impl RepresentationOptions for BricksOptions {
    const NAME: &'static str = "bricks";
    const DESCRIPTION: &'static str = "Sparse bricks of distances: Argil's main representation";
    /// Voxels are counted from the world's origin, so the grid can grow.
    const IS_UNBOUNDED: bool = true;

    fn with_resolution(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn voxel_size(&self) -> Option<f32> {
        self.voxel_size
    }

    fn memory_budget(&self) -> Option<u64> {
        self.memory_budget
    }

    fn supports_mode(&self, show: RenderMode) -> bool {
        show == RenderMode::Bricks
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Bricks(bricks) = volume else {
            return None;
        };
        let layout = bricks.layout();
        Some(Self {
            resolution: layout.voxel_grid().size.max_element(),
            settings: BrickSettings {
                encoding: *layout.encoding(),
                brick_size_voxels: layout.brick_size_voxels(),
            },
            ..Self::default()
        })
    }

    async fn build(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<StageTimings, BuildError> {
        checked(self.settings.encoding)?;
        let layout = BrickLayout::new(voxel_grid, &self.settings)?;
        let budget = budget_on(site.engine, self.memory_budget);
        let built = device.build_bricks(site, layout, budget).await;
        built.map_err(|error| without_budget(error, self.memory_budget))
    }
}
