//! Samples many points at once: the arithmetic of [`Sampler`](crate::Sampler) in plain loops over lanes, which the
//! compiler turns into SIMD.
//!
//! *Practice.* First it computes the addresses for all lanes. Then it loads the samples, two neighbors along x per
//! load. Then all lanes interpolate. Only the loads run lane by lane, and none waits for another.

use crate::{Dense, RESOLUTION_RANGE, SampleFormat, Texel};
use argil_field::LANES;
use std::borrow::Cow;

/// Maximum number of levels.
const MAX_LEVELS: usize = 16;

/// All levels of a dense volume, ready to be sampled in batches.
#[derive(Debug)]
pub struct MipSampler<'a, T: Texel> {
    texels: [Cow<'a, [T]>; MAX_LEVELS],
    /// By level: samples per unit, the largest index, and the largest index with one above it, along each axis.
    per_unit: [[f32; MAX_LEVELS]; 3],
    last: [[f32; MAX_LEVELS]; 3],
    last_pair: [[f32; MAX_LEVELS]; 3],
    /// Distance to the next sample along y and z, or 0 if there is none.
    stride: [[usize; MAX_LEVELS]; 2],
    /// The distance that one code step means.
    quantum: [f32; MAX_LEVELS],
    corner: [f32; 3],
    count: usize,
}

impl<'a, T: Texel> MipSampler<'a, T> {
    /// Creates a sampler. Returns `None` if the samples have another type.
    pub fn new(dense: &'a Dense) -> Option<Self> {
        let (voxel_grid, encoding) = (dense.voxel_grid(), dense.encoding());
        let count = dense.levels().len();
        // Indices must be exact as `f32`.
        if count > MAX_LEVELS || voxel_grid.size.max_element() > *RESOLUTION_RANGE.end() {
            return None;
        }
        let mut all = Self {
            texels: std::array::from_fn(|_| Cow::Borrowed(&[][..])),
            per_unit: [[0.0; MAX_LEVELS]; 3],
            last: [[0.0; MAX_LEVELS]; 3],
            last_pair: [[0.0; MAX_LEVELS]; 3],
            stride: [[0; MAX_LEVELS]; 2],
            quantum: [0.0; MAX_LEVELS],
            corner: voxel_grid.corner.to_array(),
            count,
        };
        for (k, texels) in dense.levels().iter().enumerate() {
            let size = voxel_grid.level_size(k as u32);
            let texels = texels.of::<T>()?;
            if texels.is_empty() || texels.len() as u64 != voxel_grid.texel_count(k as u32) {
                return None;
            }
            // Samples are read in pairs along x, so a single one needs another after it.
            all.texels[k] = if size.x > 1 {
                Cow::Borrowed(texels)
            } else {
                Cow::Owned([texels, &[T::default()]].concat())
            };
            let per_unit = size.as_vec3() / voxel_grid.extent();
            for axis in 0..3 {
                let n = size[axis];
                all.per_unit[axis][k] = per_unit[axis];
                all.last[axis][k] = (n - 1) as f32;
                all.last_pair[axis][k] = n.saturating_sub(2) as f32;
            }
            let [nx, ny, nz] = size.to_array().map(|n| n as usize);
            all.stride[0][k] = if ny > 1 { nx } else { 0 };
            all.stride[1][k] = if nz > 1 { nx * ny } else { 0 };
            all.quantum[k] =
                encoding.band_width(voxel_grid, k as u32) / encoding.format.max_code() as f32;
        }
        Some(all)
    }

    /// Returns the number of levels.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Samples the points `(x[i], y[i], z[i])` on level `level[i]` into `out`.
    ///
    /// # Panics
    /// If a slice is shorter than `out`, if `out` is longer than [`LANES`], or if a level does not exist.
    #[inline(always)]
    pub fn distances(&self, [x, y, z]: [&[f32]; 3], level: &[u32], out: &mut [f32]) {
        let n = out.len();
        assert!(n <= LANES, "at most {LANES} points at once");
        let (x, y, z, level) = (&x[..n], &y[..n], &z[..n], &level[..n]);
        assert!(
            level.iter().all(|&k| (k as usize) < self.count),
            "a level that is there"
        );
        // The index where each sample's cell begins, and the fraction within it.
        let mut low = [[0u32; LANES]; 3];
        let mut f = [[0.0f32; LANES]; 3];
        let place = |p: f32, axis: usize, k: usize| {
            let u = (p - self.corner[axis]) * self.per_unit[axis][k] - 0.5;
            // NaN becomes 0.
            let u = if u > 0.0 { u } else { 0.0 };
            let u = if u < self.last[axis][k] {
                u
            } else {
                self.last[axis][k]
            };
            // SAFETY: u is from 0 to the greatest index, which is below 2¹³.
            let low = unsafe { u.to_int_unchecked::<i32>() } as f32;
            let low = if low < self.last_pair[axis][k] {
                low
            } else {
                self.last_pair[axis][k]
            };
            (low, u - low)
        };
        for i in 0..n {
            let k = level[i] as usize % MAX_LEVELS;
            let (lx, fx) = place(x[i], 0, k);
            let (ly, fy) = place(y[i], 1, k);
            let (lz, fz) = place(z[i], 2, k);
            (f[0][i], f[1][i], f[2][i]) = (fx, fy, fz);
            // SAFETY: whole numbers below 2¹³.
            let whole = |v: f32| unsafe { v.to_int_unchecked::<i32>() } as u32;
            (low[0][i], low[1][i], low[2][i]) = (whole(lx), whole(ly), whole(lz));
        }
        // Four pairs of neighbors along x.
        let mut pairs = [[0u32; LANES]; 4];
        for i in 0..n {
            let k = level[i] as usize % MAX_LEVELS;
            let (texels, [up, deep]) = (&self.texels[k], self.stride.map(|s| s[k]));
            let [lx, ly, lz] = [0, 1, 2].map(|axis: usize| low[axis][i] as usize);
            let begin = lx + ly * up + lz * deep;
            for (pair, step) in pairs.iter_mut().zip([0, up, deep, up + deep]) {
                // SAFETY: `begin` has one texel above it along each axis that has two, strides are 0 along the others, and
                // `new` has seen that there are as many texels as the sides' product.
                pair[i] = unsafe { pair_at(texels, begin + step) };
            }
        }
        // Interpolate.
        for i in 0..n {
            let row = |pair: u32| {
                let (a, b) = unpacked::<T>(pair);
                a + (b - a) * f[0][i]
            };
            let (a, b) = (row(pairs[0][i]), row(pairs[1][i]));
            let near = a + (b - a) * f[1][i];
            let (a, b) = (row(pairs[2][i]), row(pairs[3][i]));
            let far = a + (b - a) * f[1][i];
            let k = level[i] as usize % MAX_LEVELS;
            out[i] = (near + (far - near) * f[2][i]) * self.quantum[k];
        }
    }
}

