//! Classifies operands that cannot matter in cells, for pruning.

use crate::combine::Joint;
use argil_abi as abi;

/// Cells that are classified at once.
pub const CELLS_PER_BATCH: usize = 64;

/// Operands that cannot matter, one bit per cell.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Marks {
    pub drop_a: u64,
    pub drop_b: u64,
}

/// What up to eight cells drop of a program that they share, one bit per cell: see
/// [`Pruner::cell_marks`](crate::Pruner::cell_marks).
#[derive(Clone, Debug)]
pub struct CellMarks {
    /// For each instruction: the cells that drop what is before it, and those that drop it.
    pub(crate) marks: Box<[[u8; 2]]>,
    /// For each run of instructions: the cells that drop all of them.
    pub(crate) skipped: Box<[u8]>,
}

impl CellMarks {
    /// Returns the bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&self.marks[..]) + size_of_val(&self.skipped[..])
    }
}

/// Whether `a`, and whether `b`, can be dropped from a joint, if their distances approach each other by at most
/// `margin`.
#[inline(always)]
pub(crate) fn dominated(
    a: f32,
    b: f32,
    j: &Joint,
    flags: u32,
    is_group: bool,
    margin: f32,
) -> (bool, bool) {
    // A single brush is never painted, morphed or chamfered.
    let mode = if is_group {
        flags & abi::COMBINE_MASK
    } else {
        abi::COMBINE_SMOOTH
    };
    let is_union = j.sa > 0.0 && j.sb > 0.0;
    let (a, b) = (a * j.sa, b * j.sb);
    let clear = margin + j.k;
    match mode {
        abi::COMBINE_MORPH | abi::COMBINE_RAMPED => (false, false),
        // Paint applies where b is inside, or within its blend radius. Only b changes.
        abi::COMBINE_PAINT => (false, b > 0.5 * margin + j.k),
        abi::COMBINE_CHAMFER if j.k > 0.0 => {
            // The face must be clear of the winner too, and it is steeper by √2.
            let face = (a + b - j.k) * std::f32::consts::FRAC_1_SQRT_2;
            let steeper = 1.25 * margin;
            (
                is_union && a - b > clear && face - b > steeper,
                b - a > clear && face - a > steeper,
            )
        }
        _ => (is_union && a - b > clear, b - a > clear),
    }
}
