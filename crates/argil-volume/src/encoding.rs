use crate::VoxelGrid;
use argil_abi::FillUniform;
use argil_field::Program;
use multiversion::multiversion;

/// The format of a stored distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleFormat {
    /// A signed byte: −127 to 127 mean −1 to 1.
    #[default]
    Snorm8,
    /// Two signed bytes: −32,767 to 32,767 mean −1 to 1.
    Snorm16,
}

impl SampleFormat {
    /// Returns the code of 1.0.
    pub fn max_code(self) -> u32 {
        match self {
            Self::Snorm8 => 127,
            Self::Snorm16 => 32_767,
        }
    }

    /// Returns the bytes per sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::Snorm8 => 1,
            Self::Snorm16 => 2,
        }
    }
}

/// The distance that a stored 1.0 means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Band {
    /// A number of voxels.
    Voxels(f32),
    /// The 2023 study's texture stride, from 1 to 32. One voxel is `stride / 256` of the band, so the band is `256
    /// / stride` voxels: from a whole 256³ volume down to 8 voxels.
    Stride(u32),
}

impl Default for Band {
    /// Returns ±4 voxels, as in Claybook (Aaltonen 2018).
    fn default() -> Self {
        Self::Voxels(4.0)
    }
}

impl Band {
    /// Returns the band in voxels of the finest level.
    pub fn voxels(self) -> f32 {
        match self {
            Self::Voxels(n) => n,
            Self::Stride(stride) => 256.0 / stride as f32,
        }
    }
}

/// How distances are stored: `round(max_code · clamp(d / band, −1, 1))`.
///
/// With 8 bits and the default band of ±4 voxels, one step is 4/127 of a voxel. On level `k`, the band is `2ᵏ`
/// times as wide, and the stored value is `|d|` minus a bias, rounded down (see [`Encoding::fill_uniform`]).
///
/// ```
/// use argil_volume::{Band, Encoding, SampleFormat};
/// let encoding = Encoding { format: SampleFormat::Snorm16, band: Band::Voxels(16.0) };
/// assert_eq!(encoding.format.max_code(), 32767);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding {
    /// The format of a sample.
    pub format: SampleFormat,
    /// The distance that 1.0 means.
    pub band: Band,
}

impl Encoding {
    /// Returns the band's width on a level, in the scene's unit.
    pub fn band_width(&self, voxel_grid: &VoxelGrid, level: u32) -> f32 {
        self.band.voxels() * voxel_grid.voxel_size * (1u32 << level.min(31)) as f32
    }

    /// Returns the parameters for sampling a level, without layers and tiles.
    ///
    /// Level 0 stores signed distances. The others store a lower bound: the unsigned distance, minus what it can
    /// change within half of a cell's diagonal, minus rounding. After interpolation it never exceeds the distance.
    /// A value of 0 or less carries no information.
    pub fn fill_uniform(
        &self,
        program: &Program,
        voxel_grid: &VoxelGrid,
        level: u32,
    ) -> FillUniform {
        let grid = voxel_grid.grid(level);
        let bias = if level == 0 {
            0.0
        } else {
            let cell = argil_math::Aabb::centered(grid.spacing * 0.5);
            let slack = program.bound_error(voxel_grid.aabb());
            // A hardware filter has weights of eight bits.
            let bias = 1.01 * program.lipschitz() * cell.half_diagonal() + slack;
            // Clamped from below, the stored value would be too large, so a level with such a narrow band stores
            // nothing.
            if bias < self.band_width(voxel_grid, level) {
                bias
            } else {
                f32::MAX
            }
        };
        let [fx, fy, fz] = grid.min.to_array();
        let [sx, sy, sz] = grid.spacing.to_array();
        let quanta = self.format.max_code();
        FillUniform {
            first_bias: [fx, fy, fz, bias],
            spacing_scale: [
                sx,
                sy,
                sz,
                quanta as f32 / self.band_width(voxel_grid, level),
            ],
            size_x: grid.size.x,
            size_y: grid.size.y,
            size_z: grid.size.z,
            max_code: quanta,
            ..FillUniform::default()
        }
    }
}

