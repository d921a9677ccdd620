//! Brushes and groups at their places.

use crate::{Group, NodeDesc};

/// The name of a brush or group within its scene. It stays with the node through all edits, undo and redo included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId {
    pub(crate) index: u32,
    /// Of the scene that made the node, and of its clones; 0 of every root. A node of another scene is told by it.
    pub(crate) origin: u32,
}

impl NodeId {
    /// A number that counts up from 0 over all nodes that the scene ever held.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

/// A brush or group at its place.
#[derive(Clone, Debug)]
pub struct Node {
    pub(crate) desc: NodeDesc,
    /// As it acts at the scene's time, if it has keyframes.
    pub(crate) evaluated: Option<Box<NodeDesc>>,
    pub(crate) children: Vec<NodeId>,
    pub(crate) parent: Option<NodeId>,
    /// See [`NodeId`].
    pub(crate) origin: u32,
}

/// Of nodes that nothing can bring back.
pub(crate) const GONE: u32 = u32::MAX;

impl Node {
    /// The root of a scene.
    pub(crate) fn root() -> Self {
        Self {
            desc: Group::new().into(),
            evaluated: None,
            children: Vec::new(),
            parent: None,
            origin: 0,
        }
    }

    /// In the place of a node that nothing can bring back.
    pub(crate) fn gone() -> Self {
        Self {
            origin: GONE,
            ..Self::root()
        }
    }

    /// What the node is.
    pub fn desc(&self) -> &NodeDesc {
        &self.desc
    }

    /// What it is at the scene's time: with the values of its keyframes in place of its own.
    pub fn at_current_time(&self) -> &NodeDesc {
        self.evaluated.as_deref().unwrap_or(&self.desc)
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

pub(crate) fn pose_of(entry: &NodeDesc, time: f32) -> Option<Box<NodeDesc>> {
    let moves = !entry.keyframes.is_empty();
    moves.then(|| Box::new(entry.evaluated_at(time)))
}
