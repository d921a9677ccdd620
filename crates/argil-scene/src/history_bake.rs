//! Replaces a scene's oldest entries by samples of their solid, so that games can dig for hours.

use crate::history::HistoryStep;
use crate::{Brush, NodeDesc, NodeId, NodeTree, Scene, SceneChange};
use std::collections::HashSet;
use std::sync::Arc;

/// The solid of a scene's oldest entries as sampled brushes, which can take their place: see [`Scene::fold_history`].
///
/// `argil::bake_history` creates one.
#[derive(Clone, Debug)]
pub struct HistoryBake {
    /// A scene of only these entries, as they were sampled.
    oldest: Scene,
    brushes: Vec<Brush>,
}

/// The reason why a [`HistoryBake`] cannot be folded into a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FoldError {
    /// An entry is not as it was when it was sampled.
    #[error("{0} changed since the history was baked: bake it again")]
    Changed(String),
    /// The new brushes use a material that the scene does not have, or are not valid.
    #[error("a baked brush was refused: bake the history again")]
    Refused(#[from] crate::EditError),
}

impl HistoryBake {
    /// Creates a bake from a scene of the oldest entries, as [`Scene::oldest_entries`] returns it, and the brushes that have their
    /// solid.
    pub fn new(oldest: Scene, brushes: Vec<Brush>) -> Self {
        Self { oldest, brushes }
    }

    /// Returns the number of entries that the bake replaces.
    pub fn entry_count(&self) -> usize {
        self.oldest.node(Scene::ROOT).children.len()
    }

    /// Returns the brushes that take their place.
    pub fn brushes(&self) -> &[Brush] {
        &self.brushes
    }
}

impl Scene {
    /// Returns a scene of only the first `count` entries of the root, or of all if there are fewer. It shares nodes with this one, and
    /// has no history.
    #[must_use]
    pub fn oldest_entries(&self, count: usize) -> Self {
        let mut oldest = self.snapshot();
        if count < oldest.node(Self::ROOT).children.len() {
            oldest.nodes[Self::ROOT.index()].children.truncate(count);
        }
        oldest
    }

    /// Replaces the scene's oldest entries by samples of their solid. This is no edit: undo and redo end here, for everything that
    /// touched these entries. Later edits of other entries can still be undone. An open stroke goes on as another step. Worlds of the scene are built again, within a
    /// budget on another thread. It is no [`Action`](crate::Action), either: a [replica](Scene::replica) has to fold, too.
    ///
    /// `argil::bake_history` has an example.
    ///
    /// # Errors
    /// If one of these entries changed since the bake. The scene stays unchanged.
    pub fn fold_history(&mut self, bake: &HistoryBake) -> Result<(), FoldError> {
        self.check_unchanged(bake)?;
        let brushes = bake.brushes.iter().cloned().map(NodeTree::from);
        let brushes: Vec<NodeTree> = brushes.collect();
        for brush in &brushes {
            self.check_entry(&brush.desc)?;
        }
        let is_stroke = self.history.is_stroke;
        self.end_stroke();
        let count = bake.entry_count();
        let old: HashSet<NodeId> = bake.oldest.iter().filter(|&id| id != Self::ROOT).collect();
        let fold = Fold {
            old: &old,
            before: count,
            after: brushes.len(),
        };
        self.history.redo.clear();
        let mut is_later =
            |steps: &mut Vec<HistoryStep>| steps.iter_mut().all(|step| fold.follow(step));
        let newest_first = self.history.undo.iter_mut().rev();
        let steps = newest_first
            .map(&mut is_later)
            .take_while(|&is_later| is_later)
            .count();
        let new: Vec<NodeId> = brushes
            .iter()
            .map(|brush| self.add_node(brush.desc.clone(), Some(Self::ROOT)))
            .collect();
        let entries = &mut self.nodes[Self::ROOT.index()].children;
        for id in entries.splice(..count, new).collect::<Vec<_>>() {
            self.nodes[id.index()].parent = None;
        }
        self.summaries.clear();
        // Their nodes are gone.
        self.history.forget_changes();
        self.history.note(SceneChange::of_everything());
        self.drop_history(steps);
        if is_stroke {
            self.begin_stroke();
        }
        Ok(())
    }

    /// Checks that the first entries are those of a bake, as they were.
    fn check_unchanged(&self, bake: &HistoryBake) -> Result<(), FoldError> {
        let oldest = &bake.oldest;
        let entries = &self.node(Self::ROOT).children;
        let sampled = &oldest.node(Self::ROOT).children;
        for (index, &entry) in sampled.iter().enumerate() {
            let is_same = |id: NodeId| {
                let then = oldest.node(id);
                self.get(id).is_some_and(|now| {
                    now.desc == then.desc
                        && now.children == then.children
                        && have_same_samples(&now.desc, &then.desc)
                })
            };
            if entries.get(index) != Some(&entry) || !oldest.descendants(entry).all(is_same) {
                return Err(FoldError::Changed(format!("brushes[{index}]")));
            }
        }
        Ok(())
    }
}

/// Whether two shapes of one file have the same samples of it.
fn have_same_samples(a: &NodeDesc, b: &NodeDesc) -> bool {
    let samples = |desc: &NodeDesc| desc.kind.file().and_then(|(.., grid)| grid.0.clone());
    match (samples(a), samples(b)) {
        (Some(a), Some(b)) => Arc::ptr_eq(&a, &b) || a == b,
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// The root's first `before` entries, which contain the nodes in `old`, become `after` brushes.
struct Fold<'a> {
    old: &'a HashSet<NodeId>,
    before: usize,
    after: usize,
}

impl Fold<'_> {
    /// Lets a step of undo follow. Returns false if it touches what is no longer there.
    fn follow(&self, step: &mut HistoryStep) -> bool {
        match step {
            HistoryStep::Attach {
                node,
                parent,
                index,
            }
            | HistoryStep::Move {
                node,
                parent,
                index,
            } => {
                let is_in_root = *parent == Scene::ROOT;
                let is_later = !is_in_root || *index >= self.before;
                if is_in_root {
                    *index = self.after + index.saturating_sub(self.before);
                }
                is_later && !self.old.contains(parent) && !self.old.contains(node)
            }
            HistoryStep::Detach { node } | HistoryStep::Set { node, .. } => {
                !self.old.contains(node)
            }
            HistoryStep::SetMaterial { .. } | HistoryStep::SetView { .. } => true,
        }
    }
}
