//! A scene's history: what is undone and redone, and who follows its changes.

use crate::Scene;
use crate::history::{Aside, Step, is_covered};

impl Scene {
    /// Sets the history aside, so that what comes next can be taken back without a trace.
    pub(crate) fn set_history_aside(&mut self) -> Aside {
        let (nodes, changes) = (self.nodes.len(), self.history.count());
        let history = &mut self.history;
        let aside = Aside {
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

    /// Puts the history back, with what was done since behind it, or with that taken back.
    pub(crate) fn join_history(&mut self, aside: Aside, is_kept: bool) {
        let mut new = std::mem::take(&mut self.history.undo);
        if !is_kept {
            let steps: Vec<Step> = new.drain(..).flatten().collect();
            for step in steps.into_iter().rev() {
                self.take(step);
            }
            self.nodes.truncate(aside.nodes);
            self.crowds.retain(|group, _| group.index() < aside.nodes);
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
}
