//! The pieces and open groups of a program, and their instructions in a list.

use argil_abi::{self as abi, Instruction};
use argil_scene::{Extent, Operator};

/// A piece of a program.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OperandSpan {
    /// Its first instruction, and the one behind its last.
    pub begin: u32,
    pub end: u32,
    /// The group that it is in, by its place among the program's, or [`ROOT`].
    pub group: u32,
    /// In the world's unit.
    pub operator: Operator,
    /// In the world.
    pub extent: Extent,
}

/// An open group of a program. The first of all stands for the root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupSpan {
    /// The group around it.
    pub parent: u32,
    pub operator: Operator,
    /// What puts aside what is before it, and what joins it to that.
    pub open: Instruction,
    pub close: Instruction,
}

/// Append an operand's instructions; the ends of loops point at their beginnings.
pub(crate) fn append(instrs: &[Instruction], out: &mut Vec<Instruction>) {
    let begin = out.len() as u32;
    out.extend(instrs.iter().map(|&instr| Instruction {
        operand: if instr.op == abi::OP_NEXT {
            instr.operand + begin
        } else {
            instr.operand
        },
        ..instr
    }));
}
