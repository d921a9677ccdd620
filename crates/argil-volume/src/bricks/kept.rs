//! Lists of blocks that edits have been in, kept for those that follow.
//!
//! *Theory.* A brush that matters in no cell of a block, since later ones have swallowed it, does not matter there either once
//! others are put behind all. So what a block's list must hold need not grow with the number of carves.
//!
//! *Practice.* A list holds what mattered in any cell of its block when that was last measured, and is asked for with what was put
//! behind it since. Any other edit lets all go.

use argil_abi::Instr;
use glam::IVec3;
use rustc_hash::FxHashMap;

/// Shorter lists are as soon put together.
const SHORT: usize = 32;
/// Most lists that are kept.
const MOST: usize = 1 << 14;

/// What of a program matters in a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct KeptList {
    pub instrs: Vec<Instr>,
    /// The rank of the program's last piece then.
    pub last: u64,
}

/// The kept lists, by the blocks' first cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct KeptLists(FxHashMap<IVec3, KeptList>);

impl KeptLists {
    pub fn get(&self, first: IVec3) -> Option<&KeptList> {
        self.0.get(&first)
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Keeps a list, in the place of a longer one.
    pub fn put(&mut self, first: IVec3, list: KeptList, longer: usize) {
        if longer <= SHORT {
            self.0.remove(&first);
            return;
        }
        if self.0.len() >= MOST {
            self.0.clear();
        }
        self.0.insert(first, list);
    }
}
