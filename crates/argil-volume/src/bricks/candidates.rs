//! Finds the cells near the surface, and their pruned programs.

use super::bounds::CellBounds;
use super::cell::{BrickCell, block_empty_word, empty_word};
use super::inner_cell;
use super::layout::BrickLayout;
use super::plan::{BlockPlan, LONG};
use super::table::far_words;
use argil_abi::Instruction;
use argil_field::{CELLS_PER_BATCH, Program, Pruner};
use argil_math::Control;
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The cells of a block that the surface can pass through, each with its range of a program.
#[derive(Debug, Default)]
pub(crate) struct CandidateBlock {
    pub slot: usize,
    pub cells: Vec<(u8, Range<usize>)>,
    pub instructions: Vec<Instruction>,
    /// The block's program in the plan, if it is so long that its cells have none: their ranges are empty.
    pub long: Option<Range<usize>>,
}

/// Which programs of cells are stored.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum StoredPrograms {
    All,
    /// Those of blocks whose program is not long. A long one has as long programs of cells, which take gigabytes.
    Short,
}

/// Returns the cells that the surface can pass through, with their programs, and the words of all slots.
pub(super) fn candidates(
    program: &Program,
    layout: &BrickLayout,
    bounds: &CellBounds<'_>,
    (plan, stored): (&BlockPlan, StoredPrograms),
    control: &Control,
) -> (Vec<CandidateBlock>, Vec<u32>) {
    let mut words = far_words(layout.far_length());
    let first_slot = words.len() / CELLS_PER_BATCH;
    words.resize(words.len() + CELLS_PER_BATCH * plan.blocks.len(), 0);
    let candidates = words[first_slot * CELLS_PER_BATCH..]
        .par_chunks_mut(CELLS_PER_BATCH)
        .zip(&plan.blocks)
        .enumerate()
        .with_min_len(8)
        .map_init(
            || Pruner::new(program),
            |pruner, (at, (words, (block, range)))| {
                control.advance(1);
                if control.is_cancelled() {
                    return CandidateBlock::default();
                }
                let first = *block * super::BLOCK_SIDE as i32;
                let bounds = bounds.of_block(layout, first);
                let instructions = &plan.instructions[range.clone()];
                let is_long = stored == StoredPrograms::Short && instructions.len() > LONG;
                let mut all = |_: &Pruner<'_>| u64::MAX;
                let wanted = match is_long {
                    true => Wanted::Cells,
                    false => Wanted::Programs(&mut all),
                };
                let mut found = near_block(
                    layout,
                    &bounds,
                    first,
                    (instructions, u64::MAX),
                    pruner,
                    words,
                    wanted,
                );
                found.slot = first_slot + at;
                found.long = is_long.then(|| range.clone());
                found
            },
        )
        .filter(|c| !c.cells.is_empty())
        .collect();
    (candidates, words)
}

/// Returns a block's mask, and marks its words if the block is empty.
pub(super) fn empty_cells_of(words: &mut [u32]) -> u64 {
    let mut mask = 0u64;
    for (i, &word) in words.iter().enumerate() {
        mask |= u64::from(matches!(BrickCell::of(word), BrickCell::Brick(_))) << i;
    }
    if mask == 0 {
        words
            .iter_mut()
            .for_each(|word| *word = block_empty_word(*word));
    }
    mask
}

/// What is returned of the cells that the surface can pass through.
pub(super) enum Wanted<'a> {
    /// All of them, without programs.
    Cells,
    /// Those that a function selects after the pruner classified them, with their pruned programs.
    Programs(&'a mut dyn FnMut(&Pruner<'_>) -> u64),
}

