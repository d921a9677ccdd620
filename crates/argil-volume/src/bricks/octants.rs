//! Finds the octants of bricks that edits can have changed. This is finer than cells, because wide blends reach
//! far.

use super::BrickLayout;
use crate::Texel;
use argil_abi::{FillUniform, Instruction};
use argil_field::{Additions, CELLS_PER_BATCH, ChangeSet, Pruner};
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3, uvec3};
use multiversion::multiversion;

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

/// Returns the octants of a cell in which appended brushes can matter, one bit each, by its samples before. `lipschitz` bounds how
/// fast distances change near the cell.
pub(super) fn reached<T: Texel>(
    layout: &BrickLayout,
    added: &Additions<'_>,
    (fill, lipschitz): (&FillUniform, f32),
    cell: IVec3,
    samples: &[T],
) -> u8 {
    let codes = ranges(samples, layout.brick_size_voxels as usize + 1);
    let scale = fill.spacing_scale[3];
    let most = fill.max_code as f32;
    // Between samples, distances are others. No point is farther from one than half a voxel's diagonal.
    let between = 0.5 * 3f32.sqrt() * lipschitz * layout.voxel_grid.voxel_size;
    let half = 0.25 * layout.cell_length();
    let mut octants = 0;
    for (octant, [low, high]) in codes.into_iter().enumerate() {
        // Distances beyond the band are stored as its end.
        let low = if low > -most { low } else { f32::NEG_INFINITY };
        let high = if high < most { high } else { f32::INFINITY };
        let scene = [
            (low - 1.0) / scale - between,
            (high + 1.0) / scale + between,
        ];
        let center = layout.middle_of_octant(cell, octant);
        let region = Aabb::new(center - half, center + half).grown(0.01 * half);
        octants |= u8::from(added.can_matter_in(region, scene)) << octant;
    }
    octants
}

/// The most samples of a layer of a brick.
const MAX_LAYER: usize = 17 * 17;

/// Returns the least and the largest code of each octant of a brick's samples, given their number along a side. Samples in the middle
/// belong to both sides.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn ranges<T: Texel>(samples: &[T], side: usize) -> [[f32; 2]; OCTANTS] {
    let (half, layer) = (side / 2, side * side);
    let mut all = [[0.0; 2]; OCTANTS];
    for back in 0..2 {
        let layers = &samples[back * half * layer..][..(half + 1) * layer];
        let [mut lows, mut highs] = [[T::default(); MAX_LAYER]; 2];
        let (lows, highs) = (&mut lows[..layer], &mut highs[..layer]);
        lows.copy_from_slice(&layers[..layer]);
        highs.copy_from_slice(&layers[..layer]);
        for texels in layers[layer..].chunks_exact(layer) {
            for ((low, high), &texel) in lows.iter_mut().zip(&mut *highs).zip(texels) {
                (*low, *high) = (texel.min(*low), texel.max(*high));
            }
        }
        for quarter in 0..4 {
            let corner = (quarter & 1) * half + (quarter >> 1) * half * side;
            let (mut low, mut high) = (lows[corner], highs[corner]);
            for row in (corner..).step_by(side).take(half + 1) {
                for i in row..=row + half {
                    (low, high) = (lows[i].min(low), highs[i].max(high));
                }
            }
            all[4 * back + quarter] = [low.code(), high.code()];
        }
    }
    all
}
