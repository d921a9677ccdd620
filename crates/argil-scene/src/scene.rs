use crate::edit::History;
use crate::{Body, Entry, Fault, Group, Material, View};
use std::collections::BTreeMap;

/// The name of a brush or group within its scene. It stays with the node through all edits, undo and redo included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// A number that counts up from 0 over all nodes that the scene ever held.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A brush or group at its place.
#[derive(Clone, Debug)]
pub struct Node {
    pub(crate) entry: Entry,
    pub(crate) children: Vec<NodeId>,
    pub(crate) parent: Option<NodeId>,
}

impl Node {
    /// What the node is.
    pub fn entry(&self) -> &Entry {
        &self.entry
    }

    /// What a group holds, in order; nothing for a brush.
    pub fn children(&self) -> &[NodeId] {
        &self.children
    }

    /// The group around the node; `None` for the root, and for what was removed.
    pub fn parent(&self) -> Option<NodeId> {
        self.parent
    }
}

/// An ordered list of brushes and groups, with materials and a way to look at them. See the crate's page.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) nodes: Vec<Node>,
    pub(crate) materials: BTreeMap<String, Material>,
    pub(crate) history: History,
    pub(crate) band: f32,
    /// A name for people.
    pub name: String,
    /// Where the scene or its parts come from.
    pub credit: String,
    /// How the scene is meant to be looked at.
    pub view: View,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// The group that holds everything.
    pub const ROOT: NodeId = NodeId(0);

    /// A scene with nothing in it.
    pub fn new() -> Self {
        Self {
            nodes: vec![Node {
                entry: Group::new().into(),
                children: Vec::new(),
                parent: None,
            }],
            materials: BTreeMap::new(),
            history: History::default(),
            band: 0.1,
            name: String::new(),
            credit: String::new(),
            view: View::default(),
        }
    }

    /// A node by its id. Ids of another scene may panic.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// One more than the greatest [`NodeId::index`].
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The materials by name.
    pub fn materials(&self) -> &BTreeMap<String, Material> {
        &self.materials
    }

    /// Add or change a material. Not part of the history.
    pub fn set_material(
        &mut self,
        name: impl Into<String>,
        material: Material,
    ) -> Result<(), Fault> {
        let name = name.into();
        material.check().map_err(|f| f.within(&name))?;
        self.materials.insert(name, material);
        Ok(())
    }

    /// The distance, in the scene's unit, below which the dirty boxes of edits promise to hold every change.
    pub fn band(&self) -> f32 {
        self.band
    }

    /// Set the distance that dirty boxes allow for; a volume sets its narrow band.
    pub fn set_band(&mut self, band: f32) {
        self.band = band.max(0.0);
    }

    /// All nodes in the tree, each before what it holds, in the file's order. No recursion: depth costs heap only.
    pub fn walk(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.walk_from(Self::ROOT)
    }

    /// A node and all that it holds, each before what it holds.
    pub fn walk_from(&self, id: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        let mut pending = vec![id];
        std::iter::from_fn(move || {
            let id = pending.pop()?;
            pending.extend(self.node(id).children.iter().rev());
            Some(id)
        })
    }

    /// The number of brushes, hidden ones included.
    pub fn brush_count(&self) -> usize {
        self.walk()
            .filter(|&id| matches!(self.node(id).entry.body, Body::Shape(_)))
            .count()
    }

    /// The path of a node as files and messages name it, `brushes[3].brushes[0]`; empty for the root.
    pub fn path(&self, id: NodeId) -> String {
        let mut steps = Vec::new();
        let mut at = id;
        while let Some(parent) = self.node(at).parent {
            let index = self
                .node(parent)
                .children
                .iter()
                .position(|&c| c == at)
                .unwrap_or_default();
            steps.push(format!("brushes[{index}]"));
            at = parent;
        }
        steps.reverse();
        steps.join(".")
    }

    /// Put an entry at the end of a group without a check or a step in the history.
    pub(crate) fn append(&mut self, parent: NodeId, entry: Entry) -> NodeId {
        let id = NodeId(self.nodes.len() as u32);
        self.nodes.push(Node {
            entry,
            children: Vec::new(),
            parent: Some(parent),
        });
        self.nodes[parent.index()].children.push(id);
        id
    }
}

/// Scenes are equal when a file would hold the same: entries in order, materials, view; not ids or history.
impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        let same_settings = (&self.name, &self.credit, &self.view, &self.materials)
            == (&other.name, &other.credit, &other.view, &other.materials);
        let part = |scene: &Self, id: NodeId| {
            (scene.node(id).entry.clone(), scene.node(id).children.len())
        };
        same_settings
            && self.walk().count() == other.walk().count()
            && self
                .walk()
                .zip(other.walk())
                .all(|(a, b)| part(self, a) == part(other, b))
    }
}
