//! The interpreter's WGSL, without the cases that a program does not use, and with stacks as deep as it needs.
//!
//! A hardware GPU skips cases of a switch that no thread takes. A software GPU (lavapipe) executes all of them with
//! its lanes masked, so that one sphere would cost as much as all shapes together.
//!
//! A hardware GPU keeps a short stack in registers. A longer one is in memory, and each access takes a load or a store.

use crate::column_wgsl::{column_wgsl, list_constants};
use crate::dispatch::wgsl_dispatch;
use crate::{OpcodeSet, Program, WGSL_COMMON};
use argil_abi::{self as abi, GPU_STACK_SLOTS};

/// Lengths that a stack can have, so that few edits make a shader compile again.
const STACK_CLASSES: [u32; 4] = [2, 4, 8, GPU_STACK_SLOTS];

/// An interpreter in WGSL: the opcodes that it runs, and the length of its stacks.
///
/// ```
/// use argil_field::{Interpreter, Program};
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let interpreter = Interpreter::of(&Program::lower(&scene)?);
/// assert!(interpreter.wgsl().contains("fn field_distance(p: vec3<f32>) -> f32"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interpreter {
    opcodes: OpcodeSet,
    stack_slots: u32,
    has_subgroups: bool,
    takes_turns: bool,
}

impl Interpreter {
    /// Returns an interpreter of some opcodes, whose stacks fit a program.
    pub fn new(opcodes: OpcodeSet, program: &Program) -> Self {
        let (values, points) = program.stack_slots();
        let needed = values.max(points);
        let class = STACK_CLASSES
            .into_iter()
            .find(|&slots| slots as usize >= needed);
        Self {
            opcodes,
            stack_slots: class.unwrap_or(GPU_STACK_SLOTS),
            has_subgroups: false,
            takes_turns: false,
        }
    }

    /// Lets the threads of a subgroup vote on what all of them can skip, on a device that can.
    #[must_use]
    pub fn with_subgroups(self, has_subgroups: bool) -> Self {
        Self {
            has_subgroups,
            ..self
        }
    }

    /// Lets the threads of a subgroup whose points are in different parts of a grid take turns, if threads at one instruction
    /// are faster, on a device that can.
    #[must_use]
    pub fn with_turns(self, takes_turns: bool) -> Self {
        Self {
            takes_turns,
            ..self
        }
    }

    /// Returns the interpreter that a software device gets: with a program's opcodes only.
    pub fn of(program: &Program) -> Self {
        Self::new(OpcodeSet::of(program), program)
    }

    /// Returns the interpreter that a hardware device gets: with all opcodes.
    pub fn full(program: &Program) -> Self {
        Self::new(OpcodeSet::ALL.union(OpcodeSet::of(program)), program)
    }

