//! Sizes and numbers of the layout.

use super::NanoType;

pub(super) const MAGIC: u64 = 0x3042_4456_6f6e_614e;
/// Magic numbers since version 32.6, of a grid and of a file.
pub(super) const NEWER_MAGICS: [u64; 2] = [0x3142_4456_6f6e_614e, 0x3242_4456_6f6e_614e];
/// 32.4.2.
pub(super) const VERSION: u32 = 32 << 21 | 4 << 10 | 2;
pub(super) const FILE_HEADER: usize = 16;
pub(super) const FILE_METADATA: usize = 176;
pub(super) const GRID: usize = 672;
pub(super) const TREE: usize = 64;
pub(super) const ROOT: usize = 64;
pub(super) const ROOT_TILE: usize = 32;
pub(super) const LEAF_HEAD: usize = 96;

/// The layout of an inner node with `places` places.
pub(super) struct Inner {
    pub places: usize,
}

pub(super) const LOWER: Inner = Inner { places: 4096 };
pub(super) const UPPER: Inner = Inner { places: 32768 };

impl Inner {
    /// Where the mask of active tiles begins.
    pub(super) const ACTIVE: usize = 32;

    pub(super) const fn children(&self) -> usize {
        Self::ACTIVE + self.places / 8
    }

    pub(super) const fn statistics(&self) -> usize {
        self.children() + self.places / 8
    }

    pub(super) const fn table(&self) -> usize {
        (self.statistics() + 16).next_multiple_of(32)
    }

    pub(super) const fn bytes(&self) -> usize {
        self.table() + 8 * self.places
    }
}

const _: () = assert!(LOWER.bytes() == 33_856 && UPPER.bytes() == 270_400);

impl NanoType {
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Float => 1,
            Self::Fp16 => 15,
            Self::Fp8 => 14,
        }
    }

    pub(super) fn from_number(number: u32) -> Option<Self> {
        let all = [Self::Float, Self::Fp16, Self::Fp8];
        all.into_iter().find(|kind| kind.number() == number)
    }

    pub(super) fn leaf_bytes(self) -> usize {
        LEAF_HEAD
            + 512
                * match self {
                    Self::Float => 4,
                    Self::Fp16 => 2,
                    Self::Fp8 => 1,
                }
    }

    /// Returns the largest code of a quantized value.
    pub(super) fn largest_code(self) -> f32 {
        match self {
            Self::Float => 0.0,
            Self::Fp16 => 65_535.0,
            Self::Fp8 => 255.0,
        }
    }
}

/// Returns the key of a root tile.
pub(super) fn key_of(origin: [i32; 3]) -> u64 {
    let [x, y, z] = origin.map(|c| u64::from(c as u32 >> 12));
    x << 42 | y << 21 | z
}

/// Returns the origin of a root tile's key.
pub(super) fn origin_of(key: u64) -> [i32; 3] {
    [42, 21, 0].map(|shift| (((key >> shift) & 0x1f_ffff) << 12) as u32 as i32)
}