/// A stored distance. `encode` in `fill.wgsl` is the twin.
pub trait Texel: bytemuck::Pod + Ord + Send + Sync + Default {
    /// Converts a code to a sample.
    fn from_code(integer: i32) -> Self;
    /// Converts a sample to its code.
    fn code(self) -> f32;
    /// The sample's format.
    const FORMAT: SampleFormat;
}

impl Texel for i8 {
    const FORMAT: SampleFormat = SampleFormat::Snorm8;
    #[inline(always)]
    fn from_code(integer: i32) -> Self {
        integer as i8
    }
    #[inline(always)]
    fn code(self) -> f32 {
        f32::from(self)
    }
}

impl Texel for i16 {
    const FORMAT: SampleFormat = SampleFormat::Snorm16;
    #[inline(always)]
    fn from_code(integer: i32) -> Self {
        integer as i16
    }
    #[inline(always)]
    fn code(self) -> f32 {
        f32::from(self)
    }
}

/// Returns the code of a distance: the nearest one, or on a level with a bias, one that does not exceed the
/// remaining distance.
#[inline(always)]
pub(crate) fn code_of(d: f32, bias: f32, scale: f32, quanta: f32) -> i32 {
    if bias == 0.0 {
        whole(d * scale, 0.5, quanta)
    } else {
        whole(((if d < 0.0 { -d } else { d }) - bias) * scale, 0.0, quanta)
    }
}

/// `floor(clamp(value, ±quanta) + half)`.
#[inline(always)]
fn whole(value: f32, half: f32, quanta: f32) -> i32 {
    // NaN becomes the smallest code.
    let value = if value > -quanta { value } else { -quanta };
    let value = if value < quanta { value } else { quanta };
    // SAFETY: at most `quanta`, which fits, and half more.
    unsafe { (value + half).floor().to_int_unchecked() }
}

#[inline(always)]
fn encode_all<T: Texel>(d: &[f32], fill: &FillUniform, out: &mut [T]) {
    let (bias, scale, quanta) = (
        fill.first_bias[3],
        fill.spacing_scale[3],
        fill.max_code as f32,
    );
    if bias == 0.0 {
        for (out, &d) in out.iter_mut().zip(d) {
            *out = T::from_code(code_of(d, 0.0, scale, quanta));
        }
    } else {
        for (out, &d) in out.iter_mut().zip(d) {
            let value = ((if d < 0.0 { -d } else { d }) - bias) * scale;
            *out = T::from_code(whole(value, 0.0, quanta));
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn encode_i8(d: &[f32], fill: &FillUniform, out: &mut [i8]) {
    encode_all(d, fill, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn encode_i16(d: &[f32], fill: &FillUniform, out: &mut [i16]) {
    encode_all(d, fill, out);
}

/// Encodes a batch of distances.
pub(crate) fn encode<T: Texel>(d: &[f32], fill: &FillUniform, out: &mut [T]) {
    match T::FORMAT {
        SampleFormat::Snorm8 => encode_i8(d, fill, bytemuck::cast_slice_mut(out)),
        SampleFormat::Snorm16 => encode_i16(d, fill, bytemuck::cast_slice_mut(out)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_the_nearest_and_biased_ones_are_rounded_down() {
        let near = |d| code_of(d, 0.0, 127.0, 127.0);
        assert_eq!([near(0.0), near(1.0), near(-1.0)], [0, 127, -127]);
        assert_eq!([near(1e30), near(-1e30), near(-1.004)], [127, -127, -127]);
        assert_eq!([near(0.6 / 127.0), near(-0.6 / 127.0)], [1, -1]);
        assert_eq!(near(f32::NAN), -127);
        let biased = |d| code_of(d, 0.25, 127.0, 127.0);
        assert_eq!([biased(0.2), biased(-0.2)], [-7, -7]);
        assert_eq!([biased(1e30), biased(-1e30)], [127, 127]);
        assert_eq!(code_of(1.0, f32::MAX, 127.0, 127.0), -127);
        assert!(biased(0.5) <= 31 && biased(0.5) > 30);
    }

    #[test]
    fn strides_are_steps_between_texels() {
        assert_eq!(Band::Stride(1).voxels(), 256.0);
        assert_eq!(Band::Stride(32).voxels(), 8.0);
        assert_eq!(Band::default().voxels(), 4.0);
    }
}
