//! What is near a part.

use argil_abi::Instr;
use argil_math::Aabb;
use argil_scene::NodeId;

/// An operand where it can matter.
#[derive(Clone, Copy)]
pub(super) struct Near {
    pub rank: u64,
    pub node: NodeId,
    pub group: u32,
    /// Of an operand of one instruction, that: most are, and their records lie all over memory.
    pub instr: Option<Instr>,
    /// The box in which it can matter.
    pub held: Aabb,
}
