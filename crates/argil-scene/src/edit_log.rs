//! Edits as lines of text. A log can be replayed on an equal scene, in another process or on another machine.
//!
//! Each line is one JSON object. Nodes are named by their current paths, such as `brushes[3].brushes[0]`:
//!
//! ```text
//! {"edit": "insert", "into": "brushes[2]", "index": 0, "entry": {"shape": {"type": "sphere", "radius": 0.1}}}
//! {"edit": "transform", "node": "brushes[2].brushes[0]", "by": {"type": "translate", "by": [0.1, 0, 0]}}
//! {"edit": "undo"}
//! ```

use crate::file::{Item, explain_line};
use crate::{
    Action, Edit, EditOutcome, LogError, Material, Modifier, NodeDesc, NodeId, NodeKind, NodeTree,
    Operator, Scene, View,
};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A line of a log.
#[derive(Serialize, Deserialize)]
#[serde(
    tag = "edit",
    rename_all = "snake_case",
    deny_unknown_fields,
    expecting = "an object with an \"edit\""
)]
enum LogLine {
    Insert {
        /// The group. The root if it is missing.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        into: String,
        /// The end of the group if it is missing.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        index: Option<usize>,
        entry: Box<NodeTree>,
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
        /// Removes the material if it is missing.
        #[serde(default)]
        material: Option<Material>,
    },
    SetView {
        view: Box<View>,
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
    fn into_entry(self) -> (NodeDesc, Vec<Item>) {
        let operator = Operator {
            kind: self.operator,
            blend: self.blend,
            profile: self.profile,
            morph_amount: self.amount,
        };
        let entry = NodeDesc {
            name: self.name,
            visible: self.visible,
            locked: self.locked,
            operator,
            ramp: self.ramp,
            modifiers: self.modifiers,
            material: self.material,
            keyframes: self.keyframes,
            kind: self.shape.map_or(NodeKind::Group, NodeKind::Shape),
        };
        (entry, self.brushes.unwrap_or_default())
    }

    fn of(entry: &NodeDesc) -> Self {
        let (shape, brushes) = match &entry.kind {
            NodeKind::Shape(shape) => (Some(shape.clone()), None),
            NodeKind::Group => (None, Some(Vec::new())),
        };
        Self {
            name: entry.name.clone(),
            visible: entry.visible,
            locked: entry.locked,
            operator: entry.operator.kind,
            blend: entry.operator.blend,
            profile: entry.operator.profile,
            amount: entry.operator.morph_amount,
            ramp: entry.ramp.clone(),
            material: entry.material.clone(),
            modifiers: entry.modifiers.clone(),
            keyframes: entry.keyframes.clone(),
            shape,
            brushes,
        }
    }
}

impl From<Item> for NodeTree {
    fn from(item: Item) -> Self {
        let (entry, inner) = item.into_entry();
        Self {
            desc: entry,
            children: inner.into_iter().map(Self::from).collect(),
        }
    }
}

impl From<&NodeTree> for Item {
    fn from(tree: &NodeTree) -> Self {
        let mut item = Self::of(&tree.desc);
        if let Some(brushes) = &mut item.brushes {
            brushes.extend(tree.children.iter().map(Self::from));
        }
        item
    }
}

/// Serializes as a brush or group of a scene file.
impl Serialize for NodeTree {
    fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        Item::from(self).serialize(out)
    }
}

/// Deserializes from a brush or group of a scene file.
impl<'de> Deserialize<'de> for NodeTree {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Item::deserialize(from).map(Self::from)
    }
}

impl Scene {
    /// Returns the node at a path, as [`Scene::path`] writes it. The root's path is empty.
    pub fn node_by_path(&self, path: &str) -> Option<NodeId> {
        let mut at = Self::ROOT;
        for step in path.split('.').filter(|_| !path.is_empty()) {
            let index = step.strip_prefix("brushes[")?.strip_suffix(']')?;
            at = *self.node(at).children.get(index.parse::<usize>().ok()?)?;
        }
        Some(at)
    }

    /// Performs the action on a line of a log. Returns what it changed, or `None` if it changes no geometry.
    ///
    /// # Errors
    /// If the line is invalid, or the action is refused. The scene stays unchanged.
    pub fn apply_log_line(&mut self, line: &str) -> Result<Option<EditOutcome>, LogError> {
        let action = self.read_action(line)?;
        self.perform(&action)
    }

