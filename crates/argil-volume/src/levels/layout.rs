use super::page::Page;
use crate::bricks::REGION_VOXELS_LOG2;
use crate::{BrickLayout, BrickSettings, BricksError, VoxelGrid};
use argil_math::Aabb;
use glam::IVec3;

/// Voxels along the longest side of the coarsest level, at most.
const ROOT_VOXELS: u32 = 16;
/// Maximum number of levels: 2²³ voxels, the most that a grid counts, and the coarsest.
pub(crate) const MAX_LEVELS: u32 = 20;

/// The layout of levels of detail.
///
/// A voxel of level L is 2^L times as long as one of level 0. All levels count their voxels from the same corner, so
/// a cell of a level covers 2³ cells of the next finer one.
///
/// ```
/// use argil_volume::{BrickSettings, LevelsLayout, VoxelGrid};
/// use argil_math::Aabb;
/// let grid = VoxelGrid::fitting(Aabb::centered([1.0; 3].into()), None, 1024)?;
/// let layout = LevelsLayout::new(grid, &BrickSettings { brick_size_voxels: 8, ..Default::default() })?;
/// assert_eq!(layout.count(), 7);
/// assert_eq!(layout.level(4).voxel_grid().voxel_size, 16.0 * grid.voxel_size);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelsLayout {
    finest: BrickLayout,
    count: u32,
    /// The largest coordinate at the beginning. Edits that grow the box do not change it.
    farthest: f32,
}

impl LevelsLayout {
    /// Creates the levels of a grid, whose voxels are those of the finest level.
    ///
    /// # Errors
    /// If the brick size or the encoding is not supported. Bricks of levels have 8 voxels per side.
    pub fn new(voxel_grid: VoxelGrid, settings: &BrickSettings) -> Result<Self, BricksError> {
        if settings.brick_size_voxels != 8 {
            return Err(BricksError::LevelBrick(settings.brick_size_voxels));
        }
        let finest = BrickLayout::new(voxel_grid, settings)?;
        let longest = voxel_grid.size.max_element();
        let count = (0..MAX_LEVELS)
            .find(|level| longest.div_ceil(1 << level) <= ROOT_VOXELS)
            .map_or(MAX_LEVELS, |level| level + 1);
        let held = voxel_grid.aabb();
        Ok(Self {
            finest,
            count,
            farthest: held.min.abs().max(held.max.abs()).max_element(),
        })
    }

    pub(super) fn finest(&self) -> &BrickLayout {
        &self.finest
    }

    /// Whether a level's pages are evaluated relative to regions, because `f32` would round coordinates to more than a
    /// thousandth of a voxel.
    pub(super) fn is_wide(&self, level: u32) -> bool {
        let voxel = self.level(level).voxel_grid.voxel_size;
        self.farthest > voxel * (1 << REGION_VOXELS_LOG2) as f32
    }

    /// Returns the number of levels.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the number of the coarsest level.
    pub fn root(&self) -> u32 {
        self.count - 1
    }

    /// Returns the layout of a level. Level 0 is the finest.
    pub fn level(&self, level: u32) -> BrickLayout {
        let grid = &self.finest.voxel_grid;
        let begin = grid.begin >> level;
        let last = (grid.begin + grid.size.as_ivec3() - 1) >> level;
        BrickLayout {
            voxel_grid: VoxelGrid {
                voxel_size: grid.voxel_size * (1u32 << level) as f32,
                begin,
                size: (last - begin + 1).as_uvec3(),
                ..*grid
            },
            ..self.finest
        }
    }

    /// Returns the pages of the coarsest level: the first, and the one after the last.
    pub fn root_pages(&self) -> [IVec3; 2] {
        let root = self.level(self.root());
        [root.first_cell() >> 1, ((root.end_cell() - 1) >> 1) + 1]
    }

    /// Returns the box of a page.
    pub(super) fn page_box(&self, page: &Page) -> Aabb {
        let layout = self.level(page.level);
        let first = 2 * page.place();
        let last = layout.cell_box(first + 1);
        Aabb::new(layout.cell_box(first).min, last.max)
    }

    /// Returns the box that an edit reaches if it changes a page. A point on a page's side belongs to both pages.
    pub(super) fn edited_box(&self, page: &Page) -> Aabb {
        let rounding = 0.01 * self.level(page.level).voxel_grid.voxel_size;
        self.page_box(page).grown(rounding)
    }

    /// Returns the same levels over another box of the same voxels.
    pub(super) fn with_grid(&self, voxel_grid: VoxelGrid) -> Self {
        Self {
            finest: BrickLayout {
                voxel_grid,
                ..self.finest
            },
            ..*self
        }
    }
}
