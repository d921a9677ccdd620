//! Pruned lists of blocks, kept from one edit to the next.
//!
//! *Theory.* Pruning leaves the value before each joint as it was, to the bit, in all of a block. So a list that was pruned gives the
//! block's distances still when operands are put behind all others, and behind it. A brush that is added where thousands have
//! been before then costs what is near the surface, not what ever was there.
//!
//! *Practice.* Each part has a log of what was put behind all others since its first list was kept, and each list a place in it. Any
//! other update forgets the lists of the parts that it touches.

use argil_abi::Instr;
use glam::IVec3;
use rustc_hash::FxHashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Instructions that are kept at most: of more, all are forgotten.
const MOST_INSTRS: usize = 1 << 21;
/// Instructions of a part's log at most.
const MOST_LOGGED: usize = 1 << 12;
/// What a list lacks at most to be of use.
const MOST_BEHIND: usize = 64;

#[derive(Default)]
struct PartLists {
    /// By block: a list, and how much of the log it holds.
    lists: FxHashMap<IVec3, (Vec<Instr>, usize)>,
    log: Vec<Instr>,
    /// The log's length before the last update.
    before: usize,
}

#[derive(Default)]
struct Kept {
    parts: FxHashMap<IVec3, PartLists>,
    /// Parts to whose logs the last update has added.
    added: Vec<IVec3>,
    instrs: usize,
}

/// A block's list that was kept.
pub struct KeptList {
    /// What gives the block's distances now.
    pub now: Vec<Instr>,
    /// How much of it gave them before the last update.
    pub before: usize,
}

/// See the module's page. Blocks are named by whoever asks, within parts of a [`LiveProgram`](crate::LiveProgram).
#[derive(Default)]
pub struct ListCache(Mutex<Kept>);

impl ListCache {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        // What is half done by a thread that panicked is at worst a list that is missing.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the lists of blocks of a part out, where there are some.
    pub fn take(&self, part: IVec3, blocks: &[IVec3]) -> Vec<Option<KeptList>> {
        let mut kept = self.kept();
        let Kept { parts, instrs, .. } = &mut *kept;
        let Some(own) = parts.get_mut(&part) else {
            return blocks.iter().map(|_| None).collect();
        };
        let taken = blocks.iter().map(|block| {
            let (mut now, seen) = own.lists.remove(block)?;
            *instrs -= now.len();
            if own.log.len() - seen > MOST_BEHIND {
                return None;
            }
            let before = now.len() + own.before.saturating_sub(seen);
            now.extend_from_slice(&own.log[seen..]);
            let before = before.min(now.len());
            Some(KeptList { now, before })
        });
        taken.collect()
    }

    /// Keeps lists of blocks of a part, as they are after the last update.
    pub fn keep(&self, part: IVec3, lists: impl IntoIterator<Item = (IVec3, Vec<Instr>)>) {
        let mut kept = self.kept();
        if kept.instrs > MOST_INSTRS {
            *kept = Kept::default();
        }
        let Kept { parts, instrs, .. } = &mut *kept;
        let own = parts.entry(part).or_default();
        for (block, list) in lists {
            *instrs += list.len();
            if let Some((old, _)) = own.lists.insert(block, (list, own.log.len())) {
                *instrs -= old.len();
            }
        }
    }

    /// An update begins.
    pub(crate) fn begin(&self) {
        let mut kept = self.kept();
        let Kept { parts, added, .. } = &mut *kept;
        for part in added.drain(..) {
            if let Some(own) = parts.get_mut(&part) {
                own.before = own.log.len();
            }
        }
    }

    /// Something was put behind all others that can matter in a part.
    pub(crate) fn append(&self, part: IVec3, instrs: &[Instr]) {
        let mut kept = self.kept();
        let Kept { parts, added, .. } = &mut *kept;
        let Some(own) = parts.get_mut(&part) else {
            return;
        };
        own.log.extend_from_slice(instrs);
        added.push(part);
        if own.log.len() > MOST_LOGGED {
            drop(kept);
            self.forget(part);
        }
    }

    pub(crate) fn forget(&self, part: IVec3) {
        let mut kept = self.kept();
        if let Some(own) = kept.parts.remove(&part) {
            kept.instrs -= own
                .lists
                .values()
                .map(|(list, _)| list.len())
                .sum::<usize>();
        }
    }

    pub(crate) fn clear(&self) {
        *self.kept() = Kept::default();
    }
}
