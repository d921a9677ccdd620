//! Where points lie among bricks, and the samples around them.

use crate::Texel;
use crate::mip_sampler::unpacked;
use argil_field::LANES;

/// Where points lie: their cell, its word, and the place in it in voxels.
#[derive(Debug)]
pub struct CellLocations {
    /// The cell's place along each axis.
    pub cell: [[f32; LANES]; 3],
    /// From the cell's least corner, 0 to the brick's side.
    pub inner: [[f32; LANES]; 3],
    /// What is in the cell.
    pub word: [u32; LANES],
    /// Where the word stands.
    pub index: [u32; LANES],
}

impl Default for CellLocations {
    fn default() -> Self {
        Self {
            cell: [[0.0; LANES]; 3],
            inner: [[0.0; LANES]; 3],
            word: [0; LANES],
            index: [0; LANES],
        }
    }
}

/// The samples at a voxel's corners, two neighbors along x in each word, and where in the voxel a point is.
#[derive(Debug)]
pub struct VoxelSamples {
    pub(crate) pairs: [[u32; LANES]; 4],
    /// The voxel's place in its brick.
    pub voxel: [[f32; LANES]; 3],
    /// From the voxel's least corner, 0 to 1.
    pub fraction: [[f32; LANES]; 3],
    /// Where the voxel's first sample stands.
    pub(super) start: [u32; LANES],
}

/// Beyond the face of a voxel that is nearest along each axis: the next plane of samples, four each, and 1 for whether they
/// are there.
#[derive(Debug)]
pub struct NeighborPlanes {
    /// By axis: first along the lower of the other two axes.
    pub plane: [[[f32; LANES]; 4]; 3],
    /// By axis.
    pub is_there: [[f32; LANES]; 3],
}

impl Default for NeighborPlanes {
    fn default() -> Self {
        Self {
            plane: [[[0.0; LANES]; 4]; 3],
            is_there: [[0.0; LANES]; 3],
        }
    }
}

impl Default for VoxelSamples {
    fn default() -> Self {
        Self {
            pairs: [[0; LANES]; 4],
            voxel: [[0.0; LANES]; 3],
            fraction: [[0.0; LANES]; 3],
            start: [0; LANES],
        }
    }
}

impl VoxelSamples {
    /// The eight corners of a lane, x fastest.
    #[inline(always)]
    pub fn integers<T: Texel>(&self, i: usize) -> [f32; 8] {
        let (a, b) = unpacked::<T>(self.pairs[0][i]);
        let (c, d) = unpacked::<T>(self.pairs[1][i]);
        let (e, f) = unpacked::<T>(self.pairs[2][i]);
        let (g, h) = unpacked::<T>(self.pairs[3][i]);
        [a, b, c, d, e, f, g, h]
    }

    /// What is interpolated between a lane's corners.
    #[inline(always)]
    pub fn value<T: Texel>(&self, i: usize) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.integers::<T>(i);
        let (x, y, z) = (
            self.fraction[0][i],
            self.fraction[1][i],
            self.fraction[2][i],
        );
        let (p, q) = (a + (b - a) * x, c + (d - c) * x);
        let (r, s) = (e + (f - e) * x, g + (h - g) * x);
        let (near, far) = (p + (q - p) * y, r + (s - r) * y);
        near + (far - near) * z
    }
}
