//! Undo and redo steps, and the record of changes for worlds.

use crate::{Material, NodeDesc, NodeId, SceneChange, View};

/// A step that can be taken and reversed.
#[derive(Clone, Debug)]
pub(crate) enum HistoryStep {
    Attach {
        node: NodeId,
        parent: NodeId,
        index: usize,
    },
    Detach {
        node: NodeId,
    },
    Set {
        node: NodeId,
        entry: NodeDesc,
    },
    Move {
        node: NodeId,
        parent: NodeId,
        index: usize,
    },
    SetMaterial {
        name: String,
        material: Option<Material>,
        /// Where it was among the materials, if it was removed.
        place: Option<usize>,
    },
    SetView {
        view: Box<View>,
    },
}

impl HistoryStep {
    /// Returns its approximate size in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let heap_bytes = match self {
            Self::Set { entry, .. } => {
                let text = entry.name.len() + entry.material.as_ref().map_or(0, String::len);
                let keyframes = size_of_val(&entry.keyframes[..]);
                let modifiers = entry.modifiers.iter();
                let modifiers =
                    modifiers.map(|modifier| size_of_val(modifier) + modifier.heap_bytes());
                text + modifiers.sum::<usize>() + keyframes + entry.kind.heap_bytes()
            }
            Self::SetView { view } => {
                size_of_val(&**view) + size_of_val(view.lights.as_deref().unwrap_or_default())
            }
            _ => 0,
        };
        (size_of::<Self>() + heap_bytes) as u64
    }
}

/// A limit on a scene's undo history.
///
/// ```
/// use argil_scene::{HistoryLimit, Scene};
/// let mut scene = Scene::new();
/// scene.set_history_limit(HistoryLimit { steps: 200, ..HistoryLimit::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HistoryLimit {
    /// Maximum number of steps.
    pub steps: usize,
    /// Maximum bytes of all steps, approximately.
    pub bytes: u64,
}

impl Default for HistoryLimit {
    /// Returns no limit.
    fn default() -> Self {
        Self {
            steps: usize::MAX,
            bytes: u64::MAX,
        }
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    pub undo: Vec<Vec<HistoryStep>>,
    pub redo: Vec<Vec<HistoryStep>>,
    /// Whether edits join the previous step.
    pub is_stroke: bool,
    pub(crate) limit: HistoryLimit,
    /// Approximate bytes of the steps that can be undone.
    pub(crate) bytes: u64,
    pub(crate) changes: Vec<SceneChange>,
    /// Number of changes that were dropped from the front.
    pub(crate) forgotten: usize,
}

impl History {
    /// Iterates over the descriptions that undo and redo would restore.
    pub(crate) fn entries(&mut self) -> impl Iterator<Item = &mut NodeDesc> {
        let all = self.undo.iter_mut().chain(&mut self.redo).flatten();
        all.filter_map(|step| match step {
            HistoryStep::Set { entry, .. } => Some(entry),
            _ => None,
        })
    }
}

/// Whether undoing `before` also undoes `step`, because both set the same node.
pub(crate) fn is_covered(before: Option<&HistoryStep>, step: &HistoryStep) -> bool {
    match (before, step) {
        (Some(HistoryStep::Set { node: a, .. }), HistoryStep::Set { node: b, .. }) => a == b,
        (
            Some(HistoryStep::SetMaterial { name: a, .. }),
            HistoryStep::SetMaterial { name: b, .. },
        ) => a == b,
        (Some(HistoryStep::SetView { .. }), HistoryStep::SetView { .. }) => true,
        _ => false,
    }
}

/// Maximum recorded changes. If there are more, the older half is dropped.
const MAX_CHANGES: usize = 1 << 14;

impl History {
    /// Records a change.
    pub(crate) fn note(&mut self, change: SceneChange) {
        if self.changes.len() >= MAX_CHANGES {
            self.changes.drain(..MAX_CHANGES / 2);
            self.forgotten += MAX_CHANGES / 2;
        }
        self.changes.push(change);
    }

    /// Keeps only the last steps.
    pub(crate) fn keep(&mut self, keep: usize) {
        let steps = self.undo.len().saturating_sub(keep);
        self.undo.drain(..steps);
        self.bytes = self.bytes_of_steps().iter().sum();
    }

    /// Sets a limit. Returns how many steps may stay.
    pub(crate) fn set_limit(&mut self, limit: HistoryLimit) -> usize {
        self.limit = limit;
        self.bytes = self.bytes_of_steps().iter().sum();
        if self.undo.len() > limit.steps || self.bytes > limit.bytes {
            self.steps_within_limit()
        } else {
            self.undo.len()
        }
    }

    /// Whether the history exceeds its limit, after a step of a number of bytes was added.
    pub(crate) fn is_over_limit(&mut self, added: u64) -> bool {
        self.bytes += added;
        if self.bytes > self.limit.bytes {
            // Counted again, because steps may have been undone since.
            self.bytes = self.bytes_of_steps().iter().sum();
        }
        self.undo.len() > self.limit.steps.max(1) || self.bytes > self.limit.bytes
    }

    /// Returns how many of the last steps fit into three quarters of the limit, and at least 1. Dropping several at
    /// once saves time.
    pub(crate) fn steps_within_limit(&self) -> usize {
        let sizes = self.bytes_of_steps();
        let mut left = self.limit.bytes - self.limit.bytes / 4;
        let mut fits = |&size: &u64| {
            let is_left = size <= left;
            left = left.saturating_sub(size);
            is_left
        };
        let by_bytes = sizes.iter().rev().take_while(|size| fits(size)).count();
        by_bytes.min(self.limit.steps - self.limit.steps / 4).max(1)
    }

    fn bytes_of_steps(&self) -> Vec<u64> {
        let steps = self.undo.iter();
        steps
            .map(|step| step.iter().map(HistoryStep::bytes).sum())
            .collect()
    }

    /// Iterates over removed nodes that undo or redo can restore.
    pub(crate) fn held_nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let all = self.undo.iter().chain(&self.redo).flatten();
        all.filter_map(|step| match step {
            HistoryStep::Attach { node, .. }
            | HistoryStep::Detach { node }
            | HistoryStep::Set { node, .. }
            | HistoryStep::Move { node, .. } => Some(*node),
            HistoryStep::SetMaterial { .. } | HistoryStep::SetView { .. } => None,
        })
    }

    /// Drops all changes so far. Whoever has not seen them sees that they are missing.
    pub(crate) fn forget_changes(&mut self) {
        self.forgotten = self.count();
        self.changes.clear();
    }

    /// Drops the changes after a count, which nobody has seen.
    pub(crate) fn forget_changes_after(&mut self, count: usize) {
        self.forgotten = self.forgotten.min(count);
        self.changes.truncate(count - self.forgotten);
    }

    /// Returns the number of changes so far.
    pub(crate) fn count(&self) -> usize {
        self.forgotten + self.changes.len()
    }

    /// Returns the changes after a count.
    pub(crate) fn since(&self, count: usize) -> Option<&[SceneChange]> {
        self.changes.get(count.checked_sub(self.forgotten)?..)
    }
}

/// A history before an edit that may still be refused.
pub(crate) struct SuspendedHistory {
    pub(crate) undo: Vec<Vec<HistoryStep>>,
    pub(crate) redo: Vec<Vec<HistoryStep>>,
    pub(crate) limit: HistoryLimit,
    pub(crate) is_stroke: bool,
    /// Number of nodes and changes at that time.
    pub(crate) nodes: usize,
    pub(crate) changes: usize,
}
