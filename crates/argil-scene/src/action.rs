//! Changes of a scene as values: edits, inserted trees, undo and redo.
//!
//! *Practice.* A program that edits one scene and mirrors it elsewhere, such as an editor with a render thread,
//! sends actions. Equal scenes that perform the same actions in the same order stay equal, and give nodes the same
//! ids. [`Scene::action_line`] writes an action for a [journal](crate::Journal) or another machine.

use crate::history::HistoryStep;
use crate::{
    Edit, EditError, EditOutcome, NodeDesc, NodeId, NodeKind, NodeTree, Scene, ValidationError,
};
use std::collections::BTreeMap;

/// The reason why a line of an edit log was refused. The scene stays unchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The line is not a valid log line.
    #[error("{}", reason(.0))]
    Line(serde_json::Error),
    /// A field or a value of the line is wrong.
    #[error("{}", placed(*.column, .fault))]
    Value {
        /// Column in characters, from 1.
        column: u64,
        /// Path in the line, and what is wrong there.
        fault: ValidationError,
    },
    /// The line names a node that does not exist.
    #[error("the scene has no {0}")]
    NoSuchPath(String),
    /// The edit was refused.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The line replaces a group and changes its contents.
    #[error(
        "\"brushes\": a replaced group keeps its children: omit the key, or remove the group and insert a new one"
    )]
    Inner,
    /// The caller's own check refused it.
    #[error(transparent)]
    Refused(Box<dyn std::error::Error + Send + Sync>),
    /// There is nothing to undo.
    #[error("nothing to undo")]
    NothingToUndo,
    /// There is nothing to redo.
    #[error("nothing to redo")]
    NothingToRedo,
}

impl From<serde_json::Error> for LogError {
    fn from(error: serde_json::Error) -> Self {
        Self::Line(error)
    }
}

/// Returns serde's message with the column, where serde knows it. The line is always 1.
fn reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let reason = text.split(" at line ").next().unwrap_or(&text);
    match error.column() {
        0 => reason.to_owned(),
        column => format!("column {column}: {reason}"),
    }
}

/// Returns what is wrong with a part of a line, after its column, or with the whole.
fn placed(column: u64, fault: &ValidationError) -> String {
    match fault.path.is_empty() {
        true => fault.to_string(),
        false => format!("column {column}: {fault}"),
    }
}

/// A change of a scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Action {
    /// An edit of one node.
    Edit(Edit),
    /// Inserts a brush, or a group with its contents, as one undo step.
    InsertTree {
        /// The group to insert into.
        parent: NodeId,
        /// Index in the group, from 0 to its length.
        index: usize,
        /// The tree to insert.
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
    /// Whether this is an edit, and not undo, redo, a stroke or a renaming of meshes.
    pub fn is_edit(&self) -> bool {
        matches!(self, Self::Edit(_) | Self::InsertTree { .. })
    }

    /// Iterates over the descriptions that this action inserts.
    pub fn entries(&self) -> impl Iterator<Item = &NodeDesc> {
        let (one, tree) = match self {
            Self::Edit(Edit::Insert { desc: entry, .. } | Edit::Replace { desc: entry, .. }) => {
                (Some(entry), None)
            }
            Self::InsertTree { tree, .. } => (None, Some(tree)),
            _ => (None, None),
        };
        one.into_iter()
            .chain(tree.into_iter().flat_map(NodeTree::entries))
    }
}

/// Refuses brushes that have children.
fn check_group(tree: &NodeTree) -> Result<(), EditError> {
    match tree.desc.kind {
        NodeKind::Shape(_) if !tree.children.is_empty() => Err(EditError::BrushWithChildren),
        _ => Ok(()),
    }
}

impl Scene {
    /// Copies a node and everything in it.
    ///
    /// # Panics
    /// If `node` is not in the scene.
    pub fn subtree(&self, node: NodeId) -> NodeTree {
        NodeTree::copied(node, |node| {
            let node = self.node(node);
            (node.desc().clone(), node.children().iter().copied())
        })
    }

    /// Copies a node and everything in it, as keyframes have them at the scene's time.
    ///
    /// # Panics
    /// If `node` is not in the scene.
    pub fn subtree_at_current_time(&self, node: NodeId) -> NodeTree {
        NodeTree::copied(node, |node| {
            let node = self.node(node);
            (
                node.at_current_time().clone(),
                node.children().iter().copied(),
            )
        })
    }

    /// Performs an action. Returns what it changed, or `None` if it changes no geometry.
    ///
    /// # Errors
    /// If the action is refused. The scene stays unchanged.
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

    /// Performs an action, unless a check of the resulting scene refuses it. The check receives the node that was
    /// created or changed. Undo and redo are not checked, because they restore earlier states.
    ///
    /// # Errors
    /// If the action or the check refuses it. The scene and its history stay unchanged.
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

    /// Inserts a brush, or a group with its contents, as one undo step.
    pub(crate) fn insert_tree(
        &mut self,
        parent: NodeId,
        index: usize,
        tree: &NodeTree,
    ) -> Result<EditOutcome, EditError> {
        // Check everything before changing anything.
        let mut open = vec![tree];
        while let Some(subtree) = open.pop() {
            check_group(subtree)?;
            self.check_entry(&subtree.desc)?;
            open.extend(&subtree.children);
        }
        self.check_place(parent, index)?;
        let node = self.add_detached(tree);
        Ok(self.apply_step(HistoryStep::Attach {
            node,
            parent,
            index,
        }))
    }

    /// Creates the nodes of a tree, which belong to no group yet.
    fn add_detached(&mut self, tree: &NodeTree) -> NodeId {
        let loaded = |scene: &Self, tree: &NodeTree| {
            let mut desc = tree.desc.clone();
            scene.load(&mut desc);
            desc
        };
        let root = loaded(self, tree);
        let root = self.add_node(root, None);
        let mut open = vec![(root, &tree.children)];
        while let Some((parent, trees)) = open.pop() {
            for tree in trees {
                let desc = loaded(self, tree);
                open.push((self.append(parent, desc), &tree.children));
            }
        }
        root
    }
}
