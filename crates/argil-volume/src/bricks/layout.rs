use crate::{Bits, Encoding, Lattice, Range};
use argil_abi::Volume;
use argil_field::Program;
use argil_math::Aabb;
use glam::{UVec3, Vec3};

/// Voxels up to which cells without a brick tell distances, at least: an edit changes nothing that is farther away. Rays
/// take 1 to 5 in a hundred more look-ups for it, as the cones before them step over most of what is empty.
const FAR_VOXELS: f32 = 24.0;

/// Cells along a block's side.
pub const BLOCK_SIDE: u32 = argil_abi::BLOCK_SIDE;

/// How to build bricks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickSettings {
    /// How distances are stored.
    pub encoding: Encoding,
    /// Voxels along a brick's side: 4, 8 or 16.
    pub brick: u32,
}

impl Default for BrickSettings {
    fn default() -> Self {
        Self {
            encoding: Encoding {
                bits: Bits::Sixteen,
                // Twice a brick's side: fine enough, and a ray need not stop in between.
                range: Range::Voxels(16.0),
            },
            brick: 8,
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
        "{bricks} bricks and their tables take up to {} MiB, and the budget is {} MiB: take a smaller resolution, fewer bits, or a larger --memory-budget",
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

/// Where cells and bricks lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrickLayout {
    /// Where the voxels lie.
    pub lattice: Lattice,
    /// What samples mean.
    pub encoding: Encoding,
    /// Voxels along a brick's side.
    pub brick: u32,
    /// Cells along each axis; the last ones may reach over the volume's sides.
    pub grid: UVec3,
    /// Blocks along each axis.
    pub blocks: UVec3,
}

impl BrickLayout {
    /// Check what was asked for.
    pub fn new(lattice: Lattice, settings: &BrickSettings) -> Result<Self, BricksError> {
        let brick = settings.brick;
        if ![4, 8, 16].contains(&brick) {
            return Err(BricksError::Brick(brick));
        }
        let band = settings.encoding.range_length(&lattice, 0) / lattice.voxel;
        if band.is_nan() || band < 2.0 {
            return Err(BricksError::Band(band));
        }
        let grid = UVec3::from_array(lattice.size.to_array().map(|n| n.div_ceil(brick)));
        let blocks = UVec3::from_array(grid.to_array().map(|n| n.div_ceil(BLOCK_SIDE)));
        Ok(Self {
            lattice,
            encoding: settings.encoding,
            brick,
            grid,
            blocks,
        })
    }

    /// Number of blocks.
    pub fn block_count(&self) -> u64 {
        self.blocks.to_array().map(u64::from).iter().product()
    }

    /// Cells that have a word: those of all blocks.
    pub fn word_count(&self) -> u64 {
        64 * self.block_count()
    }

    /// Samples of a brick.
    pub fn brick_samples(&self) -> u32 {
        (self.brick + 1).pow(3)
    }

    /// Bytes of a brick's samples.
    pub fn brick_bytes(&self) -> u64 {
        u64::from(self.brick_samples()) * self.encoding.bits.bytes() as u64
    }

    /// Whether so many bricks can be: their samples are counted in 32 bits.
    pub(crate) fn check_count(&self, bricks: u64) -> Result<(), BricksError> {
        let limit = u64::from(u32::MAX) / u64::from(self.brick_samples());
        if bricks > limit {
            return Err(BricksError::TooMany { bricks, limit });
        }
        Ok(())
    }

    /// Bytes of the tables, without bricks.
    pub fn table_bytes(&self) -> u64 {
        4 * self.word_count() + 8 * self.block_count()
    }

    /// The greatest distance that a cell without a brick tells.
    pub fn far_length(&self) -> f32 {
        let range = self.encoding.range_length(&self.lattice, 0);
        range.max(FAR_VOXELS * self.lattice.voxel)
    }

    /// The edge of a cell.
    pub fn cell_length(&self) -> f32 {
        self.brick as f32 * self.lattice.voxel
    }

    /// A cell's box.
    pub fn cell_box(&self, cell: UVec3) -> Aabb {
        let min = self.lattice.corner + cell.as_vec3() * self.cell_length();
        Aabb::new(min, min + self.cell_length())
    }

    /// Where a cell's word stands.
    #[inline]
    pub fn word_index(&self, cell: UVec3) -> usize {
        let (block, inner) = (cell / BLOCK_SIDE, cell % BLOCK_SIDE);
        let place = block.x + self.blocks.x * (block.y + self.blocks.y * block.z);
        place as usize * 64 + (inner.x + 4 * inner.y + 16 * inner.z) as usize
    }

    /// The cell whose word stands there.
    pub fn cell_at(&self, index: usize) -> UVec3 {
        let (block, inner) = ((index / 64) as u32, (index % 64) as u32);
        let corner = UVec3::new(
            block % self.blocks.x,
            block / self.blocks.x % self.blocks.y,
            block / self.blocks.x / self.blocks.y,
        );
        corner * BLOCK_SIDE + UVec3::new(inner % 4, inner / 4 % 4, inner / 16)
    }

    /// Words for shaders. `program` sets what is known of distances.
    pub fn words(&self, program: &Program) -> Volume {
        let lattice = &self.lattice;
        let [cx, cy, cz] = lattice.corner.to_array();
        let [ex, ey, ez] = lattice.extent().to_array();
        let terms = program.clear_terms(self.region());
        Volume {
            corner_range: [cx, cy, cz, self.encoding.range_length(lattice, 0)],
            extent_voxel: [ex, ey, ez, lattice.voxel],
            size_x: lattice.size.x,
            size_y: lattice.size.y,
            size_z: lattice.size.z,
            levels: 1,
            grid_x: self.grid.x,
            grid_y: self.grid.y,
            grid_z: self.grid.z,
            brick: self.brick,
            code_count: self.word_count() as u32,
            quanta: self.encoding.bits.quanta(),
            reach: self.half_diagonal(1),
            spread: 0.5 * 3f32.sqrt() * lattice.voxel,
            slack: terms.slack,
            hidden: terms.hidden,
            isolation: terms.isolation,
            lipschitz: program.lipschitz(),
            steepness: terms.steepness,
            far: self.far_length(),
            ..Volume::default()
        }
    }

    /// The box of all blocks.
    pub fn region(&self) -> Aabb {
        let end = (self.blocks * BLOCK_SIDE).as_vec3() * self.cell_length();
        Aabb::new(self.lattice.corner, self.lattice.corner + end)
    }

    /// The middle of `side` cells from a cell on.
    pub(crate) fn middle(&self, cell: UVec3, side: u32) -> Vec3 {
        self.lattice.corner + (cell.as_vec3() + 0.5 * side as f32) * self.cell_length()
    }

    /// Half of the diagonal of `side` cells.
    pub fn half_diagonal(&self, side: u32) -> f32 {
        0.5 * 3f32.sqrt() * side as f32 * self.cell_length()
    }
}
