//! Bakes single bricks, for levels of detail.

use super::bounds::CellBounds;
use super::brick_baker::{BrickBaker, SampleOffsets};
use super::candidates::is_clear_in_parts;
use super::cell::empty_word;
use super::{BLOCK_SIDE, BrickLayout, inner_cell};
use crate::Texel;
use argil_abi::{FillUniform, Instruction};
use argil_field::{Program, Pruner};
use glam::IVec3;

/// What all cells of a layout share.
pub(crate) struct CellContext<'a> {
    pub layout: BrickLayout,
    program: &'a Program,
    bounds: CellBounds<'a>,
    fill: FillUniform,
    places: &'static SampleOffsets,
    /// The largest deviation of distances from a plane in a flat cell.
    tolerance: f32,
}

/// Whether the surface can pass through a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellNearness {
    Clear,
    Near,
    /// Only jumps keep it from being clear.
    Doubtful,
}

/// A sampled brick.
pub(crate) struct SampledBrick {
    pub material: u32,
    /// Whether its distances are those of a plane.
    pub is_flat: bool,
}

impl<'a> CellContext<'a> {
    pub(crate) fn new(program: &'a Program, layout: BrickLayout, tolerance: f32) -> Self {
        Self {
            tolerance,
            program,
            bounds: CellBounds::new(program, &layout),
            fill: layout.encoding.fill_uniform(program, &layout.voxel_grid, 0),
            places: SampleOffsets::of_eight(),
            layout,
        }
    }

    /// Returns the state of a thread.
    pub(crate) fn baker(&self) -> BrickBaker<'_> {
        BrickBaker::new(self.program, &self.layout, &self.fill, self.places)
    }

    /// Measures cells of a block with a program that is valid in all of them: the distances at their centers. The
    /// pruner then knows their programs.
    pub(crate) fn classify(
        &self,
        (block, inner): (IVec3, &[u8; 8]),
        list: &[Instruction],
        pruner: &mut Pruner<'_>,
    ) -> [f32; 8] {
        let first = block * BLOCK_SIDE as i32;
        let centers = inner.map(|i| self.layout.center(first + inner_cell(i.into()), 1));
        let mut distances = [0.0; 8];
        pruner.classify_cells(list, &centers, self.layout.half_diagonal(1), &mut distances);
        distances
    }

    /// Returns a measured cell's word, if it gets no brick.
    pub(crate) fn empty_word(&self, block: IVec3, distance: f32) -> u32 {
        let bounds = self
            .bounds
            .of_block(&self.layout, block * BLOCK_SIDE as i32);
        empty_word(bounds.center(distance))
    }

    /// Whether the surface can pass through a measured cell.
    pub(crate) fn is_near(&self, (block, inner): (IVec3, u8), distance: f32) -> CellNearness {
        let first = block * BLOCK_SIDE as i32;
        let bounds = self.bounds.of_block(&self.layout, first);
        let radius = self.layout.half_diagonal(1);
        let can_be = self.layout.can_have_brick(first + inner_cell(inner.into()));
        if bounds.is_clear(distance, radius) || !can_be {
            CellNearness::Clear
        } else if bounds.is_doubtful(distance, radius) {
            CellNearness::Doubtful
        } else {
            CellNearness::Near
        }
    }

    /// Whether no surface passes through a doubtful cell, given its program.
    pub(crate) fn is_clear_in_parts(
        &self,
        (block, inner): (IVec3, u8),
        list: &[Instruction],
    ) -> bool {
        let first = block * BLOCK_SIDE as i32;
        let bounds = self.bounds.of_block(&self.layout, first);
        let cell = first + inner_cell(inner.into());
        let mut pruner = Pruner::new(self.program);
        is_clear_in_parts(&self.layout, &bounds, cell, list, &mut pruner)
    }

    /// Whether a brick's samples at its corners and its center can be those of a plane. It saves most bricks the proof.
    fn may_be_plane<T: Texel>(&self, texels: &[T]) -> bool {
        let layout = &self.layout;
        let n = layout.brick_size_voxels as usize;
        let quantum = layout.encoding.band_width(&layout.voxel_grid, 0)
            / layout.encoding.format.max_code() as f32;
        let at = |x: usize, y: usize, z: usize| {
            let nth = (z * (n + 1) + y) * (n + 1) + x;
            texels[nth].code() * quantum
        };
        let first = at(0, 0, 0);
        let along = [at(n, 0, 0), at(0, n, 0), at(0, 0, n)].map(|d| d - first);
        // A plane through four samples is off by up to five times their error elsewhere.
        let limit = 6.0 * (self.tolerance + quantum);
        let corners = [[1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]].map(|corner| {
            let [x, y, z] = corner.map(|c| c * n);
            let expected: f32 = (0..3).map(|axis| corner[axis] as f32 * along[axis]).sum();
            at(x, y, z) - first - expected
        });
        let center = at(n / 2, n / 2, n / 2) - first - 0.5 * along.iter().sum::<f32>();
        corners
            .iter()
            .chain([&center])
            .all(|off| off.abs() <= limit)
    }

    /// Samples a cell's brick behind `texels`. Returns `None` if no surface passes through it.
    pub(crate) fn sample<T: Texel>(
        &self,
        (block, inner): (IVec3, u8),
        list: &[Instruction],
        baker: &mut BrickBaker<'_>,
        (texels, mixed): (&mut Vec<T>, &mut Vec<[u32; 2]>),
    ) -> Option<SampledBrick> {
        let layout = &self.layout;
        let first = block * BLOCK_SIDE as i32;
        let cell = first + inner_cell(usize::from(inner));
        let bounds = self.bounds.of_block(layout, first);
        // At most half of a voxel's diagonal from a sample.
        let reach = 0.5 * 3f32.sqrt() * layout.voxel_grid.voxel_size;
        let begin = texels.len();
        texels.resize(begin + layout.brick_samples() as usize, T::default());
        let least = baker.brick(list, cell, &mut texels[begin..]);
        if bounds.is_clear(least, reach) {
            texels.truncate(begin);
            return None;
        }
        let is_plane = self.may_be_plane(&texels[begin..]);
        let flat = is_plane.then(|| baker.flat_program(list, cell, self.tolerance));
        let flat = flat.flatten();
        let is_flat = flat.is_some();
        // Other materials are not near the surface.
        let list = flat.as_deref().unwrap_or(list);
        let material = baker.material(list, cell, mixed);
        Some(SampledBrick { material, is_flat })
    }
}
