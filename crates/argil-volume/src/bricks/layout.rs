use super::inner_cell;
use crate::{Band, Encoding, MAX_VOXEL_INDEX, SampleFormat, TooFarError, VoxelGrid};
use argil_abi::BrickBuildUniform;
use argil_field::Program;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3};

/// Minimum distance, in voxels, up to which empty cells store bounds. An edit changes nothing farther away. Rays
/// need 1 to 5 % more look-ups for it, because cones cross most of the empty space first.
const FAR_VOXELS: f32 = 24.0;

/// A typical size of a world, in voxels: see [`BrickLayout::base_length`].
const BASE_VOXELS: f32 = 512.0;

/// Cells along a block's side.
pub const BLOCK_SIDE: u32 = argil_abi::BLOCK_SIDE;

/// Settings of sparse bricks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickSettings {
    /// How distances are stored.
    pub encoding: Encoding,
    /// Voxels along a brick's side: 4, 8 or 16.
    pub brick_size_voxels: u32,
}

impl Default for BrickSettings {
    fn default() -> Self {
        Self {
            encoding: Encoding {
                format: SampleFormat::Snorm16,
                // Twice a brick's side: precise enough, and a ray need not stop in between.
                band: Band::Voxels(16.0),
            },
            brick_size_voxels: 8,
        }
    }
}

/// The reason why bricks cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BricksError {
    /// The brick size is not supported.
    #[error("brick size {0}: sparse bricks take 4, 8 or 16 voxels per side")]
    Brick(u32),
    /// The grid has no voxels, too many, or a corner or voxel size that is no length.
    #[error(
        "the voxel grid must have finite lengths and at least one voxel, and reach at most {MAX_VOXEL_INDEX} voxels from its corner"
    )]
    Grid,
    /// The brick size is not supported by levels of detail.
    #[error("brick size {0}: levels of detail have bricks of 8 voxels per side")]
    LevelBrick(u32),
    /// The band is too narrow to find surfaces.
    #[error(
        "band of {0} voxels: sparse bricks need at least 2, because the surface lies between samples"
    )]
    Band(f32),
    /// The bricks and tables would exceed the memory budget.
    #[error(
        "{bricks} bricks and their tables need up to {} MiB, and the budget is {} MiB: lower the resolution or the bits, or raise the memory budget",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Budget {
        /// Maximum number of bricks.
        bricks: u64,
        /// Bytes that they need.
        needed: u64,
        /// The budget in bytes.
        budget: u64,
    },
    /// The block tables alone would exceed the memory budget.
    #[error(
        "the tables of more than {blocks} blocks need over {} MiB, and the limit is {} MiB: use larger voxels, or raise the memory budget if it sets the limit",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Blocks {
        /// Blocks found so far.
        blocks: u64,
        /// Bytes that their tables need.
        needed: u64,
        /// The budget in bytes.
        budget: u64,
    },
    /// A [`Control`](argil_math::Control) canceled the work.
    #[error("canceled")]
    Cancelled,
    /// The solids are too far apart.
    #[error(transparent)]
    TooFar(#[from] TooFarError),
    /// There would be more samples than can be numbered.
    #[error(
        "{bricks} bricks, and the limit for this brick size is {limit}: lower the resolution or choose larger bricks"
    )]
    TooMany {
        /// Maximum number of bricks.
        bricks: u64,
        /// The limit.
        limit: u64,
    },
}

/// The layout of cells and bricks. Cells are counted from the grid's corner, in both directions.
///
/// Its parts fit each other, as [`BrickLayout::new`] checked. Samplers rely on that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickLayout {
    pub(crate) voxel_grid: VoxelGrid,
    pub(crate) encoding: Encoding,
    pub(crate) brick_size_voxels: u32,
}

impl BrickLayout {
    /// Checks settings for a voxel grid.
    ///
    /// # Errors
    /// If the brick size or the encoding is not supported, or the grid is too large or no grid.
    pub fn new(voxel_grid: VoxelGrid, settings: &BrickSettings) -> Result<Self, BricksError> {
        let brick = settings.brick_size_voxels;
        if ![4, 8, 16].contains(&brick) {
            return Err(BricksError::Brick(brick));
        }
        if !voxel_grid.is_countable() {
            return Err(BricksError::Grid);
        }
        let band = settings.encoding.band_width(&voxel_grid, 0) / voxel_grid.voxel_size;
        if band.is_nan() || band < 2.0 {
            return Err(BricksError::Band(band));
        }
        Ok(Self {
            voxel_grid,
            encoding: settings.encoding,
            brick_size_voxels: brick,
        })
    }

    /// Returns a layout of the same bricks over another grid.
    ///
    /// # Errors
    /// If the grid is too large or no grid.
    pub fn with_grid(&self, voxel_grid: VoxelGrid) -> Result<Self, BricksError> {
        let settings = BrickSettings {
            encoding: self.encoding,
            brick_size_voxels: self.brick_size_voxels,
        };
        Self::new(voxel_grid, &settings)
    }

    /// Returns the voxel grid.
    pub fn voxel_grid(&self) -> &VoxelGrid {
        &self.voxel_grid
    }

    /// Returns how samples are stored.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Returns the number of voxels along a brick's side: 4, 8 or 16.
    pub fn brick_size_voxels(&self) -> u32 {
        self.brick_size_voxels
    }

    /// Returns the first cell that the grid's box touches.
    #[inline]
    pub fn first_cell(&self) -> IVec3 {
        self.voxel_grid
            .begin
            .div_euclid(IVec3::splat(self.brick_size_voxels as i32))
    }

