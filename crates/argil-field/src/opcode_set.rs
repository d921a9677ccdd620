//! The interpreter's WGSL, without the cases that a program does not use.
//!
//! A hardware GPU skips cases of a switch that no thread takes. A software GPU (lavapipe) executes all of them with
//! its lanes masked, so that one sphere would cost as much as all shapes together.

use crate::dispatch::wgsl_dispatch;
use crate::{Program, WGSL_COMMON};
use argil_abi as abi;

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
        let own = Self(all.fold(0, |set, instr| set | 1 << (instr.op & 127)));
        own.union(Self::of_materials(program))
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

    /// Returns the WGSL twins: shapes, operators and an interpreter of these opcodes. The module must declare the
    /// tables `instructions: array<Instruction>`, `params: array<f32>` and `materials: array<GpuMaterial>`, and include
    /// `argil_abi::wgsl`.
    pub fn wgsl(self) -> String {
        self.interpreter() + include_str!("unpruned.wgsl")
    }

    /// Returns the WGSL twins with pruning, the twin of [`crate::Pruner`]. The interpreter runs the range `list` of
    /// `lists: array<u32>`, and `pruned` derives others from it. The module must also declare `prune: PruneUniform`
    /// and `counters: array<atomic<u32>>`.
    pub fn pruning_wgsl(self) -> String {
        self.interpreter() + include_str!("prune.wgsl")
    }

    fn interpreter(self) -> String {
        let mut text = WGSL_COMMON.to_owned() + &wgsl_dispatch(|op| self.contains(op));
        text += MATERIAL_SHIFT;
        text += if self.is_superset(Self::TEXTURED) {
            TEXTURES
        } else {
            PLAIN_MATERIALS
        };
        // While skipping: the number of open braces of the case.
        let mut skipping = 0i32;
        for line in include_str!("interpreter.wgsl").lines() {
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

/// The materials of brushes with textures.
pub(crate) const TEXTURES: &str = concat!(
    include_str!("texture_patterns.wgsl"),
    include_str!("textures.wgsl")
);

/// What stands for `textures.wgsl` where no material has any.
pub(crate) const PLAIN_MATERIALS: &str = "
fn brush_material(instr: Instruction, at: vec3<f32>, p: vec3<f32>, own: u32) -> GpuMaterial {
    return materials[material_shift + instr.operand];
}
";

/// Where materials begin in their table. Passes that need what materials have besides the words of an entry set it to a second
/// list of them: see [`Program::material_extras`].
pub(crate) const MATERIAL_SHIFT: &str = "
var<private> material_shift: u32;
";
