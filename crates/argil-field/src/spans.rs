//! The pieces and open groups of a program, and their instructions in a list.

use argil_abi::{self as abi, Instruction};
use argil_scene::{Extent, Operator};

/// A piece of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OperandSpan {
    /// Its first instruction, and the one after its last.
    pub begin: u32,
    pub end: u32,
    /// The group that contains it, by index, or [`crate::pieces::ROOT`].
    pub group: u32,
    /// Its operator, in the scene's unit.
    pub operator: Operator,
    /// Its extent, in the scene's space.
    pub extent: Extent,
}

/// An open group of a program. The first one is the root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupSpan {
    /// The group around it.
    pub parent: u32,
    pub operator: Operator,
    /// The instructions that save the accumulator and combine it again.
    pub open: Instruction,
    pub close: Instruction,
}

/// Appends an operand's instructions, and points the ends of loops at their beginnings.
pub(crate) fn append(instructions: &[Instruction], out: &mut Vec<Instruction>) {
    let begin = out.len() as u32;
    out.extend(instructions.iter().map(|&instr| Instruction {
        operand: if instr.op == abi::OP_NEXT {
            instr.operand + begin
        } else {
            instr.operand
        },
        ..instr
    }));
}
