use crate::jumps::JumpRegion;
use crate::materials::materials_of;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::{self as abi, GpuMaterial, Instruction};
use argil_math::Aabb;
use argil_scene::Scene;

/// A scene lowered to instructions. See the crate's page.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) params: Vec<f32>,
    pub(crate) materials: Vec<GpuMaterial>,
    pub(crate) aabb: Aabb,
    /// A power of two that no finite side of an operand's box exceeds.
    pub(crate) magnitude: f32,
    pub(crate) lipschitz: f32,
    pub(crate) slack: f32,
    pub(crate) hidden_slack: f32,
    pub(crate) isolation: f32,
    /// See `Regularity::underestimate`.
    pub(crate) underestimate: f32,
    /// Operands that make `slack` and `hidden_slack`.
    pub(crate) loose: Vec<JumpRegion>,
    /// The pieces, if there are many, and the open groups that they are in.
    pub(crate) operands: Vec<OperandSpan>,
    pub(crate) groups: Vec<GroupSpan>,
    pub(crate) value_slots: usize,
    pub(crate) point_slots: usize,
    pub(crate) brushes: usize,
}

impl Default for Program {
    /// Of an empty scene.
    fn default() -> Self {
        Self {
            materials: materials_of(&Scene::new()),
            ..Self::blank()
        }
    }
}

impl Program {
    /// Without anything, materials neither.
    pub(crate) const fn blank() -> Self {
        Self {
            instructions: Vec::new(),
            params: Vec::new(),
            materials: Vec::new(),
            aabb: Aabb::EMPTY,
            magnitude: 0.0,
            lipschitz: 1.0,
            slack: 0.0,
            hidden_slack: 0.0,
            isolation: f32::INFINITY,
            underestimate: 1.0,
            loose: Vec::new(),
            operands: Vec::new(),
            groups: Vec::new(),
            value_slots: 0,
            point_slots: 0,
            brushes: 0,
        }
    }

    /// The instructions, for the GPU's table.
    pub fn instructions(&self) -> &[Instruction] {
        &self.instructions
    }

    /// The words that instructions point into.
    pub fn params(&self) -> &[f32] {
        &self.params
    }

    /// The materials that brushes point at; never empty.
    pub fn materials(&self) -> &[GpuMaterial] {
        &self.materials
    }

    /// A box outside which nothing solid lies; may be infinite, or empty for an empty scene.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// By how much the distance can change over a length of 1: 1, or more where joints are chamfered.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Slots that the stacks of values and of points need.
    pub fn stack_slots(&self) -> (usize, usize) {
        (self.value_slots, self.point_slots)
    }

    /// The number of visible brushes.
    pub fn brush_count(&self) -> usize {
        self.brushes
    }

    /// Bytes held by the program's tables.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.instructions[..])
            + size_of_val(&self.params[..])
            + size_of_val(&self.materials[..])
    }

    /// Most copies of a brush that are measured around one point, over all loops that it is in; 1 without any.
    pub fn max_copies(&self) -> u64 {
        let (mut most, mut open) = (1, vec![1u64]);
        for instr in &self.instructions {
            if let Some(copies) = self.copies_of(instr) {
                let around = open.last().copied().unwrap_or(1);
                open.push(around.saturating_mul(copies));
                most = most.max(around.saturating_mul(copies));
            } else if instr.op == abi::OP_NEXT {
                open.pop();
            }
        }
        most
    }

    /// How many copies a loop looks at, if an instruction begins one.
    pub(crate) fn copies_of(&self, instr: &Instruction) -> Option<u64> {
        let word = |i: u32| {
            let word = self.params.get((instr.params + i) as usize);
            word.copied().unwrap_or(0.0) as u64
        };
        match instr.op {
            abi::OP_REPEAT => Some(word(12) * word(13) * word(14)),
            abi::OP_RADIAL => Some(word(2)),
            _ => None,
        }
    }
}
