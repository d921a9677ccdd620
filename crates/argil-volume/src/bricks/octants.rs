//! Finds the octants of bricks that edits can have changed. This is finer than cells, because wide blends reach
//! far.

use super::BrickLayout;
use argil_abi::Instruction;
use argil_field::{CELLS_PER_BATCH, ChangeSet, Pruner};
use glam::{IVec3, UVec3, Vec3, uvec3};

/// Octants of a brick.
pub(super) const OCTANTS: usize = 8;

/// Returns an octant's half along each axis, 0 or 1.
pub(super) fn place_of(octant: usize) -> UVec3 {
    let octant = octant as u32;
    uvec3(octant & 1, octant >> 1 & 1, octant >> 2)
}

impl BrickLayout {
    /// Returns the center of an octant of a cell.
    pub(super) fn middle_of_octant(&self, cell: IVec3, octant: usize) -> Vec3 {
        let first = self.voxel_grid.corner + cell.as_vec3() * self.cell_length();
        first + 0.5 * self.cell_length() * (place_of(octant).as_vec3() + 0.5)
    }
}

/// Cells whose octants are measured at once.
pub(super) const CELLS_AT_ONCE: usize = CELLS_PER_BATCH / OCTANTS;

/// Returns, for some cells, one bit for each octant in which a touched instruction can matter, given a program for
/// all of them. The first cell's bits are the lowest byte.
///
/// # Panics
/// If there are more than [`CELLS_AT_ONCE`] cells.
pub(super) fn changed(
    layout: &BrickLayout,
    pruner: &mut Pruner<'_>,
    touched: &ChangeSet,
    list: &[Instruction],
    cells: &[IVec3],
) -> u64 {
    let mut centers = [Vec3::ZERO; CELLS_PER_BATCH];
    let centers = &mut centers[..cells.len() * OCTANTS];
    for (i, center) in centers.iter_mut().enumerate() {
        *center = layout.middle_of_octant(cells[i / OCTANTS], i % OCTANTS);
    }
    let mut d = [0.0; CELLS_PER_BATCH];
    let d = &mut d[..centers.len()];
    pruner.classify_cells(list, centers, 0.5 * layout.half_diagonal(1), d);
    pruner.affected_cells(list, |instr| touched.contains(instr))
}