/// Loads two samples at once.
///
/// # Safety
/// Both must exist. Builds with assertions check it.
#[inline(always)]
pub(crate) unsafe fn pair_at<T: Texel>(texels: &[T], at: usize) -> u32 {
    debug_assert!(
        at < texels.len() && texels.len() - at >= 2,
        "a pair at {at} of {}",
        texels.len()
    );
    // SAFETY: the caller's.
    let at = unsafe { texels.as_ptr().add(at) };
    match T::FORMAT {
        // SAFETY: the caller's; u16 is two texels.
        SampleFormat::Snorm8 => u32::from(unsafe { at.cast::<u16>().read_unaligned() }),
        // SAFETY: the caller's; u32 is two texels.
        SampleFormat::Snorm16 => unsafe { at.cast::<u32>().read_unaligned() },
    }
}

/// Returns the codes of a pair, the first from the low bits.
#[inline(always)]
pub(crate) fn unpacked<T: Texel>(pair: u32) -> (f32, f32) {
    let (low, high) = match T::FORMAT {
        SampleFormat::Snorm8 => ((pair << 24) as i32 >> 24, (pair << 16) as i32 >> 24),
        SampleFormat::Snorm16 => ((pair << 16) as i32 >> 16, pair as i32 >> 16),
    };
    (low as f32, high as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoding, VoxelGrid};
    use argil_field::Program;
    use argil_math::Aabb;
    use argil_scene::{Brush, Scene, Shape};
    use glam::Vec3;

    /// Debug builds check the bounds of unchecked reads: single texels in the standard library, pairs here.
    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "a pair at 3 of 4")]
    fn pairs_that_are_not_there_are_noticed_in_tests() {
        // SAFETY: it panics before it reads.
        unsafe { pair_at(&[0i16; 4], 3) };
    }

    #[test]
    fn batches_give_the_bits_of_single_samples() {
        let mut scene = Scene::new();
        scene
            .push(Brush::new(Shape::torus(0.5, 0.2)))
            .expect("a valid brush");
        let program = Program::lower(&scene).expect("a program");
        let flat = Aabb::new(Vec3::splat(-0.6), Vec3::new(0.7, -0.55, 0.4));
        for (region, bits) in [
            (Aabb::centered(Vec3::ONE), SampleFormat::Snorm8),
            (flat, SampleFormat::Snorm16),
        ] {
            let voxel_grid = VoxelGrid::covering(region, 37).expect("a voxel grid");
            let encoding = Encoding {
                format: bits,
                ..Encoding::default()
            };
            let dense = Dense::bake(&program, voxel_grid, encoding, true);
            let count = dense.levels().len();
            let at = |i: usize, k: usize| {
                let share = (i * (k * 2 + 3) * 977 % 10_007) as f32 / 10_007.0;
                -1.3 + 2.6 * share
            };
            let (x, y, z): (Vec<f32>, Vec<f32>, Vec<f32>) = (
                (0..LANES).map(|i| at(i, 0)).collect(),
                (0..LANES).map(|i| at(i, 1)).collect(),
                (0..LANES).map(|i| at(i, 2)).collect(),
            );
            let level: Vec<u32> = (0..LANES).map(|i| (i % count) as u32).collect();
            let mut out = [0.0; LANES];
            let points = [&x[..], &y, &z];
            match bits {
                SampleFormat::Snorm8 => MipSampler::<i8>::new(&dense)
                    .expect("levels")
                    .distances(points, &level, &mut out),
                SampleFormat::Snorm16 => MipSampler::<i16>::new(&dense)
                    .expect("levels")
                    .distances(points, &level, &mut out),
            }
            let mut different = 0;
            for i in 0..LANES {
                let p = Vec3::new(x[i], y[i], z[i]);
                let single = dense.distance(level[i], p).expect("a level");
                assert!(
                    (out[i] - single).abs() <= 1e-6,
                    "{} {single} at {p}",
                    out[i]
                );
                different += usize::from(out[i] != single);
            }
            // At a border's last texel the weight is 1 of one in place of 0 of the next, which can round.
            assert!(different < 4, "{different}");
        }
    }
}
