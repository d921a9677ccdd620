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
use crate::{
    Action, Body, Edit, Edited, Entry, LogError, Material, Modifier, NodeId, Operator, Scene,
    Subtree,
};
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

impl From<Item> for Subtree {
    fn from(item: Item) -> Self {
        let (entry, inner) = item.into_entry();
        Self {
            entry,
            children: inner.into_iter().map(Self::from).collect(),
        }
    }
}

impl From<&Subtree> for Item {
    fn from(tree: &Subtree) -> Self {
        let mut item = Self::of(&tree.entry);
        if let Some(brushes) = &mut item.brushes {
            brushes.extend(tree.children.iter().map(Self::from));
        }
        item
    }
}

/// As a brush or group of a scene's file.
impl Serialize for Subtree {
    fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        Item::from(self).serialize(out)
    }
}

/// As a brush or group of a scene's file.
impl<'de> Deserialize<'de> for Subtree {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Item::deserialize(from).map(Self::from)
    }
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
        let action = self.read_action(line)?;
        self.perform(&action)
    }

    /// What a line of a log says, of the scene as it is.
    ///
    /// # Errors
    /// If the line cannot be read, or names what is not there.
    pub fn read_action(&self, line: &str) -> Result<Action, LogError> {
        let node_of = |path: &str| {
            let found = self.find(path);
            found.ok_or_else(|| LogError::NoSuchPath(path.to_owned()))
        };
        Ok(match serde_json::from_slice(line.as_bytes())? {
            Line::Insert { into, index, entry } => {
                let parent = node_of(&into)?;
                let index = index.unwrap_or(self.node(parent).children.len());
                let tree = Subtree::from(*entry);
                Action::InsertTree {
                    parent,
                    index,
                    tree,
                }
            }
            Line::Remove { node } => Action::Edit(Edit::Remove {
                node: node_of(&node)?,
            }),
            Line::Replace { node, entry } => {
                let node = node_of(&node)?;
                let (entry, inner) = entry.into_entry();
                if !inner.is_empty() {
                    return Err(LogError::Inner);
                }
                Action::Edit(Edit::Replace { node, entry })
            }
            Line::Move { node, into, index } => Action::Edit(Edit::Move {
                node: node_of(&node)?,
                parent: node_of(&into)?,
                index,
            }),
            Line::SetVisible { node, visible } => Action::Edit(Edit::SetVisible {
                node: node_of(&node)?,
                visible,
            }),
            Line::Transform { node, by } => Action::Edit(Edit::Transform {
                node: node_of(&node)?,
                by,
            }),
            Line::SetMaterial { name, material } => {
                Action::Edit(Edit::SetMaterial { name, material })
            }
            Line::RenameMeshes { paths } => Action::RenameMeshes(paths),
            Line::BeginStroke {} => Action::BeginStroke,
            Line::EndStroke {} => Action::EndStroke,
            Line::Undo {} => Action::Undo,
            Line::Redo {} => Action::Redo,
        })
    }

    /// An action as a line of a log, without the line's end. To be asked before it is done, as it may move nodes.
    pub fn action_line(&self, action: &Action) -> String {
        let line = match action {
            Action::Edit(edit) => self.line_of(edit),
            Action::InsertTree {
                parent,
                index,
                tree,
            } => Line::Insert {
                into: self.path(*parent),
                index: Some(*index),
                entry: Box::new(Item::from(tree)),
            },
            Action::RenameMeshes(paths) => Line::RenameMeshes {
                paths: paths.clone(),
            },
            Action::BeginStroke => Line::BeginStroke {},
            Action::EndStroke => Line::EndStroke {},
            Action::Undo => Line::Undo {},
            Action::Redo => Line::Redo {},
        };
        text_of(&line)
    }

    /// An edit as a line of a log, as [`Scene::action_line`] writes it.
    pub fn log_line(&self, edit: &Edit) -> String {
        text_of(&self.line_of(edit))
    }

    fn line_of(&self, edit: &Edit) -> Line {
        match edit {
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
        }
    }
}

fn text_of(line: &Line) -> String {
    serde_json::to_string(line).expect("entries are JSON")
}