/// Measures some of a block's cells. Returns the words of empty cells, and the wanted ones of the others.
pub(super) fn near_block(
    layout: &BrickLayout,
    bounds: &CellBounds<'_>,
    first: IVec3,
    (instructions, some): (&[Instruction], u64),
    pruner: &mut Pruner<'_>,
    words: &mut [u32],
    wanted: Wanted<'_>,
) -> CandidateBlock {
    let cell = |i: usize| first + inner_cell(i);
    let mut cells = [0; CELLS_PER_BATCH];
    let count = some.count_ones() as usize;
    let all = (0..CELLS_PER_BATCH).filter(|i| some >> i & 1 != 0);
    cells.iter_mut().zip(all).for_each(|(own, i)| *own = i);
    let centers: [Vec3; CELLS_PER_BATCH] =
        std::array::from_fn(|index| layout.center(cell(cells[index]), 1));
    let mut d = [0.0; CELLS_PER_BATCH];
    let radius = layout.half_diagonal(1);
    pruner.classify_cells(instructions, &centers[..count], radius, &mut d[..count]);
    let (has_programs, wanted) = match wanted {
        Wanted::Cells => (false, u64::MAX),
        Wanted::Programs(select) => (true, select(pruner)),
    };
    let mut found = CandidateBlock::default();
    let mut doubtful = 0u64;
    for (index, (&i, &d)) in cells.iter().zip(&d).enumerate().take(count) {
        // If a candidate's brick is dropped, this remains.
        words[i] = empty_word(bounds.center(d));
        if bounds.is_clear(d, radius) {
            continue;
        }
        if wanted >> index & 1 != 0 && layout.can_have_brick(cell(i)) {
            let from = found.instructions.len();
            let is_doubtful = bounds.is_doubtful(d, radius);
            if has_programs || is_doubtful {
                pruner.prune_into(instructions, index, &mut found.instructions);
            }
            found.cells.push((i as u8, from..found.instructions.len()));
            doubtful |= u64::from(is_doubtful) << i;
        }
    }
    if doubtful != 0 {
        // The classification of all cells is still needed.
        let mut pruner = Pruner::new(bounds.program);
        let CandidateBlock {
            cells,
            instructions,
            ..
        } = &mut found;
        cells.retain(|(i, range)| {
            let list = &instructions[range.clone()];
            doubtful >> i & 1 == 0
                || !is_clear_in_parts(layout, bounds, cell(usize::from(*i)), list, &mut pruner)
        });
    }
    if !has_programs {
        found.instructions = Vec::new();
        found.cells.iter_mut().for_each(|(_, range)| *range = 0..0);
    }
    found
}

impl CandidateBlock {
    /// Classifies the cells of a block again that has a long program. [`Pruner::prune_into`] then returns their programs,
    /// by the cell's number in the block.
    pub(super) fn classify_again(
        layout: &BrickLayout,
        first: IVec3,
        instructions: &[Instruction],
        pruner: &mut Pruner<'_>,
    ) {
        let centers: [Vec3; CELLS_PER_BATCH] =
            std::array::from_fn(|i| layout.center(first + inner_cell(i), 1));
        let radius = layout.half_diagonal(1);
        pruner.classify_cells(instructions, &centers, radius, &mut [0.0; CELLS_PER_BATCH]);
    }
}

/// Parts of a cell along each axis that are measured where something jumps, far from the surface compared with the
/// isolation of copies.
const PARTS: i32 = 4;

/// Whether no part of a cell contains a surface, by its pruned program.
pub(super) fn is_clear_in_parts(
    layout: &BrickLayout,
    bounds: &CellBounds<'_>,
    cell: IVec3,
    instructions: &[Instruction],
    pruner: &mut Pruner<'_>,
) -> bool {
    let edge = layout.cell_length();
    let corner = layout.voxel_grid.corner + cell.as_vec3() * edge;
    let centers: [Vec3; CELLS_PER_BATCH] =
        std::array::from_fn(|i| corner + (inner_cell(i).as_vec3() + 0.5) * (edge / PARTS as f32));
    let radius = layout.half_diagonal(1) / PARTS as f32;
    let mut d = [0.0; CELLS_PER_BATCH];
    pruner.classify_cells(instructions, &centers, radius, &mut d);
    d.iter().all(|&d| bounds.is_clear(d, radius))
}
