//! What is kept of pages, so that the pages below them get their programs at little cost.

use argil_abi::Instruction;
use argil_field::CellMarks;
use std::sync::Arc;

/// The program of a page.
#[derive(Clone, Debug)]
pub enum PageList<'a> {
    /// That of the whole scene, in pages of the coarsest level.
    Whole(&'a [Instruction]),
    /// What can matter in the page.
    Pruned(Arc<[Instruction]>),
}

impl std::ops::Deref for PageList<'_> {
    type Target = [Instruction];

    fn deref(&self) -> &[Instruction] {
        match self {
            PageList::Whole(all) => all,
            PageList::Pruned(list) => list,
        }
    }
}

/// The pruned program of a page, and when it was used last.
#[derive(Clone, Debug)]
pub(super) struct KeptList {
    pub instructions: Arc<[Instruction]>,
    pub used: u32,
}

/// The measured cells of a page.
#[derive(Debug)]
pub(super) struct PageCells {
    /// The distances at the cells' centers.
    pub distances: [f32; 8],
    /// What each drops of the page's program.
    pub marks: CellMarks,
}

impl PageCells {
    /// Returns the bytes in memory.
    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(&self.distances) + self.marks.memory_bytes()) as u64
    }
}

/// The measured cells of a page, and when they were used last.
#[derive(Clone, Debug)]
pub(super) struct KeptMarks {
    pub cells: Arc<PageCells>,
    pub used: u32,
}
