//! Undo and redo of a scene.

use crate::history::{HistoryStep, SuspendedHistory, is_covered};
use crate::node::GONE;
use crate::{EditOutcome, HistoryLimit, Node, Scene};

impl Scene {
    /// Suspends the history, so that the next edits can be reversed without a trace.
    pub(crate) fn set_history_aside(&mut self) -> SuspendedHistory {
        let (nodes, changes) = (self.nodes.len(), self.history.count());
        let history = &mut self.history;
        let aside = SuspendedHistory {
            nodes,
            changes,
            undo: std::mem::take(&mut history.undo),
            redo: std::mem::take(&mut history.redo),
            limit: std::mem::take(&mut history.limit),
            is_stroke: history.is_stroke,
        };
        if aside.is_stroke {
            history.undo.push(Vec::new());
        }
        aside
    }

    /// Restores a suspended history. It either appends the steps since then, or reverses them.
    pub(crate) fn join_history(&mut self, aside: SuspendedHistory, is_kept: bool) {
        let mut new = std::mem::take(&mut self.history.undo);
        if !is_kept {
            let steps: Vec<HistoryStep> = new.drain(..).flatten().collect();
            for step in steps.into_iter().rev() {
                self.take(step);
            }
            self.nodes.truncate(aside.nodes);
            self.summaries
                .retain(|group, _| group.index() < aside.nodes);
            self.history.forget_changes_after(aside.changes);
        }
        let is_empty = new.iter().all(Vec::is_empty);
        let history = &mut self.history;
        history.undo = aside.undo;
        history.limit = aside.limit;
        history.is_stroke = aside.is_stroke;
        if is_empty {
            history.redo = aside.redo;
            return;
        }
        match history.undo.last_mut().filter(|_| aside.is_stroke) {
            Some(stroke) => {
                for step in new.into_iter().flatten() {
                    if !is_covered(stroke.last(), &step) {
                        stroke.push(step);
                    }
                }
            }
            None => history.undo.extend(new),
        }
        self.keep_to_limit(0);
    }

    /// Begins a stroke: until [`Scene::end_stroke`], all edits form one undo step.
    pub fn begin_stroke(&mut self) {
        self.end_stroke();
        self.history.undo.push(Vec::new());
        self.history.is_stroke = true;
    }

    /// Ends a stroke. A stroke that changed nothing leaves no step.
    pub fn end_stroke(&mut self) {
        let history = &mut self.history;
        if std::mem::take(&mut history.is_stroke) && history.undo.last().is_some_and(Vec::is_empty)
        {
            history.undo.pop();
        }
    }

    /// Returns the number of steps that can be undone.
    pub fn undo_depth(&self) -> usize {
        self.history.undo.len()
    }

    /// Returns the number of steps that can be redone.
    pub fn redo_depth(&self) -> usize {
        self.history.redo.len()
    }

    /// Limits the undo history. The oldest steps are dropped first, and the newest step always stays.
    pub fn set_history_limit(&mut self, limit: HistoryLimit) {
        self.end_stroke();
        let steps = self.history.set_limit(limit);
        if steps < self.history.undo.len() {
            self.drop_history(steps);
        }
    }

    /// Drops all but the last `keep` undo steps, and all redo steps, to free their memory.
    pub fn forget_history(&mut self, keep: usize) {
        self.end_stroke();
        self.history.redo.clear();
        self.drop_history(keep);
    }

    /// Drops all but the last steps, and the contents of removed nodes that nothing can restore.
    pub(super) fn drop_history(&mut self, keep: usize) {
        self.history.keep(keep);
        let mut is_needed = vec![false; self.nodes.len()];
        let roots = self.history.held_nodes().collect::<Vec<_>>();
        for root in std::iter::once(Self::ROOT).chain(roots) {
            // The contents of a visited tree were visited with it.
            if !is_needed[root.index()] {
                let nodes = self.descendants(root);
                nodes.for_each(|node| is_needed[node.index()] = true);
            }
        }
        for (i, _) in is_needed.iter().enumerate().filter(|(_, needed)| !**needed) {
            // What is gone may be shared.
            if self.nodes[i].origin != GONE {
                self.nodes[i] = Node::gone();
            }
        }
        self.nodes.share_gone();
    }

    /// Undoes the last step, which is one edit or one stroke. Returns what changed, or `None` if there is nothing to undo.
    pub fn undo(&mut self) -> Option<EditOutcome> {
        self.end_stroke();
        let steps = self.history.undo.pop()?;
        let (edited, inverse) = self.take_all(steps)?;
        self.history.redo.push(inverse);
        Some(edited)
    }

    /// Redoes the step that was undone last. Returns what changed, or `None` if there is nothing to redo.
    pub fn redo(&mut self) -> Option<EditOutcome> {
        self.end_stroke();
        let steps = self.history.redo.pop()?;
        let (edited, inverse) = self.take_all(steps)?;
        self.history.undo.push(inverse);
        Some(edited)
    }

    /// Takes the steps of one undo or redo, last first.
    fn take_all(&mut self, steps: Vec<HistoryStep>) -> Option<(EditOutcome, Vec<HistoryStep>)> {
        let mut all: Option<EditOutcome> = None;
        let mut inverses = Vec::with_capacity(steps.len());
        for step in steps.into_iter().rev() {
            let (edited, inverse) = self.take(step);
            inverses.push(inverse);
            all = Some(EditOutcome {
                dirty_box: all.map_or(edited.dirty_box, |a| a.dirty_box.union(edited.dirty_box)),
                ..edited
            });
        }
        Some((all?, inverses))
    }
}
