//! Edits as lines of text: a log that can be replayed on the same scene, here or on another machine.
//!
//! Each line is one JSON object. Nodes are named by their paths at that moment, `brushes[3].brushes[0]`:
//!
//! ```text
//! {"edit": "insert", "into": "brushes[2]", "index": 0, "entry": {"shape": {"type": "sphere", "radius": 0.1}}}
//! {"edit": "transform", "node": "brushes[2].brushes[0]", "by": {"type": "translate", "by": [0.1, 0, 0]}}
//! {"edit": "undo"}
//! ```

use crate::file::Item;
use crate::{Body, Edit, EditError, Edited, Entry, Material, Modifier, NodeId, Operator, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A line of a log.
#[derive(Serialize, Deserialize)]
#[serde(tag = "edit", rename_all = "snake_case", deny_unknown_fields)]
enum Line {
    Insert {
        /// The group; the root without it.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        into: String,
        /// At its end without it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        index: Option<usize>,
        entry: Box<Item>,
    },
    Remove {
        node: String,
    },
    Replace {
        node: String,
        entry: Box<Item>,
    },
    Move {
        node: String,
        #[serde(default, skip_serializing_if = "String::is_empty")]
        into: String,
        index: usize,
    },
    SetVisible {
        node: String,
        visible: bool,
    },
    Transform {
        node: String,
        by: Modifier,
    },
    SetMaterial {
        name: String,
        /// Nothing takes it away.
        #[serde(default)]
        material: Option<Material>,
    },
    /// See [`Scene::rename_meshes`].
    RenameMeshes {
        paths: BTreeMap<String, String>,
    },
    BeginStroke {},
    EndStroke {},
    Undo {},
    Redo {},
}

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
    /// Something to be inserted is a brush and a group at once.
    #[error("a brush has a \"shape\" and a group has \"brushes\": this has both")]
    Both,
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

/// Refuse to put something into a brush.
fn check_group(entry: &Entry) -> Result<(), LogError> {
    match entry.body {
        Body::Group => Ok(()),
        Body::Shape(_) => Err(LogError::Both),
    }
}

impl Item {
    fn into_entry(self) -> (Entry, Vec<Item>) {
        let operator = Operator {
            kind: self.operator,
            blend: self.blend,
            profile: self.profile,
            amount: self.amount,
        };
        let entry = Entry {
            name: self.name,
            visible: self.visible,
            locked: self.locked,
            operator,
            modifiers: self.modifiers,
            material: self.material,
            keyframes: self.keyframes,
            body: self.shape.map_or(Body::Group, Body::Shape),
        };
        (entry, self.brushes.unwrap_or_default())
    }

    fn of(entry: &Entry) -> Self {
        let (shape, brushes) = match &entry.body {
            Body::Shape(shape) => (Some(shape.clone()), None),
            Body::Group => (None, Some(Vec::new())),
        };
        Self {
            name: entry.name.clone(),
            visible: entry.visible,
            locked: entry.locked,
            operator: entry.operator.kind,
            blend: entry.operator.blend,
            profile: entry.operator.profile,
            amount: entry.operator.amount,
            material: entry.material.clone(),
            modifiers: entry.modifiers.clone(),
            keyframes: entry.keyframes.clone(),
            shape,
            brushes,
        }
    }
}

/// Whether a line is an edit, and not a word on the history.
fn is_edit(line: &str) -> Result<bool, LogError> {
    Ok(!matches!(
        serde_json::from_slice(line.as_bytes())?,
        Line::Undo {}
            | Line::Redo {}
            | Line::BeginStroke {}
            | Line::EndStroke {}
            | Line::RenameMeshes { .. }
    ))
}

impl Scene {
    /// The node of a path, as [`Scene::path`] writes it; the root's is empty.
    pub fn find(&self, path: &str) -> Option<NodeId> {
        let mut at = Self::ROOT;
        for step in path.split('.').filter(|_| !path.is_empty()) {
            let index = step.strip_prefix("brushes[")?.strip_suffix(']')?;
            at = *self.node(at).children.get(index.parse::<usize>().ok()?)?;
        }
        Some(at)
    }

    /// Do what a line of a log says; what that did, of what changes something.
    ///
    /// # Errors
    /// If the line cannot be read or done. Nothing is changed then.
    pub fn replay(&mut self, line: &str) -> Result<Option<Edited>, LogError> {
        let node_of = |scene: &Self, path: &str| {
            scene
                .find(path)
                .ok_or_else(|| LogError::NoSuchPath(path.to_owned()))
        };
        let edit = match serde_json::from_slice(line.as_bytes())? {
            Line::Insert { into, index, entry } => {
                let parent = node_of(self, &into)?;
                return self.insert_all(parent, index, *entry).map(Some);
            }
            Line::Remove { node } => Edit::Remove {
                node: node_of(self, &node)?,
            },
            Line::Replace { node, entry } => {
                let node = node_of(self, &node)?;
                let (entry, inner) = entry.into_entry();
                if !inner.is_empty() {
                    return Err(LogError::Inner);
                }
                Edit::Replace { node, entry }
            }
            Line::Move { node, into, index } => Edit::Move {
                node: node_of(self, &node)?,
                parent: node_of(self, &into)?,
                index,
            },
            Line::SetVisible { node, visible } => Edit::SetVisible {
                node: node_of(self, &node)?,
                visible,
            },
            Line::Transform { node, by } => Edit::Transform {
                node: node_of(self, &node)?,
                by,
            },
            Line::SetMaterial { name, material } => Edit::SetMaterial { name, material },
            Line::RenameMeshes { paths } => {
                self.rename_meshes(&paths);
                return Ok(None);
            }
            Line::BeginStroke {} => {
                self.begin_stroke();
                return Ok(None);
            }
            Line::EndStroke {} => {
                self.end_stroke();
                return Ok(None);
            }
            Line::Undo {} => return self.undo_edit().map(Some).ok_or(LogError::NothingToUndo),
            Line::Redo {} => return self.redo_edit().map(Some).ok_or(LogError::NothingToRedo),
        };
        Ok(Some(self.apply(edit)?))
    }

    /// [`Scene::replay`] of a line, unless a check of the scene as it then is refuses it; the check is told the node that was made or
    /// changed. Only edits are checked: what undo and redo bring back was there before.
    ///
    /// # Errors
    /// As there, or what the check says. Nothing is changed then: neither the scene nor what can be undone and redone.
    pub fn replay_checked<E: std::error::Error + Send + Sync + 'static>(
        &mut self,
        line: &str,
        check: impl FnOnce(&Self, NodeId) -> Result<(), E>,
    ) -> Result<Option<Edited>, LogError> {
        if !is_edit(line)? {
            return self.replay(line);
        }
        let before = self.set_history_aside();
        let done = self.replay(line);
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
    fn insert_all(
        &mut self,
        parent: NodeId,
        index: Option<usize>,
        item: Item,
    ) -> Result<Edited, LogError> {
        let (entry, inner) = item.into_entry();
        let index = index.unwrap_or(self.node(parent).children.len());
        let insert = |entry, parent, index| Edit::Insert {
            parent,
            index,
            entry,
        };
        if inner.is_empty() {
            return Ok(self.apply(insert(entry, parent, index))?);
        }
        // Whether all of it can be done is known before any of it is.
        let mut pending: Vec<&Item> = inner.iter().collect();
        check_group(&entry)?;
        self.check_entry(&entry)?;
        while let Some(item) = pending.pop() {
            let own = item.clone().into_entry().0;
            self.check_entry(&own)?;
            let held = item.brushes.as_deref().unwrap_or_default();
            if !held.is_empty() {
                check_group(&own)?;
            }
            pending.extend(held);
        }
        let is_stroke = self.is_stroke();
        if !is_stroke {
            self.begin_stroke();
        }
        let made = self.insert_each(insert(entry, parent, index), inner);
        if !is_stroke {
            self.end_stroke();
        }
        made
    }

    /// Insert a group, and then what it holds.
    fn insert_each(&mut self, group: Edit, inner: Vec<Item>) -> Result<Edited, LogError> {
        let made = self.apply(group)?;
        let mut all = made;
        let mut open = vec![(made.node, inner)];
        while let Some((parent, items)) = open.pop() {
            for (index, item) in items.into_iter().enumerate() {
                let (entry, inner) = item.into_entry();
                let own = self.apply(Edit::Insert {
                    parent,
                    index,
                    entry,
                })?;
                all.dirty_box = all.dirty_box.union(own.dirty_box);
                open.push((own.node, inner));
            }
        }
        Ok(all)
    }

    /// An edit as a line of a log, without the line's end. To be asked before the edit is done, as it may move nodes.
    pub fn log_line(&self, edit: &Edit) -> String {
        let line = match edit {
            Edit::Insert {
                parent,
                index,
                entry,
            } => Line::Insert {
                into: self.path(*parent),
                index: Some(*index),
                entry: Box::new(Item::of(entry)),
            },
            Edit::Remove { node } => Line::Remove {
                node: self.path(*node),
            },
            Edit::Replace { node, entry } => Line::Replace {
                node: self.path(*node),
                entry: Box::new(Item::of(entry)),
            },
            Edit::Move {
                node,
                parent,
                index,
            } => Line::Move {
                node: self.path(*node),
                into: self.path(*parent),
                index: *index,
            },
            Edit::SetVisible { node, visible } => Line::SetVisible {
                node: self.path(*node),
                visible: *visible,
            },
            Edit::Transform { node, by } => Line::Transform {
                node: self.path(*node),
                by: by.clone(),
            },
            Edit::SetMaterial { name, material } => Line::SetMaterial {
                name: name.clone(),
                material: *material,
            },
        };
        serde_json::to_string(&line).expect("entries are JSON")
    }
}