    /// Reads the action on a line of a log, for the scene's current paths.
    ///
    /// # Errors
    /// If the line is invalid, or names a node that does not exist.
    pub fn read_action(&self, line: &str) -> Result<Action, LogError> {
        let node_of = |path: &str| {
            let node = self.node_by_path(path);
            node.ok_or_else(|| LogError::NoSuchPath(path.to_owned()))
        };
        let read = serde_json::from_slice(line.as_bytes());
        Ok(
            match read.or_else(|error| deep_insert(line).ok_or_else(|| fault_of(line, error)))? {
                LogLine::Insert { into, index, entry } => {
                    let parent = node_of(&into)?;
                    let index = index.unwrap_or(self.node(parent).children.len());
                    let tree = *entry;
                    Action::InsertTree {
                        parent,
                        index,
                        tree,
                    }
                }
                LogLine::Remove { node } => Action::Edit(Edit::Remove {
                    node: node_of(&node)?,
                }),
                LogLine::Replace { node, entry } => {
                    let node = node_of(&node)?;
                    let (entry, inner) = entry.into_entry();
                    if !inner.is_empty() {
                        return Err(LogError::Inner);
                    }
                    Action::Edit(Edit::Replace { node, desc: entry })
                }
                LogLine::Move { node, into, index } => Action::Edit(Edit::Move {
                    node: node_of(&node)?,
                    parent: node_of(&into)?,
                    index,
                }),
                LogLine::SetVisible { node, visible } => Action::Edit(Edit::SetVisible {
                    node: node_of(&node)?,
                    visible,
                }),
                LogLine::Transform { node, by } => Action::Edit(Edit::Transform {
                    node: node_of(&node)?,
                    by,
                }),
                LogLine::SetMaterial { name, material } => {
                    Action::Edit(Edit::SetMaterial { name, material })
                }
                LogLine::SetView { view } => Action::Edit(Edit::SetView { view }),
                LogLine::RenameMeshes { paths } => Action::RenameMeshes(paths),
                LogLine::BeginStroke {} => Action::BeginStroke,
                LogLine::EndStroke {} => Action::EndStroke,
                LogLine::Undo {} => Action::Undo,
                LogLine::Redo {} => Action::Redo,
            },
        )
    }

    /// Writes an action as a line of a log, without line end. Call it before the action is performed, because
    /// actions change paths.
    pub fn action_line(&self, action: &Action) -> String {
        let line = match action {
            Action::Edit(edit) => self.line_of(edit),
            Action::InsertTree {
                parent,
                index,
                tree,
            } => {
                let (into, index) = (self.path(*parent), *index);
                if tree.depth() > MAX_PLAIN_DEPTH {
                    return deep_line(&into, index, tree);
                }
                LogLine::Insert {
                    into,
                    index: Some(index),
                    entry: Box::new(tree.clone()),
                }
            }
            Action::RenameMeshes(paths) => LogLine::RenameMeshes {
                paths: paths.clone(),
            },
            Action::BeginStroke => LogLine::BeginStroke {},
            Action::EndStroke => LogLine::EndStroke {},
            Action::Undo => LogLine::Undo {},
            Action::Redo => LogLine::Redo {},
        };
        text_of(&line)
    }

    /// Writes an edit as a line of a log: see [`Scene::action_line`].
    pub fn log_line(&self, edit: &Edit) -> String {
        text_of(&self.line_of(edit))
    }

    fn line_of(&self, edit: &Edit) -> LogLine {
        match edit {
            Edit::Insert {
                parent,
                index,
                desc: entry,
            } => LogLine::Insert {
                into: self.path(*parent),
                index: Some(*index),
                entry: Box::new(entry.clone().into()),
            },
            Edit::Remove { node } => LogLine::Remove {
                node: self.path(*node),
            },
            Edit::Replace { node, desc: entry } => LogLine::Replace {
                node: self.path(*node),
                entry: Box::new(Item::of(entry)),
            },
            Edit::Move {
                node,
                parent,
                index,
            } => LogLine::Move {
                node: self.path(*node),
                into: self.path(*parent),
                index: *index,
            },
            Edit::SetVisible { node, visible } => LogLine::SetVisible {
                node: self.path(*node),
                visible: *visible,
            },
            Edit::Transform { node, by } => LogLine::Transform {
                node: self.path(*node),
                by: by.clone(),
            },
            Edit::SetMaterial { name, material } => LogLine::SetMaterial {
                name: name.clone(),
                material: material.clone(),
            },
            Edit::SetView { view } => LogLine::SetView { view: view.clone() },
        }
    }
}

/// Returns the error of a line: what serde says of its syntax, or the place of what is wrong, with the nearest right name.
fn fault_of(line: &str, error: serde_json::Error) -> LogError {
    if error.is_data() {
        let (column, fault) = explain_line::<LogLine>(line, &error);
        return LogError::Value { column, fault };
    }
    LogError::Line(error)
}

/// Groups that nest deeper are read and written as scene files are, without recursion.
const MAX_PLAIN_DEPTH: usize = 50;

/// An insertion whose entry is still text.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DeepInsert<'a> {
    edit: Cow<'a, str>,
    #[serde(default)]
    into: Cow<'a, str>,
    #[serde(default)]
    index: Option<usize>,
    #[serde(borrow)]
    entry: Cow<'a, RawValue>,
}

/// Reads an insertion of groups that nest deeper than a parser's stack, or `None` if the line is something else.
fn deep_insert(line: &str) -> Option<LogLine> {
    let line: DeepInsert<'_> = serde_json::from_slice(line.as_bytes()).ok()?;
    let tree = crate::file::read_tree(line.entry.get())?;
    (line.edit == "insert").then(|| LogLine::Insert {
        into: line.into.into_owned(),
        index: line.index,
        entry: Box::new(tree),
    })
}

/// Writes an insertion of groups that nest deeper than a serializer's stack.
fn deep_line(into: &str, index: usize, tree: &NodeTree) -> String {
    let text = crate::file::tree_text(tree);
    serde_json::to_string(&DeepInsert {
        edit: "insert".into(),
        into: into.into(),
        index: Some(index),
        entry: Cow::Owned(text),
    })
    .expect("entries are JSON")
}

fn text_of(line: &LogLine) -> String {
    serde_json::to_string(line).expect("entries are JSON")
}
