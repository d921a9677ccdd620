use super::bounds::CellBounds;
use super::candidates::{CandidateBlock, StoredPrograms, candidates};
use super::layout::BricksError;
use super::plan::BlockPlan;
use super::table::BlockTable;
use super::{BLOCK_SIDE, BrickLayout};
use argil_abi::Instruction;
use argil_field::Program;
use argil_math::Control;
use glam::IVec3;

/// The pruned program of each cell near the surface. Its distances equal the whole program's, bit for bit, as far
/// as they determine what bricks store.
#[derive(Debug)]
pub struct CellPrograms {
    layout: BrickLayout,
    table: BlockTable,
    /// In the order of slots.
    candidates: Vec<CandidateBlock>,
}

impl CellPrograms {
    pub(super) fn new(
        layout: BrickLayout,
        table: BlockTable,
        candidates: Vec<CandidateBlock>,
    ) -> Self {
        Self {
            layout,
            table,
            candidates,
        }
    }

    /// Computes the programs, on rayon's current threads.
    ///
    /// # Errors
    /// If there are more blocks than can be numbered.
    pub fn of(program: &Program, layout: &BrickLayout) -> Result<Self, BricksError> {
        let bounds = CellBounds::new(program, layout);
        let control = Control::default();
        let plan = BlockPlan::of(program, layout, None, &control)?;
        let (candidates, _) = candidates(
            program,
            layout,
            &bounds,
            (&plan, StoredPrograms::All),
            &control,
        );
        Ok(Self::new(
            *layout,
            BlockTable::of(layout, &plan),
            candidates,
        ))
    }

    /// Returns the layout of cells.
    pub fn layout(&self) -> &BrickLayout {
        &self.layout
    }

    /// Returns the program of a cell, or `None` if no surface can pass through it.
    pub fn cell_program(&self, cell: IVec3) -> Option<&[Instruction]> {
        let block = cell.div_euclid(IVec3::splat(BLOCK_SIDE as i32));
        let inner = cell - block * BLOCK_SIDE as i32;
        let slot = self.table.find(block)? as usize;
        let place = self.candidates.binary_search_by_key(&slot, |c| c.slot);
        let found = &self.candidates[place.ok()?];
        let inner = (inner.x + 4 * inner.y + 16 * inner.z) as u8;
        let place = found.cells.binary_search_by_key(&inner, |cell| cell.0);
        Some(&found.instructions[found.cells[place.ok()?].1.clone()])
    }
}
