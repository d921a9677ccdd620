//! Brushes and groups in a scene.

use crate::{Group, NodeDesc};

/// Identifies a brush or group within its scene. It stays the same through all edits, including undo and redo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId {
    pub(crate) index: u32,
    /// Identifies the scene that created the node, and its clones. 0 for every root.
    pub(crate) origin: u32,
}

impl NodeId {
    /// Returns a number that counts from 0 over all nodes that the scene ever had.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

/// A brush or group in a scene.
#[derive(Clone, Debug)]
pub struct Node {
    pub(crate) desc: NodeDesc,
    /// Its description at the scene's time, if it has keyframes.
    pub(crate) evaluated: Option<Box<NodeDesc>>,
    pub(crate) children: Vec<NodeId>,
    pub(crate) parent: Option<NodeId>,
    /// See [`NodeId`].
    pub(crate) origin: u32,
}

/// Marks nodes that nothing can restore.
pub(crate) const GONE: u32 = u32::MAX;

impl Node {
    /// Creates the root of a scene.
    pub(crate) fn root() -> Self {
        Self {
            desc: Group::new().into(),
            evaluated: None,
            children: Vec::new(),
            parent: None,
            origin: 0,
        }
    }

    /// Replaces a node that nothing can restore.
    pub(crate) fn gone() -> Self {
        Self {
            origin: GONE,
            ..Self::root()
        }
    }

    /// Returns the node's description.
    pub fn desc(&self) -> &NodeDesc {
        &self.desc
    }

    /// Returns the description at the scene's time, with the values of its keyframes.
    pub fn at_current_time(&self) -> &NodeDesc {
        self.evaluated.as_deref().unwrap_or(&self.desc)
    }

    /// Returns the contents of a group in order. A brush has none.
    pub fn children(&self) -> &[NodeId] {
        &self.children
    }

    /// Returns the group around the node, or `None` for the root and for removed nodes.
    pub fn parent(&self) -> Option<NodeId> {
        self.parent
    }
}

pub(crate) fn pose_of(entry: &NodeDesc, time: f32) -> Option<Box<NodeDesc>> {
    let moves = !entry.keyframes.is_empty();
    moves.then(|| Box::new(entry.evaluated_at(time)))
}
