//! Trilinear interpolation between samples, like a linear texture filter that clamps at the border.

use crate::{Encoding, RESOLUTION_RANGE, Texel, VoxelGrid};
use glam::Vec3;

/// A level of a volume, ready to be sampled.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'a, T> {
    texels: &'a [T],
    /// The largest index along each axis.
    last: Vec3,
    /// Distance to the next sample along y and z.
    stride: [usize; 2],
    corner: Vec3,
    texels_per_unit: Vec3,
    /// The distance that one code step means.
    quantum: f32,
}

impl<'a, T: Texel> Sampler<'a, T> {
    /// Creates a sampler of a level. Returns `None` if the number of samples does not match the grid, or a side is
    /// too long.
    pub fn new(
        texels: &'a [T],
        voxel_grid: &VoxelGrid,
        encoding: &Encoding,
        level: u32,
    ) -> Option<Self> {
        let size = voxel_grid.level_size(level);
        // Indices must be exact as `f32`.
        let is_small = voxel_grid.size.max_element() <= *RESOLUTION_RANGE.end();
        if !is_small || texels.is_empty() || texels.len() as u64 != voxel_grid.texel_count(level) {
            return None;
        }
        let [nx, ny, _] = size.to_array().map(|n| n as usize);
        Some(Self {
            texels,
            last: size.as_vec3() - 1.0,
            stride: [nx, nx * ny],
            corner: voxel_grid.corner,
            texels_per_unit: size.as_vec3() / voxel_grid.extent(),
            quantum: encoding.band_width(voxel_grid, level) / encoding.format.max_code() as f32,
        })
    }

    /// Returns the stored distance at a point. Outside the volume, it is that of the nearest point.
    #[inline(always)]
    pub fn distance(&self, p: Vec3) -> f32 {
        let at = |axis: usize| {
            let u = (p[axis] - self.corner[axis]) * self.texels_per_unit[axis] - 0.5;
            // NaN becomes 0.
            let u = if u > 0.0 { u } else { 0.0 };
            let u = if u < self.last[axis] {
                u
            } else {
                self.last[axis]
            };
            // SAFETY: u is from 0 to the greatest index, which is below 2¹³.
            let low: u32 = unsafe { u.to_int_unchecked() };
            let next = usize::from((low as f32) < self.last[axis]);
            (low as usize, next, u - low as f32)
        };
        let ((x, next_x, fx), (y, next_y, fy), (z, next_z, fz)) = (at(0), at(1), at(2));
        let [sy, sz] = self.stride;
        let first = x + y * sy + z * sz;
        let (up, deep) = (next_y * sy, next_z * sz);
        let row = |start: usize| {
            // SAFETY: the indices along each axis are at most the greatest, and `new` has seen that there are as many
            // texels as the sides' product.
            let (a, b) = unsafe {
                (
                    self.texels.get_unchecked(start).code(),
                    self.texels.get_unchecked(start + next_x).code(),
                )
            };
            a + (b - a) * fx
        };
        let (a, b) = (row(first), row(first + up));
        let near = a + (b - a) * fy;
        let (a, b) = (row(first + deep), row(first + deep + up));
        let far = a + (b - a) * fy;
        (near + (far - near) * fz) * self.quantum
    }
}
