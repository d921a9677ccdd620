//! Bakes single blocks, for levels of detail.

use super::block_editor::BakedBlock;
use super::bounds::CellBounds;
use super::brick_baker::{BrickBaker, SampleOffsets};
use super::candidates::near_block;
use super::{BrickLayout, inner_cell};
use crate::Texel;
use argil_abi::{FillUniform, Instruction};
use argil_field::{Program, Pruner};
use glam::IVec3;

/// What all blocks of a layout share.
pub(crate) struct BlockContext<'a> {
    pub layout: BrickLayout,
    program: &'a Program,
    bounds: CellBounds<'a>,
    fill: FillUniform,
    places: SampleOffsets,
    /// The largest deviation of distances from a plane in a flat cell.
    tolerance: f32,
}

impl<'a> BlockContext<'a> {
    pub(crate) fn new(program: &'a Program, layout: BrickLayout, tolerance: f32) -> Self {
        Self {
            tolerance,
            program,
            bounds: CellBounds::new(program, &layout),
            fill: layout.encoding.fill_uniform(program, &layout.voxel_grid, 0),
            places: SampleOffsets::new(&layout),
            layout,
        }
    }

    /// Returns the state of a thread.
    pub(crate) fn baker(&self) -> BrickBaker<'_> {
        BrickBaker::new(self.program, &self.layout, &self.fill, &self.places)
    }

    /// Bakes a block with its program: the words of its cells, and its bricks. The words of cells with bricks are 0
    /// until the bricks have a place in a pool.
    pub(crate) fn bake<T: Texel>(
        &self,
        first: IVec3,
        list: &[Instruction],
        pruner: &mut Pruner<'_>,
        baker: &mut BrickBaker<'_>,
    ) -> BakedBlock<T> {
        let layout = &self.layout;
        let mut made = BakedBlock::new(first, None);
        let bounds = self.bounds.of_block(layout, first);
        let listed = (list, u64::MAX);
        let words = &mut made.words;
        let found = near_block(layout, &bounds, first, listed, pruner, words, |_| u64::MAX);
        let samples = layout.brick_samples() as usize;
        made.texels.reserve_exact(found.cells.len() * samples);
        // At most half of a voxel's diagonal from a sample.
        let reach = 0.5 * 3f32.sqrt() * layout.voxel_grid.voxel_size;
        for (i, range) in &found.cells {
            let (list, cell) = (
                &found.instrs[range.clone()],
                first + inner_cell(usize::from(*i)),
            );
            let begin = made.texels.len();
            made.texels.resize(begin + samples, T::default());
            let least = baker.brick(list, cell, &mut made.texels[begin..]);
            if bounds.is_clear(least, reach) {
                made.texels.truncate(begin);
                continue;
            }
            if baker.is_flat(list, cell, self.tolerance) {
                made.flat |= 1 << i;
            }
            let material = baker.material(list, cell, &mut made.mixed);
            made.bricks.push((*i, material));
            made.words[usize::from(*i)] = 0;
            made.sampled += 1;
        }
        made
    }
}