    /// Returns the cell after the last one that the box touches.
    #[inline]
    pub fn end_cell(&self) -> IVec3 {
        let end = self.voxel_grid.begin + self.voxel_grid.size.as_ivec3() - 1;
        end.div_euclid(IVec3::splat(self.brick_size_voxels as i32)) + 1
    }

    /// Returns the number of cells along each axis of the box. The last ones may extend beyond it.
    pub fn size_cells(&self) -> UVec3 {
        (self.end_cell() - self.first_cell()).as_uvec3()
    }

    /// Returns the first block that the box touches, and the one after the last.
    pub fn block_range(&self) -> [IVec3; 2] {
        let side = IVec3::splat(BLOCK_SIDE as i32);
        [
            self.first_cell().div_euclid(side),
            (self.end_cell() - 1).div_euclid(side) + 1,
        ]
    }

    /// Whether a cell may have a brick. A box that clips the solid also clips the bricks.
    #[inline]
    pub fn can_have_brick(&self, cell: IVec3) -> bool {
        !self.voxel_grid.is_clipped
            || (cell.cmpge(self.first_cell()).all() && cell.cmplt(self.end_cell()).all())
    }

    /// Returns a layout with the same voxels that also contains a solid. A clipping box does not grow.
    ///
    /// # Errors
    /// If the solid is too far away.
    pub fn grown_to(&self, solid: Aabb) -> Result<Self, TooFarError> {
        let voxel_grid = self
            .voxel_grid
            .grown_to(solid, self.brick_size_voxels * BLOCK_SIDE)?;
        Ok(Self {
            voxel_grid,
            ..*self
        })
    }

    /// Returns the number of samples of a brick.
    pub fn brick_samples(&self) -> u32 {
        (self.brick_size_voxels + 1).pow(3)
    }

    /// Returns the bytes of a brick's samples.
    pub fn brick_bytes(&self) -> u64 {
        u64::from(self.brick_samples()) * self.encoding.format.bytes() as u64
    }

    /// Checks a number of bricks: their samples are numbered with 32 bits.
    pub(crate) fn check_count(&self, bricks: u64) -> Result<(), BricksError> {
        let limit = u64::from(u32::MAX) / u64::from(self.brick_samples());
        if bricks > limit {
            return Err(BricksError::TooMany { bricks, limit });
        }
        Ok(())
    }

    /// Returns a typical size of the world, which bounds the rounding error of points up to that distance from the
    /// origin. It depends only on voxels, so that a growing world makes the same decisions in its cells.
    pub fn base_length(&self) -> f32 {
        BASE_VOXELS * self.voxel_grid.voxel_size
    }

    /// Returns the largest distance that an empty cell stores.
    pub fn far_length(&self) -> f32 {
        let range = self.encoding.band_width(&self.voxel_grid, 0);
        range.max(FAR_VOXELS * self.voxel_grid.voxel_size)
    }

    /// Returns the edge of a cell, in the scene's unit.
    pub fn cell_length(&self) -> f32 {
        self.brick_size_voxels as f32 * self.voxel_grid.voxel_size
    }

    /// Returns the box of a cell.
    pub fn cell_box(&self, cell: IVec3) -> Aabb {
        let min = self.voxel_grid.corner + cell.as_vec3() * self.cell_length();
        Aabb::new(min, min + self.cell_length())
    }

    /// Returns a box around some cells of a block, one bit each.
    pub(super) fn box_of_cells(&self, first: IVec3, cells: u64) -> Aabb {
        let some = (0..64).filter(|i| cells >> i & 1 != 0);
        some.fold(Aabb::EMPTY, |all, i| {
            all.union(self.cell_box(first + inner_cell(i)))
        })
    }

    /// Returns the cell of a point.
    pub fn cell_of(&self, point: Vec3) -> IVec3 {
        ((point - self.voxel_grid.corner) / self.cell_length())
            .floor()
            .as_ivec3()
    }

    /// Returns the uniform for shaders that build blocks, without the pool and the table. `program` determines the
    /// bounds of distances.
    pub fn build_uniform(&self, program: &Program) -> BrickBuildUniform {
        let voxel_grid = &self.voxel_grid;
        let [low, high] = [self.first_cell(), self.end_cell()];
        BrickBuildUniform {
            corner: voxel_grid.corner.to_array(),
            voxel_size: voxel_grid.voxel_size,
            low_x: low.x,
            low_y: low.y,
            low_z: low.z,
            brick_size_voxels: self.brick_size_voxels,
            high_x: high.x,
            high_y: high.y,
            high_z: high.z,
            is_clipped: u32::from(voxel_grid.is_clipped),
            max_center_distance: self.half_diagonal(1),
            half_diagonal: 0.5 * 3f32.sqrt() * voxel_grid.voxel_size,
            lipschitz: program.lipschitz(),
            far: self.far_length(),
            ..BrickBuildUniform::default()
        }
    }

    /// Returns the box of all blocks.
    pub fn region(&self) -> Aabb {
        let [low, high] = self.block_range().map(|block| {
            let cell = block * BLOCK_SIDE as i32;
            self.voxel_grid.corner + cell.as_vec3() * self.cell_length()
        });
        Aabb::new(low, high)
    }

    /// Returns the center of a cube of `side` cells.
    pub(crate) fn center(&self, cell: IVec3, side: u32) -> Vec3 {
        self.voxel_grid.corner + (cell.as_vec3() + 0.5 * side as f32) * self.cell_length()
    }

    /// Returns half of the diagonal of a cube of `side` cells.
    pub fn half_diagonal(&self, side: u32) -> f32 {
        0.5 * 3f32.sqrt() * side as f32 * self.cell_length()
    }
}
