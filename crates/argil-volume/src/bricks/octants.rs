//! Which octants of bricks edits can have changed: finer than cells, as a brush reaches far where blends are wide.

use super::BrickLayout;
use argil_abi::Instr;
use argil_field::{CELLS, Pruner, Touched};
use glam::{IVec3, UVec3, Vec3, uvec3};

/// Octants of a brick.
pub(super) const OCTANTS: usize = 8;

/// Where an octant lies along each axis: in the lower half of its brick, or the upper one.
pub(super) fn place_of(octant: usize) -> UVec3 {
    let octant = octant as u32;
    uvec3(octant & 1, octant >> 1 & 1, octant >> 2)
}

impl BrickLayout {
    /// The middle of an octant of a cell.
    pub(super) fn middle_of_octant(&self, cell: IVec3, octant: usize) -> Vec3 {
        let first = self.lattice.corner + cell.as_vec3() * self.cell_length();
        first + 0.5 * self.cell_length() * (place_of(octant).as_vec3() + 0.5)
    }
}

/// Of cells of a block, a bit for each octant in which something that was touched can matter, by the block's lists as they
/// are and as they were.
pub(super) fn changed(
    layout: &BrickLayout,
    pruner: &mut Pruner<'_>,
    touched: &Touched,
    lists: [&[Instr]; 2],
    cells: &[IVec3],
) -> Vec<u8> {
    let mut out = Vec::with_capacity(cells.len());
    let radius = layout.half_diagonal(1) * 0.5;
    let is_one = |instr: &Instr| touched.has(instr);
    let mut d = [0.0; CELLS];
    let mut centers = [Vec3::ZERO; CELLS];
    for some in cells.chunks(CELLS / OCTANTS) {
        let count = some.len() * OCTANTS;
        for (i, center) in centers[..count].iter_mut().enumerate() {
            *center = layout.middle_of_octant(some[i / OCTANTS], i % OCTANTS);
        }
        let mut needed = 0;
        for list in lists {
            if touched.any(list) {
                pruner.mark(list, &centers[..count], radius, &mut d[..count]);
                needed |= pruner.needed(list, is_one);
            }
        }
        out.extend((0..some.len()).map(|i| (needed >> (i * OCTANTS)) as u8));
    }
    out
}
