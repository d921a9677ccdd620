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
    let half = 0.5 * layout.cell_length();
    let radius = layout.half_diagonal(1) * 0.5;
    let is_one = |instr: &Instr| touched.has(instr);
    let mut d = [0.0; CELLS];
    let mut centers = [Vec3::ZERO; CELLS];
    for some in cells.chunks(CELLS / OCTANTS) {
        let count = some.len() * OCTANTS;
        for (i, center) in centers[..count].iter_mut().enumerate() {
            let first = layout.lattice.corner + some[i / OCTANTS].as_vec3() * layout.cell_length();
            *center = first + half * (place_of(i % OCTANTS).as_vec3() + 0.5);
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
