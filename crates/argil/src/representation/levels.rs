//! Options of levels of detail.

use super::options::{RepresentationOptions, checked};
use super::voxel_grid::sampled_box;
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device, StageTimings};
use crate::memory::{budget_on, without_budget};
use argil_field::WORLD_LIMIT;
use argil_render::RenderMode;
use argil_volume::{
    BrickSettings, Levels, LevelsLayout, MAX_SPARSE_RESOLUTION, MAX_VOXEL_INDEX, Volume, VoxelGrid,
};
use web_time::Instant;

/// Voxels of the finest level to the horizon of an infinite scene without bounds.
const HORIZON_VOXELS: i32 = MAX_VOXEL_INDEX / 2;

/// Returns the voxels to the horizon, within the world that programs know.
fn horizon_voxels(grid: &VoxelGrid) -> i32 {
    let room = 0.9 * WORLD_LIMIT - grid.corner.abs().max_element();
    let voxels = (room / grid.voxel_size).clamp(0.0, HORIZON_VOXELS as f32);
    voxels as i32
}

/// Options of levels of detail.
///
/// ```
/// use argil::LevelsOptions;
/// let options = LevelsOptions { voxel_size: Some(0.01), pixel_error: 2.0, ..LevelsOptions::default() };
/// assert_eq!(LevelsOptions::from(131_072).resolution, 131_072);
/// # let _ = options;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelsOptions {
    /// Voxels of the finest level along the longest side of the scene's box.
    pub resolution: u32,
    /// Edge of a voxel of the finest level in the scene's unit, instead of `resolution`.
    pub voxel_size: Option<f32>,
    /// Encoding. Bricks have 8 voxels per side.
    pub settings: BrickSettings,
    /// The size of a voxel that a ray accepts, in pixels, from 0.125 to 1024.
    pub pixel_error: f32,
    /// Maximum bytes of pages, bricks and kept programs. A scene whose own program is long may keep up to three quarters
    /// of its bytes besides.
    pub memory_budget: u64,
}

impl Default for LevelsOptions {
    fn default() -> Self {
        Self {
            resolution: 16_384,
            voxel_size: None,
            settings: BrickSettings::default(),
            pixel_error: 1.0,
            memory_budget: 160 << 20,
        }
    }
}

impl RepresentationOptions for LevelsOptions {
    const NAME: &'static str = "levels";
    const DESCRIPTION: &'static str =
        "Bricks of several voxel sizes, where rays need them, in bounded memory";
    const IS_UNBOUNDED: bool = true;
    const MAX_RESOLUTION: u32 = MAX_SPARSE_RESOLUTION;

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
        Some(self.memory_budget)
    }

    fn supports_mode(&self, show: RenderMode) -> bool {
        matches!(show, RenderMode::Bricks | RenderMode::Levels)
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Levels(levels) = volume else {
            return None;
        };
        let layout = levels.layout().level(0);
        Some(Self {
            resolution: layout.voxel_grid().size.max_element(),
            voxel_size: None,
            settings: BrickSettings {
                encoding: *layout.encoding(),
                brick_size_voxels: layout.brick_size_voxels(),
            },
            pixel_error: levels.pixel_error(),
            memory_budget: levels.budget(),
        })
    }

    async fn build(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<StageTimings, BuildError> {
        checked(self.settings.encoding)?;
        if !(0.125..=1024.0).contains(&self.pixel_error) {
            return Err(BuildError::PixelError(self.pixel_error));
        }
        let start = Instant::now();
        let voxel_grid = match site.scene.view.bounds {
            Some(_) => voxel_grid,
            None => {
                let solid = sampled_box(site.scene, site.program);
                voxel_grid.extended(solid, horizon_voxels(&voxel_grid))
            }
        };
        let layout = LevelsLayout::new(voxel_grid, &self.settings)?;
        let requested = Some(self.memory_budget);
        let budget = budget_on(site.engine, requested).unwrap_or(self.memory_budget);
        let mut levels = Levels::bake(site.program, layout, budget)
            .map_err(|error| without_budget(error.into(), requested))?;
        levels.set_pixel_error(self.pixel_error);
        let stages = vec![("coarsest", start.elapsed().as_secs_f64() * 1e3)];
        device.store_volume(levels.into()).await?;
        Ok(stages)
    }
}
