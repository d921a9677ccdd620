use super::BrickLayout;
use super::build::{Bounds, Candidates, candidates};
use argil_abi::Instr;
use argil_field::Program;
use glam::UVec3;

/// What can matter in each cell near the surface: lists of instructions that give the whole program's distances there, to
/// the bit.
pub struct CellLists {
    pub(super) layout: BrickLayout,
    /// In the order of blocks.
    pub(super) candidates: Vec<Candidates>,
}

impl CellLists {
    /// Of a program, on rayon's current threads.
    pub fn of(program: &Program, layout: &BrickLayout) -> Self {
        let bounds = Bounds::new(program, layout);
        Self {
            layout: *layout,
            candidates: candidates(program, layout, &bounds).0,
        }
    }

    /// Where the cells lie.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// The list of a cell; `None` where no surface can be.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn list(&self, cell: UVec3) -> Option<&[Instr]> {
        let at = self.layout.word_index(cell);
        let (block, inner) = (at / 64, (at % 64) as u8);
        let place = self.candidates.binary_search_by_key(&block, |c| c.block);
        let found = &self.candidates[place.ok()?];
        let place = found.cells.binary_search_by_key(&inner, |cell| cell.0);
        Some(&found.instrs[found.cells[place.ok()?].1.clone()])
    }
}
