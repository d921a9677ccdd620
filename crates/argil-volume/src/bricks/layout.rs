use super::inner_cell;
use crate::{Band, Encoding, SampleFormat, TooFarError, VoxelGrid};
use argil_abi::BrickBuild;
use argil_field::Program;
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3};

/// Voxels up to which cells without a brick tell distances, at least: an edit changes nothing that is farther away. Rays
/// take 1 to 5 in a hundred more look-ups for it, as the cones before them step over most of what is empty.
const FAR_VOXELS: f32 = 24.0;

/// A usual length of a world, in voxels: see [`BrickLayout::base_length`].
const BASE_VOXELS: f32 = 512.0;

/// Cells along a block's side.
pub const BLOCK_SIDE: u32 = argil_abi::BLOCK_SIDE;

/// How to build bricks.
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
                // Twice a brick's side: fine enough, and a ray need not stop in between.
                band: Band::Voxels(16.0),
            },
            brick_size_voxels: 8,
        }
    }
}

/// Why bricks cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BricksError {
    /// No such size.
    #[error("bricks of {0} voxels: a sparse brick's side is 4, 8 or 16")]
    Brick(u32),
    /// A band in which no surface can be found.
    #[error(
        "a band of {0} voxels: sparse bricks need 2 at least, as a surface lies between their samples"
    )]
    Band(f32),
    /// They would take more memory than they may.
    #[error(
        "{bricks} bricks and their tables take up to {} MiB, and the budget is {} MiB: take a smaller resolution, fewer bits, or a larger memory budget",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Budget {
        /// Bricks that there may be.
        bricks: u64,
        /// Bytes that they take.
        needed: u64,
        /// Bytes that they may take.
        budget: u64,
    },
    /// The tables alone would take more memory than they may.
    #[error(
        "more than {blocks} blocks of cells take over {} MiB by themselves, and {} MiB is the most: the surface is too large for voxels of this \
         size; take larger ones, or, where that is less than the machine has, a larger memory budget",
        needed.div_ceil(1 << 20),
        budget >> 20
    )]
    Blocks {
        /// Blocks that were found until then.
        blocks: u64,
        /// Bytes that their tables take.
        needed: u64,
        /// Bytes that they may take.
        budget: u64,
    },
    /// Somebody has [cancelled](argil_math::Control::cancel) it.
    #[error("cancelled")]
    Cancelled,
    /// They are too far apart.
    #[error(transparent)]
    TooFar(#[from] TooFarError),
    /// They have more samples than can be told apart.
    #[error(
        "{bricks} bricks, and there can be {limit} of this size: take a smaller resolution or a larger brick"
    )]
    TooMany {
        /// Bricks that there may be.
        bricks: u64,
        /// Most that there can be.
        limit: u64,
    },
}

/// Where cells and bricks lie. Cells are counted from the lattice's corner, in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickLayout {
    /// Where the voxels lie.
    pub voxel_grid: VoxelGrid,
    /// What samples mean.
    pub encoding: Encoding,
    /// Voxels along a brick's side.
    pub brick_size_voxels: u32,
}

impl BrickLayout {
    /// Check what was asked for.
    ///
    /// # Errors
    /// If the brick size or the encoding is not supported, or the grid is too large.
    pub fn new(lattice: VoxelGrid, settings: &BrickSettings) -> Result<Self, BricksError> {
        let brick = settings.brick_size_voxels;
        if ![4, 8, 16].contains(&brick) {
            return Err(BricksError::Brick(brick));
        }
        let band = settings.encoding.band_width(&lattice, 0) / lattice.voxel_size;
        if band.is_nan() || band < 2.0 {
            return Err(BricksError::Band(band));
        }
        Ok(Self {
            voxel_grid: lattice,
            encoding: settings.encoding,
            brick_size_voxels: brick,
        })
    }

    /// The first cell that the lattice's box touches.
    #[inline]
    pub fn low(&self) -> IVec3 {
        self.voxel_grid
            .begin
            .div_euclid(IVec3::splat(self.brick_size_voxels as i32))
    }

    /// The cell behind the last one that it touches.
    #[inline]
    pub fn high(&self) -> IVec3 {
        let end = self.voxel_grid.begin + self.voxel_grid.size.as_ivec3() - 1;
        end.div_euclid(IVec3::splat(self.brick_size_voxels as i32)) + 1
    }

    /// Cells along each axis of the box; the last ones may reach over its sides.
    pub fn grid(&self) -> UVec3 {
        (self.high() - self.low()).as_uvec3()
    }

    /// The first block that the box touches, and the one behind the last.
    pub fn block_range(&self) -> [IVec3; 2] {
        let side = IVec3::splat(BLOCK_SIDE as i32);
        [
            self.low().div_euclid(side),
            (self.high() - 1).div_euclid(side) + 1,
        ]
    }

