//! The positions of points among bricks, and the samples around them.

use crate::Texel;
use crate::mip_sampler::unpacked;
use argil_field::LANES;

/// The cells of points, their words, and the positions within them in voxels.
#[derive(Debug)]
pub struct CellLocations {
    /// The cell along each axis.
    pub cell: [[f32; LANES]; 3],
    /// Position from the cell's minimum corner, from 0 to the brick's side.
    pub inner: [[f32; LANES]; 3],
    /// The cell's word.
    pub word: [u32; LANES],
    /// The index of the word.
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

/// The samples at a voxel's corners, two neighbors along x in each word, and a point's position in the voxel.
#[derive(Debug)]
pub struct VoxelSamples {
    pub(crate) pairs: [[u32; LANES]; 4],
    /// The voxel's position in its brick.
    pub voxel: [[f32; LANES]; 3],
    /// Position from the voxel's minimum corner, from 0 to 1.
    pub fraction: [[f32; LANES]; 3],
    /// The index of the voxel's first sample.
    pub(super) start: [u32; LANES],
}

/// For each axis, the next plane of samples beyond the nearest face of a voxel, four each, and 1 if they exist.
#[derive(Debug)]
pub struct NeighborPlanes {
    /// By axis. The lower of the other two axes is fastest.
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
    /// Returns the eight corner codes of a lane, x fastest.
    #[inline(always)]
    pub fn integers<T: Texel>(&self, i: usize) -> [f32; 8] {
        let (a, b) = unpacked::<T>(self.pairs[0][i]);
        let (c, d) = unpacked::<T>(self.pairs[1][i]);
        let (e, f) = unpacked::<T>(self.pairs[2][i]);
        let (g, h) = unpacked::<T>(self.pairs[3][i]);
        [a, b, c, d, e, f, g, h]
    }

    /// Returns the interpolated value of a lane.
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
