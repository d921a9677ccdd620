//! What is done to a scene, as values: edits, whole groups that are put in, words on the history.
//!
//! *Practice.* A program that edits one scene and follows it elsewhere, as an editor with a renderer beside it, sends actions: done on
//! equal scenes in the same order, they give equal scenes, with the same ids of nodes. [`Scene::action_line`] writes one for a
//! [journal](crate::Journal) or another machine.

use crate::{Edit, EditError, EditOutcome, NodeDesc, NodeId, NodeKind, NodeTree, Scene};
use std::collections::BTreeMap;

/// Why a line of a log was refused. The scene is as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// It is not one of the lines that there are.
    #[error("{}", reason(.0))]
    Line(serde_json::Error),
    /// It names a node that is not there.
    #[error("the scene has no {0}")]
    NoSuchPath(String),
    /// The edit cannot be done.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A replaced group would have other contents.
    #[error(
        "\"brushes\": a group that is replaced keeps what it holds: leave them out, or remove it and insert another"
    )]
    Inner,
    /// Whoever asked for it has refused it.
    #[error(transparent)]
    Refused(Box<dyn std::error::Error + Send + Sync>),
    /// There is nothing to undo.
    #[error("there is nothing to undo")]
    NothingToUndo,
    /// There is nothing to redo.
    #[error("there is nothing to redo")]
    NothingToRedo,
}

impl From<serde_json::Error> for LogError {
    fn from(error: serde_json::Error) -> Self {
        Self::Line(error)
    }
}

/// serde's message with the column, where that is known: of what is read by its tag it is not. The line is always 1.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let reason = text.split(" at line ").next().unwrap_or(&text);
    match error.column() {
        0 => reason.to_owned(),
        column => format!("column {column}: {reason}"),
    }
}

/// Something that is done to a scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Action {
    /// An edit.
    Edit(Edit),
    /// Put a brush, or a group with all that it holds, into a group as one step.
    InsertTree {
        /// The group.
        parent: NodeId,
        /// Where in the group, from 0 to its length.
        index: usize,
        /// What to put there.
        tree: NodeTree,
    },
    /// See [`Scene::rename_meshes`].
    RenameMeshes(BTreeMap<String, String>),
    /// See [`Scene::begin_stroke`].
    BeginStroke,
    /// See [`Scene::end_stroke`].
    EndStroke,
    /// See [`Scene::undo`].
    Undo,
    /// See [`Scene::redo`].
    Redo,
}

impl Action {
    /// Whether it is an edit, and not a word on the history or on files.
    pub fn is_edit(&self) -> bool {
        matches!(self, Self::Edit(_) | Self::InsertTree { .. })
    }

    /// The entries that it puts into the scene.
    pub fn entries(&self) -> impl Iterator<Item = &NodeDesc> {
        let (one, tree) = match self {
            Self::Edit(Edit::Insert { entry, .. } | Edit::Replace { entry, .. }) => {
                (Some(entry), None)
            }
            Self::InsertTree { tree, .. } => (None, Some(tree)),
            _ => (None, None),
        };
        one.into_iter()
            .chain(tree.into_iter().flat_map(NodeTree::entries))
    }
}

/// Refuse to put something into a brush.
fn check_group(tree: &NodeTree) -> Result<(), EditError> {
    match tree.desc.kind {
        NodeKind::Shape(_) if !tree.children.is_empty() => Err(EditError::BrushWithChildren),
        _ => Ok(()),
    }
}

impl Scene {
    /// A node with all that it holds.
    ///
    /// # Panics
    /// If `node` is not in the scene.
    pub fn subtree(&self, node: NodeId) -> NodeTree {
        let alone = |node: NodeId| NodeTree {
            desc: self.node(node).desc().clone(),
            children: Vec::new(),
        };
        // Those that are not whole yet, the innermost last, with the children that they lack, the next last.
        let lacking = |node: NodeId| self.node(node).children().iter().rev().copied().collect();
        let mut open: Vec<(NodeTree, Vec<NodeId>)> = vec![(alone(node), lacking(node))];
        loop {
            let (_, next) = open.last_mut().expect("the outermost is taken last");
            if let Some(child) = next.pop() {
                open.push((alone(child), lacking(child)));
            } else if let Some((whole, _)) = open.pop() {
                match open.last_mut() {
                    Some((around, _)) => around.children.push(whole),
                    None => return whole,
                }
            }
        }
    }

