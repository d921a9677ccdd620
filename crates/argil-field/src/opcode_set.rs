//! The interpreter's WGSL without the cases that a program does not use.
//!
//! A hardware GPU jumps over the cases of a switch that no thread takes. A software one (lavapipe) works through all of
//! them with its lanes switched off, so that one sphere costs as much as every shape together.

use crate::dispatch::wgsl_dispatch;
use crate::{Program, WGSL_COMMON};
use argil_abi as abi;

/// Opcodes, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpcodeSet(u128);

impl OpcodeSet {
    /// All of them.
    pub const ALL: Self = Self(u128::MAX);

    /// Those of a program.
    pub fn of(program: &Program) -> Self {
        Self(
            program
                .instructions
                .iter()
                .fold(0, |set, instr| set | 1 << (instr.op & 127)),
        )
    }

    /// Whether the set has an opcode.
    pub fn contains(self, op: u32) -> bool {
        self.0 >> (op & 127) & 1 == 1
    }

    /// The opcodes of either.
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether every opcode of `other` is here.
    pub fn is_superset(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The WGSL twins: shapes, operators and an interpreter of programs of these opcodes, for a module that declares the
    /// tables `instrs: array<Instruction>`, `params: array<f32>` and `materials: array<GpuMaterial>`, and includes
    /// `argil_abi::wgsl`.
    pub fn wgsl(self) -> String {
        self.interpreter() + include_str!("whole.wgsl")
    }

    /// The same, and the twin of [`crate::Pruner`]: the interpreter runs the stretch `list` of `lists: array<u32>`, of
    /// which `pruned` makes others. The module declares `prune: Prune` and `counters: array<atomic<u32>>` too.
    pub fn pruning_wgsl(self) -> String {
        self.interpreter() + include_str!("prune.wgsl")
    }

    fn interpreter(self) -> String {
        let mut text = WGSL_COMMON.to_owned() + &wgsl_dispatch(|op| self.contains(op));
        // While skipping: how many braces of the case are open.
        let mut skipping = 0i32;
        for line in include_str!("interpret.wgsl").lines() {
            let balance = line.matches('{').count() as i32 - line.matches('}').count() as i32;
            if skipping > 0 {
                skipping += balance;
                continue;
            }
            if let Some(names) = line
                .trim_start()
                .strip_prefix("case ")
                .and_then(|l| l.split_once(':'))
                .map(|(n, _)| n)
                && !names
                    .split(", ")
                    .any(|name| abi::opcode(name).is_none_or(|op| self.contains(op)))
            {
                skipping = balance;
                continue;
            }
            text += line;
            text.push('\n');
        }
        text
    }
}
