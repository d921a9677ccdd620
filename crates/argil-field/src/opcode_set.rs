//! Sets of opcodes.

use crate::Program;

/// A set of opcodes, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpcodeSet(u128);

impl OpcodeSet {
    /// All opcodes, without textures.
    pub const ALL: Self = Self(!Self::TEXTURED.0);

    /// What programs with textures need besides opcodes.
    pub const TEXTURED: Self = Self(1 << 127);

    /// Returns the opcodes of a program.
    pub fn of(program: &Program) -> Self {
        let all = program.instructions.iter();
        let used = Self(all.fold(0, |set, instr| set | 1 << (instr.op & 127)));
        used.union(Self::of_materials(program))
    }

    /// Returns what a program's materials need.
    pub fn of_materials(program: &Program) -> Self {
        if program.has_textures() {
            Self::TEXTURED
        } else {
            Self::default()
        }
    }

    /// Whether the set contains an opcode.
    pub fn contains(self, op: u32) -> bool {
        self.0 >> (op & 127) & 1 == 1
    }

    /// Returns the union of two sets.
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the set contains every opcode of `other`.
    pub fn is_superset(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}
