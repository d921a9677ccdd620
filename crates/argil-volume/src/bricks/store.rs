//! The arrays of sparse bricks, without the blocks that they belong to.

use super::changes::ChangeLog;
use crate::Texels;

/// Words of cells, and the bricks that they name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BrickStore {
    /// The word of each cell, slot by slot.
    pub words: Vec<u32>,
    /// The owner of each brick: the index of its cell's word.
    pub cell_of_brick: Vec<u32>,
    /// The material of each brick.
    pub materials: Vec<u32>,
    /// The materials of mixed bricks.
    pub mixed: Vec<[u32; 2]>,
    /// The brick of each mixed brick's materials.
    pub brick_of_mixed: Vec<u32>,
    /// The samples, brick by brick. Without bricks, one brick of zeros.
    pub pool: Texels,
    /// What changed since a copy was updated.
    pub changes: ChangeLog,
}

impl BrickStore {
    /// Returns the bytes of everything.
    pub(super) fn memory_bytes(&self) -> u64 {
        let tables = size_of_val(&self.words[..])
            + size_of_val(&self.cell_of_brick[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.brick_of_mixed[..]);
        tables as u64 + self.pool.bytes().len() as u64
    }
}