    /// Whether there may be bricks in a cell: a box that cuts what is solid cuts the bricks.
    #[inline]
    pub fn may_hold(&self, cell: IVec3) -> bool {
        !self.voxel_grid.is_clipped
            || (cell.cmpge(self.low()).all() && cell.cmplt(self.high()).all())
    }

    /// The same voxels over a box that holds a solid too, unless the box cuts what is solid.
    ///
    /// # Errors
    /// If that is farther away than voxels can be counted.
    pub fn grown_to(&self, solid: Aabb) -> Result<Self, TooFarError> {
        let lattice = self
            .voxel_grid
            .grown_to(solid, self.brick_size_voxels * BLOCK_SIDE)?;
        Ok(Self {
            voxel_grid: lattice,
            ..*self
        })
    }

    /// Samples of a brick.
    pub fn brick_samples(&self) -> u32 {
        (self.brick_size_voxels + 1).pow(3)
    }

    /// Bytes of a brick's samples.
    pub fn brick_bytes(&self) -> u64 {
        u64::from(self.brick_samples()) * self.encoding.format.bytes() as u64
    }

    /// Whether so many bricks can be: their samples are counted in 32 bits.
    pub(crate) fn check_count(&self, bricks: u64) -> Result<(), BricksError> {
        let limit = u64::from(u32::MAX) / u64::from(self.brick_samples());
        if bricks > limit {
            return Err(BricksError::TooMany { bricks, limit });
        }
        Ok(())
    }

    /// A usual length of the world: what distances can be off by for rounding is that of points no farther from the origin,
    /// and a little more for those that are. It depends on nothing but voxels, so that a world that grows decides in its
    /// cells as before.
    pub fn base_length(&self) -> f32 {
        BASE_VOXELS * self.voxel_grid.voxel_size
    }

    /// The greatest distance that a cell without a brick tells.
    pub fn far_length(&self) -> f32 {
        let range = self.encoding.band_width(&self.voxel_grid, 0);
        range.max(FAR_VOXELS * self.voxel_grid.voxel_size)
    }

    /// The edge of a cell.
    pub fn cell_length(&self) -> f32 {
        self.brick_size_voxels as f32 * self.voxel_grid.voxel_size
    }

    /// A cell's box.
    pub fn cell_box(&self, cell: IVec3) -> Aabb {
        let min = self.voxel_grid.corner + cell.as_vec3() * self.cell_length();
        Aabb::new(min, min + self.cell_length())
    }

    /// A box around some cells of a block with a first cell: a bit for each.
    pub(super) fn box_of_cells(&self, first: IVec3, cells: u64) -> Aabb {
        let some = (0..64).filter(|i| cells >> i & 1 != 0);
        some.fold(Aabb::EMPTY, |all, i| {
            all.union(self.cell_box(first + inner_cell(i)))
        })
    }

    /// The cell of a point.
    pub fn cell_of(&self, point: Vec3) -> IVec3 {
        ((point - self.voxel_grid.corner) / self.cell_length())
            .floor()
            .as_ivec3()
    }

    /// The uniform that shaders read while they make blocks; the pool, the table and how it is cut up are left to whoever has them. `program` sets
    /// what is known of distances.
    pub fn words(&self, program: &Program) -> BrickBuild {
        let lattice = &self.voxel_grid;
        let terms = program.clearance_model_in(self.base_length());
        let [low, high] = [self.low(), self.high()];
        BrickBuild {
            corner: lattice.corner.to_array(),
            voxel: lattice.voxel_size,
            low_x: low.x,
            low_y: low.y,
            low_z: low.z,
            brick: self.brick_size_voxels,
            high_x: high.x,
            high_y: high.y,
            high_z: high.z,
            is_cut: u32::from(lattice.is_clipped),
            reach: self.half_diagonal(1),
            half_diagonal: 0.5 * 3f32.sqrt() * lattice.voxel_size,
            lipschitz: program.lipschitz(),
            steepness: terms.steepness,
            far: self.far_length(),
            ..BrickBuild::default()
        }
    }

    /// The box of all blocks.
    pub fn region(&self) -> Aabb {
        let [low, high] = self.block_range().map(|block| {
            let cell = block * BLOCK_SIDE as i32;
            self.voxel_grid.corner + cell.as_vec3() * self.cell_length()
        });
        Aabb::new(low, high)
    }

    /// The middle of `side` cells from a cell on.
    pub(crate) fn center(&self, cell: IVec3, side: u32) -> Vec3 {
        self.voxel_grid.corner + (cell.as_vec3() + 0.5 * side as f32) * self.cell_length()
    }

    /// Half of the diagonal of `side` cells.
    pub fn half_diagonal(&self, side: u32) -> f32 {
        0.5 * 3f32.sqrt() * side as f32 * self.cell_length()
    }
}