    /// Returns an interpreter that runs what both run.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            opcodes: self.opcodes.union(other.opcodes),
            stack_slots: self.stack_slots.max(other.stack_slots),
            ..self
        }
    }

    /// Returns the opcodes that it runs.
    pub fn opcodes(self) -> OpcodeSet {
        self.opcodes
    }

    /// Returns the length of its stacks.
    pub fn stack_slots(self) -> u32 {
        self.stack_slots
    }

    /// Returns the WGSL twins: shapes, operators and the interpreter. The module must declare the tables
    /// `instructions: array<Instruction>`, `params: array<f32>` and `materials: array<GpuMaterial>`, and include
    /// `argil_abi::wgsl`.
    pub fn wgsl(self) -> String {
        self.text(self.materials()) + UNMARKED + include_str!("unpruned.wgsl") + CALLS
    }

    /// Returns the WGSL that finds how far points moved, for [`BrushMotion::words`](crate::BrushMotion::words). `field(p, true)` sets
    /// `field_material.base_roughness.xyz` to the way to where a point of the surface was. The module must declare
    /// `instructions: array<Instruction>`, `params: array<f32>` and `moved: array<vec4<u32>>`, and include `argil_abi::wgsl`.
    pub fn motion_wgsl(self) -> String {
        let plain = Self {
            has_subgroups: false,
            ..self
        };
        plain.text(include_str!("moved.wgsl")) + UNMARKED + include_str!("unpruned.wgsl")
    }

    /// Returns the WGSL twins where each point runs the list of its part of a grid, the twin of [`crate::NearField`].
    /// The module must also declare `lists: array<u32>` and `near: NearUniform`. See [`Interpreter::near_lists_wgsl`].
    pub fn near_wgsl(self) -> String {
        let turns = if self.takes_turns {
            TAKE_TURNS
        } else {
            NO_TURNS
        };
        self.text(self.materials()) + turns + UNMARKED + LISTED + include_str!("near_field.wgsl")
    }

    /// Returns the WGSL that makes the lists for [`Interpreter::near_wgsl`]. The module must also declare
    /// `lists: array<u32>`, `prune: NearUniform` and `counters: array<atomic<u32>>`.
    pub fn near_lists_wgsl(self) -> String {
        self.pruning_wgsl() + include_str!("near_lists.wgsl")
    }

    /// Returns the WGSL twins with pruning, the twin of [`crate::Pruner`]. The interpreter runs the range `list` of
    /// `lists: array<u32>`, and `pruned` derives others from it. The module must also declare `prune: PruneUniform`
    /// and `counters: array<atomic<u32>>`.
    pub fn pruning_wgsl(self) -> String {
        self.text(self.materials())
            + &list_constants(self.opcodes, self.stack_slots)
            + LISTED
            + include_str!("prune.wgsl")
            + include_str!("column_lists.wgsl")
            + CALLS
    }

    /// Returns the WGSL that evaluates three points of a column at once, by the lists for them that `column_of` in
    /// [`Interpreter::pruning_wgsl`] writes. The module must declare `records: array<vec4<f32>>`, which are a program's
    /// parameters, and `lists: array<u32>`, and include `argil_abi::wgsl`. Returns `None` if the interpreter has no shape
    /// that is common.
    pub fn column_wgsl(self) -> Option<String> {
        column_wgsl(self.opcodes, self.stack_slots)
    }

    /// Returns the materials of brushes.
    fn materials(self) -> &'static str {
        if self.opcodes.is_superset(OpcodeSet::TEXTURED) {
            TEXTURES
        } else {
            PLAIN_MATERIALS
        }
    }

    /// Returns the interpreter, with what stands for the materials of brushes.
    fn text(self, materials: &str) -> String {
        let opcodes = self.opcodes;
        let mut text = WGSL_COMMON.to_owned() + &wgsl_dispatch(|op| opcodes.contains(op));
        text += &format!("const STACK_SLOTS: u32 = {}u;\n", self.stack_slots);
        text += MATERIAL_SHIFT;
        text += if self.has_subgroups { VOTE } else { NO_VOTE };
        text += materials;
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
                    .any(|name| abi::opcode(name).is_none_or(|op| opcodes.contains(op)))
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

const CALLS: &str = include_str!("field_calls.wgsl");
const LISTED: &str = include_str!("listed.wgsl");
const UNMARKED: &str = include_str!("unmarked.wgsl");

/// The materials of brushes with textures.
pub(crate) const TEXTURES: &str = concat!(
    include_str!("materials.wgsl"),
    include_str!("texture_patterns.wgsl"),
    include_str!("textures.wgsl")
);

/// Threads that run together skip a copy together, so that all of them stay at the same instruction. Compilers then load
/// parameters once for all.
const VOTE: &str = "
fn holds_in_subgroup(condition: bool) -> bool {
    return subgroupAll(condition);
}
";

/// Threads whose points are in one part take turns with the others, so that all of them are at the same instruction.
const TAKE_TURNS: &str = "
fn first_in_subgroup(word: u32) -> u32 {
    return subgroupBroadcastFirst(word);
}
";

/// Replaces [`TAKE_TURNS`] on devices where threads gain nothing by turns: no thread waits.
const NO_TURNS: &str = "
fn first_in_subgroup(word: u32) -> u32 {
    return word;
}
";

/// What stands for the vote on devices without it: no copy is skipped.
const NO_VOTE: &str = "
fn holds_in_subgroup(condition: bool) -> bool {
    return false;
}
";

/// What stands for `textures.wgsl` where no material has any.
pub(crate) const PLAIN_MATERIALS: &str = concat!(
    include_str!("materials.wgsl"),
    "
fn brush_material(instr: Instruction, at: vec3<f32>, p: vec3<f32>, own: u32) -> GpuMaterial {
    return materials[material_shift + instr.operand];
}
"
);

/// Where materials begin in their table. Passes that need what materials have besides the words of an entry set it to a second
/// list of them: see [`Program::material_extras`].
pub(crate) const MATERIAL_SHIFT: &str = "
var<private> material_shift: u32;
";
