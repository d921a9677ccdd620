//! Options of octrees.

use super::options::{RepresentationOptions, checked};
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device, StageTimings};
use crate::memory::check_memory;
use argil_render::RenderMode;
use argil_volume::{BrickOrdering, Dense, OctreeLayout, OctreeSettings, Volume, VoxelGrid};

/// Options of an octree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeOptions {
    /// Voxels along the longest side of the scene's box.
    pub resolution: u32,
    /// Brick size, depth and encoding.
    pub settings: OctreeSettings,
    /// How a GPU orders bricks.
    pub order: BrickOrdering,
}

impl Default for OctreeOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            settings: OctreeSettings::default(),
            order: BrickOrdering::default(),
        }
    }
}

impl RepresentationOptions for OctreeOptions {
    const NAME: &'static str = "octree";
    const DESCRIPTION: &'static str =
        "Bricks of distances under a tree: the 2023 study's structure";

    fn with_resolution(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn supports_mode(&self, show: RenderMode) -> bool {
        matches!(show, RenderMode::Bricks | RenderMode::Nodes)
    }

    fn of(volume: &Volume) -> Option<Self> {
        let Volume::Octree(octree) = volume else {
            return None;
        };
        let voxel_grid = octree.layout().voxel_grid;
        let settings = octree.settings();
        // The requested depth, because a larger box may allow a deeper tree.
        let free = OctreeSettings {
            depth: None,
            ..settings
        };
        let is_usual = OctreeLayout::new(voxel_grid, &free)
            .is_ok_and(|layout| Some(layout.depth) == settings.depth);
        Some(Self {
            resolution: voxel_grid.size.max_element(),
            settings: if is_usual { free } else { settings },
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
        let layout = OctreeLayout::new(voxel_grid, &self.settings)?;
        let format = layout.encoding.format;
        let cells = 12 * u64::from(layout.code_count());
        let bytes = Dense::bytes_of(&voxel_grid, format, false) + cells;
        check_memory(site.engine, bytes)?;
        let brick_test = self.settings.brick_test;
        device
            .build_octree(site, layout, brick_test, self.order)
            .await
    }
}
