use argil_scene::NodeId;
use std::ops::{Index, IndexMut};

/// A map from nodes whose ids are close together to values.
pub(crate) struct NodeMap<T> {
    first: usize,
    values: Vec<T>,
}

impl<T: Clone> NodeMap<T> {
    pub(crate) fn of(nodes: &[NodeId], value: T) -> Self {
        let ids = || nodes.iter().map(|id| id.index());
        let first = ids().min().unwrap_or(0);
        let end = ids().max().map_or(first, |last| last + 1);
        Self {
            first,
            values: vec![value; end - first],
        }
    }
}

impl<T> Index<NodeId> for NodeMap<T> {
    type Output = T;

    fn index(&self, id: NodeId) -> &T {
        &self.values[id.index() - self.first]
    }
}

impl<T> IndexMut<NodeId> for NodeMap<T> {
    fn index_mut(&mut self, id: NodeId) -> &mut T {
        &mut self.values[id.index() - self.first]
    }
}
