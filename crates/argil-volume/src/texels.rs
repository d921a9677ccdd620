use crate::{SampleFormat, Texel};
use memmap2::Mmap;
use std::ops::Range;
use std::sync::Arc;

/// Stored distances, of their own or among a file's bytes. x is fastest, then y.
#[derive(Clone, Debug)]
pub enum Texels {
    /// Samples of one byte.
    Snorm8(Vec<i8>),
    /// Samples of two bytes.
    Snorm16(Vec<i16>),
    /// A part of a file.
    Mapped {
        /// The file's bytes.
        file: Arc<Mmap>,
        /// The range of bytes, aligned to 64 bytes.
        range: Range<usize>,
        /// The format of a sample.
        format: SampleFormat,
    },
}

/// The requested type is the stored one, because both follow from the encoding.
pub(crate) const OF_THIS_TYPE: &str = "texels of the encoding's type";

impl Texels {
    /// Returns the samples' bytes, little-endian.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Snorm8(all) => bytemuck::cast_slice(all),
            Self::Snorm16(all) => bytemuck::cast_slice(all),
            Self::Mapped { file, range, .. } => &file[range.clone()],
        }
    }

    /// Returns the format of a sample.
    pub fn bits(&self) -> SampleFormat {
        match self {
            Self::Snorm8(_) => SampleFormat::Snorm8,
            Self::Snorm16(_) => SampleFormat::Snorm16,
            Self::Mapped { format: bits, .. } => *bits,
        }
    }

    /// Returns the samples, if they are of this type.
    pub fn of<T: Texel>(&self) -> Option<&[T]> {
        (self.bits() == T::FORMAT)
            .then(|| bytemuck::try_cast_slice(self.bytes()).ok())
            .flatten()
    }

    /// Creates samples from little-endian bytes. Returns `None` if half a sample remains.
    pub fn from_bytes(bits: SampleFormat, bytes: Vec<u8>) -> Option<Self> {
        match bits {
            SampleFormat::Snorm8 => Some(Self::Snorm8(bytemuck::allocation::cast_vec(bytes))),
            SampleFormat::Snorm16 => {
                let (pairs, rest) = bytes.as_chunks::<2>();
                rest.is_empty()
                    .then(|| Self::Snorm16(pairs.iter().map(|&b| i16::from_le_bytes(b)).collect()))
            }
        }
    }

    /// Returns the samples, copied if they are in a file.
    ///
    /// # Panics
    /// If they are of another type.
    pub(crate) fn into_vec<T: Texel>(self) -> Vec<T> {
        match self {
            Self::Snorm8(all) => bytemuck::allocation::cast_vec(all),
            Self::Snorm16(all) => bytemuck::allocation::cast_vec(all),
            Self::Mapped { .. } => self.of::<T>().expect(OF_THIS_TYPE).to_vec(),
        }
    }

    pub(crate) fn from_vec<T: Texel>(all: Vec<T>) -> Self {
        match T::FORMAT {
            SampleFormat::Snorm8 => Self::Snorm8(bytemuck::allocation::cast_vec(all)),
            SampleFormat::Snorm16 => Self::Snorm16(bytemuck::allocation::cast_vec(all)),
        }
    }
}

impl PartialEq for Texels {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits() && self.bytes() == other.bytes()
    }
}
