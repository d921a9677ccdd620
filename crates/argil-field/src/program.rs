use argil_abi::{Instr, MaterialWords};
use argil_math::Aabb;

/// A scene lowered to instructions. See the crate's page.
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) instrs: Vec<Instr>,
    pub(crate) params: Vec<f32>,
    pub(crate) materials: Vec<MaterialWords>,
    pub(crate) aabb: Aabb,
    pub(crate) lipschitz: f32,
    pub(crate) slack: f32,
    pub(crate) value_slots: usize,
    pub(crate) point_slots: usize,
    pub(crate) brushes: usize,
}

impl Program {
    /// The instructions, for the GPU's table.
    pub fn instrs(&self) -> &[Instr] {
        &self.instrs
    }

    /// The words that instructions point into.
    pub fn params(&self) -> &[f32] {
        &self.params
    }

    /// The materials that brushes point at; never empty.
    pub fn materials(&self) -> &[MaterialWords] {
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
        size_of_val(&self.instrs[..])
            + size_of_val(&self.params[..])
            + size_of_val(&self.materials[..])
    }
}
