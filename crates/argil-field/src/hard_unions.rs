//! Finds programs of which all joints are hard unions.
//!
//! *Theory.* Such a distance is the least of those of the brushes. So a list of its brushes can begin with any upper bound of
//! the distance, and groups can begin with what is before them. The result has the same bits. Thousands of instances are
//! skipped then that are farther than the nearest one, and not only those that come after it.

use crate::Program;
use crate::eval_brush::BrushParams;
use crate::interpreter_state::words;
use argil_abi as abi;

impl Program {
    /// Finds whether all joints are hard unions.
    pub(crate) fn joints_are_hard_unions(&self) -> bool {
        self.instructions.iter().all(|instr| match instr.op {
            op if op < abi::OP_SHAPES_END => {
                let joint = BrushParams::read(&self.params, instr.params as usize).joint;
                joint.is_hard_union()
            }
            abi::OP_COMBINE => {
                let &[k, _, sa, sb, sr] = words(&self.params, instr.params as usize);
                let is_smooth = instr.flags & abi::COMBINE_MASK == abi::COMBINE_SMOOTH;
                is_smooth && k == 0.0 && [sa, sb, sr] == [1.0; 3]
            }
            abi::OP_PUSH_VALUE | abi::OP_PUSH_POINT | abi::OP_POP_POINT | abi::OP_AFFINE => true,
            _ => false,
        })
    }
}
