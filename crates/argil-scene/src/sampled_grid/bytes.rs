//! Grids as the bytes of files.

use super::{GRID_MAGIC, SampledGrid};
use argil_math::Aabb;
use glam::Vec3;

impl SampledGrid {
    /// Returns the grid as the bytes of a file: [`GRID_MAGIC`], the box of the solid, and its [words](Self::words),
    /// as little-endian `f32`.
    pub fn to_bytes(&self) -> Vec<u8> {
        let solid = [self.solid.min, self.solid.max].map(|corner| corner.to_array());
        let words = solid.as_flattened().iter().chain(&self.words);
        let mut bytes = GRID_MAGIC.to_vec();
        bytes.extend(words.flat_map(|word| word.to_le_bytes()));
        bytes
    }

    /// Returns the CRC-32 of the bytes of a file, to name files by what they hold.
    pub fn checksum(&self) -> u32 {
        crc32fast::hash(&self.to_bytes())
    }

    /// Creates a grid from the bytes of a file. Returns `None` if they are not a complete grid.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, rest) = bytes.strip_prefix(&GRID_MAGIC)?.as_chunks::<4>();
        let words: Vec<f32> = words.iter().map(|&word| f32::from_le_bytes(word)).collect();
        let (solid, words) = words.split_at_checked(6)?;
        let [min, max] = [0, 3].map(|at| Vec3::from_slice(&solid[at..]));
        let grid = Self::from_words(words.to_vec(), Aabb::new(min, max))?;
        rest.is_empty().then_some(grid)
    }
}
