//! The layout of an octree's bricks, and the settings of a build.

use crate::{Encoding, VoxelGrid};
use argil_abi::{OCTREE_MAX_DEPTH, OctreeUniform};
use argil_field::Program;
use argil_math::Aabb;
use glam::{UVec3, Vec3};

/// Which bricks to keep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum BrickTest {
    /// All bricks that the surface can pass through.
    #[default]
    Conservative,
    /// Bricks whose center lies within the band: the study's test, which loses some.
    #[cfg_attr(feature = "clap", value(name = "center"))]
    CenterInBand,
}

/// How a GPU orders the bricks of an octree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum BrickOrdering {
    /// Bits are set in Morton order, and a prefix sum counts them: nothing is sorted.
    #[default]
    #[cfg_attr(feature = "clap", value(alias = "counted"))]
    PrefixSum,
    /// The 2023 study's enumeration sort of a list in any order.
    #[cfg_attr(feature = "clap", value(alias = "enumerated"))]
    EnumerationSort,
}

/// Settings of an octree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeSettings {
    /// How distances are stored.
    pub encoding: Encoding,
    /// Voxels along a brick's side: 8, 16 or 32.
    pub brick_size_voxels: u32,
    /// Levels of nodes above the bricks. `None` uses as many as are needed.
    pub depth: Option<u32>,
    /// Which bricks to keep.
    pub brick_test: BrickTest,
}

impl Default for OctreeSettings {
    fn default() -> Self {
        Self {
            encoding: Encoding::default(),
            brick_size_voxels: 32,
            depth: None,
            brick_test: BrickTest::Conservative,
        }
    }
}

/// The reason why an octree cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OctreeError {
    /// The brick size is not supported.
    #[error("brick size {0}: an octree takes bricks of 8, 16 or 32 voxels per side")]
    Brick(u32),
    /// The tree would not cover the volume.
    #[error(
        "{depth} levels of {brick}-voxel bricks cover {reach} voxels, and the volume has {longest}: use {needed} levels",
        reach = u64::from(*brick) << depth
    )]
    Shallow {
        /// Requested levels.
        depth: u32,
        /// Voxels along a brick's side.
        brick: u32,
        /// Voxels along the volume's longest side.
        longest: u32,
        /// Levels that would suffice.
        needed: u32,
    },
    /// Morton codes do not reach that deep.
    #[error(
        "the octree needs {depth} levels, and the limit is {OCTREE_MAX_DEPTH}: choose larger bricks"
    )]
    Deep {
        /// Requested or needed levels.
        depth: u32,
    },
}

/// The number of bricks along each axis, and the levels of nodes above them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeLayout {
    /// The voxel grid.
    pub voxel_grid: VoxelGrid,
    /// How distances are stored.
    pub encoding: Encoding,
    /// Voxels along a brick's side.
    pub brick_size_voxels: u32,
    /// Bricks along each axis. The last ones may extend beyond the volume.
    pub size_bricks: UVec3,
    /// Levels of nodes.
    pub depth: u32,
}

impl OctreeLayout {
    /// Checks settings for a voxel grid.
    ///
    /// # Errors
    /// If the brick size, the depth or the encoding is not supported, or the grid is too large.
    pub fn new(voxel_grid: VoxelGrid, settings: &OctreeSettings) -> Result<Self, OctreeError> {
        let brick = settings.brick_size_voxels;
        if ![8, 16, 32].contains(&brick) {
            return Err(OctreeError::Brick(brick));
        }
        let grid = UVec3::from_array(voxel_grid.size.to_array().map(|n| n.div_ceil(brick)));
        let needed = grid.max_element().next_power_of_two().ilog2().max(1);
        let depth = settings.depth.unwrap_or(needed);
        if depth > OCTREE_MAX_DEPTH {
            return Err(OctreeError::Deep { depth });
        }
        if depth < needed {
            return Err(OctreeError::Shallow {
                depth,
                brick,
                longest: voxel_grid.size.max_element(),
                needed,
            });
        }
        Ok(Self {
            voxel_grid,
            encoding: settings.encoding,
            brick_size_voxels: brick,
            size_bricks: grid,
            depth,
        })
    }

    /// Returns the number of Morton codes of this depth.
    pub fn code_count(&self) -> u32 {
        1 << (3 * self.depth)
    }

    /// Returns the number of bricks that fit into the volume.
    pub fn capacity(&self) -> u64 {
        self.size_bricks.to_array().map(u64::from).iter().product()
    }

    /// Returns the edge of a brick, in the scene's unit.
    pub fn brick_length(&self) -> f32 {
        self.brick_size_voxels as f32 * self.voxel_grid.voxel_size
    }

    /// Returns the box of a brick.
    pub fn brick_box(&self, cell: UVec3) -> Aabb {
        let min = self.voxel_grid.corner + cell.as_vec3() * self.brick_length();
        Aabb::new(min, min + self.brick_length())
    }

    /// Whether a cell contains voxels of the volume.
    pub fn contains_voxels(&self, cell: UVec3) -> bool {
        cell.cmplt(self.size_bricks).all()
    }

    /// Returns the center of a cell, as `select.wgsl` does.
    pub(crate) fn center(&self, cell: UVec3) -> Vec3 {
        let (corner, length) = (self.voxel_grid.corner, self.brick_length());
        corner + (cell.as_vec3() + 0.5) * length
    }

    /// Returns the uniform for shaders. `program` determines how far from the surface a kept brick's center may be.
    pub fn uniform(&self, program: &Program, keep: BrickTest) -> OctreeUniform {
        let voxel_grid = &self.voxel_grid;
        let range = self.encoding.band_width(voxel_grid, 0);
        // Around the brick with half a voxel more on each side, and around its outermost samples.
        let half_diagonal = |voxels: f32| 0.5 * 3f32.sqrt() * voxels * voxel_grid.voxel_size;
        let region = voxel_grid.aabb().grown(self.brick_length());
        let slack = program.bound_error(region);
        let lipschitz = 1.000_01 * program.lipschitz();
        let brick = self.brick_size_voxels as f32;
        OctreeUniform {
            corner: voxel_grid.corner.to_array(),
            band_width: range,
            extent: voxel_grid.extent().to_array(),
            voxel_size: voxel_grid.voxel_size,
            grid_x: self.size_bricks.x,
            grid_y: self.size_bricks.y,
            grid_z: self.size_bricks.z,
            brick_size_voxels: self.brick_size_voxels,
            depth: self.depth,
            code_count: self.code_count(),
            max_center_distance: match keep {
                BrickTest::Conservative => {
                    program.distance_threshold(half_diagonal(brick + 1.0), region)
                }
                BrickTest::CenterInBand => range,
            },
            sample_margin: lipschitz * half_diagonal(brick - 1.0) + slack,
        }
    }
}
