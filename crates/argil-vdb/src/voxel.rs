//! Types of values.

use half::f16;

/// A value that a grid can hold: `f32` or `[f32; 3]`.
pub trait Voxel: Copy + PartialEq + Default + Send + Sync + std::fmt::Debug + 'static {
    /// The tree's type in files, without the suffix for 16-bit values.
    const TREE: &'static str;
    /// Bytes of a value in a file.
    const BYTES: usize;
    /// Components of a value.
    const COMPONENTS: usize;

    /// Returns the value with the opposite sign. The default background of inactive voxels inside a level set is the
    /// negative of that outside.
    fn negated(self) -> Self;
    /// Returns whether a value counts as inside.
    fn is_negative(self) -> bool;
    /// Returns the value with each component rounded to 16 bits.
    fn rounded(self) -> Self;
    /// Appends the value to bytes, little-endian.
    fn write(self, out: &mut Vec<u8>);
    /// Appends the value to bytes, with 16 bits for each component.
    fn write_half(self, out: &mut Vec<u8>);
    /// Appends values to bytes, little-endian.
    fn write_all(values: &[Self], out: &mut Vec<u8>) {
        values.iter().for_each(|value| value.write(out));
    }
    /// Appends values with 16 bits for each component.
    fn write_all_half(values: &[Self], out: &mut Vec<u8>) {
        values.iter().for_each(|value| value.write_half(out));
    }
    /// Reads a value from [`Voxel::BYTES`] bytes.
    fn read(bytes: &[u8]) -> Self;
    /// Reads a value with 16 bits for each component.
    fn read_half(bytes: &[u8]) -> Self;
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

fn half(bytes: &[u8]) -> f32 {
    f16::from_le_bytes([bytes[0], bytes[1]]).to_f32()
}

impl Voxel for f32 {
    const TREE: &'static str = "Tree_float_5_4_3";
    const BYTES: usize = 4;
    const COMPONENTS: usize = 1;

    fn negated(self) -> Self {
        -self
    }

    fn is_negative(self) -> bool {
        self < 0.0
    }

    fn rounded(self) -> Self {
        f16::from_f32(self).to_f32()
    }

    #[inline]
    fn write(self, out: &mut Vec<u8>) {
        out.extend(self.to_le_bytes());
    }

    #[inline]
    fn write_half(self, out: &mut Vec<u8>) {
        out.extend(f16::from_f32(self).to_le_bytes());
    }

    fn write_all(values: &[Self], out: &mut Vec<u8>) {
        let begin = out.len();
        out.resize(begin + 4 * values.len(), 0);
        let places = out[begin..].as_chunks_mut::<4>().0;
        for (place, value) in places.iter_mut().zip(values) {
            *place = value.to_le_bytes();
        }
    }

    fn write_all_half(values: &[Self], out: &mut Vec<u8>) {
        let begin = out.len();
        out.resize(begin + 2 * values.len(), 0);
        let places = out[begin..].as_chunks_mut::<2>().0;
        for (place, value) in places.iter_mut().zip(values) {
            *place = f16::from_f32(*value).to_le_bytes();
        }
    }

    #[inline]
    fn read(bytes: &[u8]) -> Self {
        float(bytes)
    }

    #[inline]
    fn read_half(bytes: &[u8]) -> Self {
        half(bytes)
    }
}

impl Voxel for [f32; 3] {
    const TREE: &'static str = "Tree_vec3s_5_4_3";
    const BYTES: usize = 12;
    const COMPONENTS: usize = 3;

    fn negated(self) -> Self {
        self.map(|c| -c)
    }

    fn is_negative(self) -> bool {
        false
    }

    fn rounded(self) -> Self {
        self.map(Voxel::rounded)
    }

    fn write(self, out: &mut Vec<u8>) {
        self.iter().for_each(|c| c.write(out));
    }

    fn write_half(self, out: &mut Vec<u8>) {
        self.iter().for_each(|c| c.write_half(out));
    }

    fn read(bytes: &[u8]) -> Self {
        [0, 4, 8].map(|at| float(&bytes[at..]))
    }

    fn read_half(bytes: &[u8]) -> Self {
        [0, 2, 4].map(|at| half(&bytes[at..]))
    }
}
