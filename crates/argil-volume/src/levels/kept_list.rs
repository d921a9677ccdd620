//! A kept program of a page.

use argil_abi::Instruction;
use std::sync::Arc;

/// The pruned program of a page, and the last frame that used it.
#[derive(Clone, Debug)]
pub(super) struct KeptList {
    pub instructions: Arc<[Instruction]>,
    pub frame: u32,
}