    /// Do an action; what that did, of one that changes something.
    ///
    /// # Errors
    /// If it cannot be done. Nothing is changed then.
    pub fn perform(&mut self, action: &Action) -> Result<Option<EditOutcome>, LogError> {
        match action {
            Action::Edit(edit) => Ok(Some(self.apply(edit.clone())?)),
            Action::InsertTree {
                parent,
                index,
                tree,
            } => Ok(Some(self.insert_tree(*parent, *index, tree)?)),
            Action::RenameMeshes(paths) => {
                self.rename_meshes(paths);
                Ok(None)
            }
            Action::BeginStroke => {
                self.begin_stroke();
                Ok(None)
            }
            Action::EndStroke => {
                self.end_stroke();
                Ok(None)
            }
            Action::Undo => self.undo().map(Some).ok_or(LogError::NothingToUndo),
            Action::Redo => self.redo().map(Some).ok_or(LogError::NothingToRedo),
        }
    }

    /// [`Scene::perform`], unless a check of the scene as it then is refuses it; the check is told the node that was made or
    /// changed. Only edits are checked: what undo and redo bring back was there before.
    ///
    /// # Errors
    /// As there, or what the check says. Nothing is changed then: neither the scene nor what can be undone and redone.
    pub fn perform_checked<E: std::error::Error + Send + Sync + 'static>(
        &mut self,
        action: &Action,
        check: impl FnOnce(&Self, NodeId) -> Result<(), E>,
    ) -> Result<Option<EditOutcome>, LogError> {
        if !action.is_edit() {
            return self.perform(action);
        }
        let before = self.set_history_aside();
        let done = self.perform(action);
        let checked = match &done {
            Ok(Some(edited)) => {
                check(self, edited.node).map_err(|fault| LogError::Refused(Box::new(fault)))
            }
            _ => Ok(()),
        };
        self.join_history(before, done.is_ok() && checked.is_ok());
        checked.and(done)
    }

    /// Insert a brush, or a group with all that it holds as one step.
    pub(crate) fn insert_tree(
        &mut self,
        parent: NodeId,
        index: usize,
        tree: &NodeTree,
    ) -> Result<EditOutcome, EditError> {
        let group = Edit::Insert {
            parent,
            index,
            entry: tree.desc.clone(),
        };
        // Whether all of it can be done is known before any of it is.
        let mut open = vec![tree];
        while let Some(own) = open.pop() {
            check_group(own)?;
            self.check_entry(&own.desc)?;
            open.extend(&own.children);
        }
        if tree.children.is_empty() {
            return self.apply(group);
        }
        let is_stroke = self.is_stroke();
        if !is_stroke {
            self.begin_stroke();
        }
        let made = self.insert_each(group, &tree.children);
        if !is_stroke {
            self.end_stroke();
        }
        made
    }

    /// Insert a group, and then what it holds.
    fn insert_each(&mut self, group: Edit, inner: &[NodeTree]) -> Result<EditOutcome, EditError> {
        let made = self.apply(group)?;
        let mut all = made;
        let mut open = vec![(made.node, inner)];
        while let Some((parent, trees)) = open.pop() {
            for (index, tree) in trees.iter().enumerate() {
                let own = self.apply(Edit::Insert {
                    parent,
                    index,
                    entry: tree.desc.clone(),
                })?;
                all.dirty_box = all.dirty_box.union(own.dirty_box);
                open.push((own.node, &tree.children));
            }
        }
        Ok(all)
    }
}
