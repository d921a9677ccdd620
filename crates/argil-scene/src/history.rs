//! What can be undone and redone, and what changed for those who follow a scene.

use crate::{Material, NodeDesc, NodeId, SceneChange};

/// A step that can be taken either way.
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
    },
}

impl HistoryStep {
    /// What it takes in memory, about.
    pub(crate) fn bytes(&self) -> u64 {
        let own = match self {
            Self::Set { entry, .. } => {
                let text = entry.name.len() + entry.material.as_ref().map_or(0, String::len);
                let keyframes = size_of_val(&entry.keyframes[..]);
                text + size_of_val(&entry.modifiers[..]) + keyframes + entry.kind.heap_bytes()
            }
            _ => 0,
        };
        (size_of::<Self>() + own) as u64
    }
}

/// How much of its history a scene keeps.
///
/// ```
/// use argil_scene::{HistoryLimit, Scene};
/// let mut scene = Scene::new();
/// scene.set_history_limit(HistoryLimit { steps: 200, ..HistoryLimit::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HistoryLimit {
    /// Steps that can be undone.
    pub steps: usize,
    /// Bytes that those take, about.
    pub bytes: u64,
}

impl Default for HistoryLimit {
    /// No limit.
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
    /// Whether edits join the step before them.
    pub is_stroke: bool,
    pub(crate) limit: HistoryLimit,
    /// What the steps take that can be undone, about.
    pub(crate) bytes: u64,
    pub(crate) changes: Vec<SceneChange>,
    /// Changes before those that are forgotten.
    pub(crate) forgotten: usize,
}

impl History {
    /// The entries that undo and redo would bring back.
    pub(crate) fn entries(&mut self) -> impl Iterator<Item = &mut NodeDesc> {
        let all = self.undo.iter_mut().chain(&mut self.redo).flatten();
        all.filter_map(|step| match step {
            HistoryStep::Set { entry, .. } => Some(entry),
            _ => None,
        })
    }
}

/// Whether undoing `before` makes up for `step` too: both set the same node.
pub(crate) fn is_covered(before: Option<&HistoryStep>, step: &HistoryStep) -> bool {
    match (before, step) {
        (Some(HistoryStep::Set { node: a, .. }), HistoryStep::Set { node: b, .. }) => a == b,
        (
            Some(HistoryStep::SetMaterial { name: a, .. }),
            HistoryStep::SetMaterial { name: b, .. },
        ) => a == b,
        _ => false,
    }
}

/// Changes that a scene keeps for those who follow it; of more the older half is forgotten.
const MAX_CHANGES: usize = 1 << 14;

impl History {
    /// Take note of a change.
    pub(crate) fn note(&mut self, change: SceneChange) {
        if self.changes.len() >= MAX_CHANGES {
            self.changes.drain(..MAX_CHANGES / 2);
            self.forgotten += MAX_CHANGES / 2;
        }
        self.changes.push(change);
    }

    /// Keep the last so many steps.
    pub(crate) fn keep(&mut self, keep: usize) {
        let steps = self.undo.len().saturating_sub(keep);
        self.undo.drain(..steps);
        self.bytes = self.bytes_of_steps().iter().sum();
    }

    /// Set a limit; how many steps can stay.
    pub(crate) fn set_limit(&mut self, limit: HistoryLimit) -> usize {
        self.limit = limit;
        self.bytes = self.bytes_of_steps().iter().sum();
        if self.undo.len() > limit.steps || self.bytes > limit.bytes {
            self.steps_within_limit()
        } else {
            self.undo.len()
        }
    }

    /// Whether there is more than the limit allows, now that a step of so many bytes was added.
    pub(crate) fn is_over_limit(&mut self, added: u64) -> bool {
        self.bytes += added;
        if self.bytes > self.limit.bytes {
            // What was undone since is counted still.
            self.bytes = self.bytes_of_steps().iter().sum();
        }
        self.undo.len() > self.limit.steps.max(1) || self.bytes > self.limit.bytes
    }

    /// How many of the last steps are within three quarters of the limit, so that steps are not dropped one by one; one at least.
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

    /// Removed nodes that undo or redo can bring back.
    pub(crate) fn held_nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        let all = self.undo.iter().chain(&self.redo).flatten();
        all.filter_map(|step| match step {
            HistoryStep::Attach { node, .. }
            | HistoryStep::Detach { node }
            | HistoryStep::Set { node, .. }
            | HistoryStep::Move { node, .. } => Some(*node),
            HistoryStep::SetMaterial { .. } => None,
        })
    }

    /// Forget the changes after so many: they were taken back before anybody could see them.
    pub(crate) fn forget_changes_after(&mut self, count: usize) {
        self.forgotten = self.forgotten.min(count);
        self.changes.truncate(count - self.forgotten);
    }

    /// How many changes there were.
    pub(crate) fn count(&self) -> usize {
        self.forgotten + self.changes.len()
    }

    /// Those after so many.
    pub(crate) fn since(&self, count: usize) -> Option<&[SceneChange]> {
        self.changes.get(count.checked_sub(self.forgotten)?..)
    }
}

/// A history as it was before an edit that may be refused yet.
pub(crate) struct SuspendedHistory {
    pub(crate) undo: Vec<Vec<HistoryStep>>,
    pub(crate) redo: Vec<Vec<HistoryStep>>,
    pub(crate) limit: HistoryLimit,
    pub(crate) is_stroke: bool,
    /// Nodes, and changes, that there were.
    pub(crate) nodes: usize,
    pub(crate) changes: usize,
}
