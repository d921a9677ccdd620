//! Stores a scene's nodes. Clones share them until one of them changes.

use crate::Node;
use crate::node::GONE;
use std::ops::{Index, IndexMut};
use std::sync::Arc;

/// Nodes that are copied together when one of them changes in a clone.
const CHUNK: usize = 64;

/// Nodes by index. The root is in a chunk by itself, because its list of children may be long.
#[derive(Clone, Debug)]
pub(crate) struct NodeStore {
    root: Arc<Node>,
    chunks: Vec<Arc<Vec<Node>>>,
    len: usize,
}

impl NodeStore {
    /// Creates a store with a root.
    pub(crate) fn of(root: Node) -> Self {
        Self {
            root: Arc::new(root),
            chunks: Vec::new(),
            len: 1,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn get(&self, index: usize) -> Option<&Node> {
        (index < self.len).then(|| &self[index])
    }

    pub(crate) fn push(&mut self, node: Node) {
        if (self.len - 1).is_multiple_of(CHUNK) {
            self.chunks.push(Arc::new(Vec::with_capacity(CHUNK)));
        }
        if let Some(last) = self.chunks.last_mut() {
            Arc::make_mut(last).push(node);
            self.len += 1;
        }
    }

    /// Lets all chunks of nodes that are gone be one, so that a long session takes no memory for them.
    pub(crate) fn share_gone(&mut self) {
        let is_gone =
            |chunk: &[Node]| chunk.len() == CHUNK && chunk.iter().all(|node| node.origin == GONE);
        let mut shared: Option<Arc<Vec<Node>>> = None;
        for chunk in self.chunks.iter_mut().filter(|chunk| is_gone(chunk)) {
            *chunk = shared.get_or_insert_with(|| chunk.clone()).clone();
        }
    }

    /// Keeps the first nodes, including the root.
    pub(crate) fn truncate(&mut self, len: usize) {
        let len = len.clamp(1, self.len);
        self.chunks.truncate((len - 1).div_ceil(CHUNK));
        let rest = (len - 1) % CHUNK;
        if let Some(last) = self.chunks.last_mut().filter(|_| rest > 0) {
            Arc::make_mut(last).truncate(rest);
        }
        self.len = len;
    }
}

impl Index<usize> for NodeStore {
    type Output = Node;

    #[inline]
    fn index(&self, index: usize) -> &Node {
        match index.checked_sub(1) {
            Some(at) => &self.chunks[at / CHUNK][at % CHUNK],
            None => &self.root,
        }
    }
}

impl IndexMut<usize> for NodeStore {
    #[inline]
    fn index_mut(&mut self, index: usize) -> &mut Node {
        match index.checked_sub(1) {
            Some(at) => &mut Arc::make_mut(&mut self.chunks[at / CHUNK])[at % CHUNK],
            None => Arc::make_mut(&mut self.root),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Brush, Shape};

    fn node(index: usize) -> Node {
        let entry = Brush::new(Shape::sphere(1.0)).with_name(format!("{index}"));
        Node {
            desc: entry.into(),
            ..Node::gone()
        }
    }

    #[test]
    fn clones_share_what_neither_changes() {
        let mut store = NodeStore::of(Node::root());
        for index in 1..300 {
            store.push(node(index));
        }
        let clone = store.clone();
        store[130].desc.name = "another".into();
        store.push(node(300));
        assert_eq!((store.len(), clone.len()), (301, 300));
        assert_eq!(
            (&*store[130].desc.name, &*clone[130].desc.name),
            ("another", "130")
        );
        let shared = store.chunks.iter().zip(&clone.chunks);
        let shared = shared.filter(|(a, b)| Arc::ptr_eq(a, b)).count();
        // But that of the change and that of the end.
        assert_eq!(shared, clone.chunks.len() - 2);
        for len in [300, 257, 256, 129, 65, 64, 2, 1] {
            store.truncate(len);
            assert_eq!(store.len(), len);
            assert!(store.get(len).is_none() && store.get(len - 1).is_some());
            store.push(node(7));
            assert_eq!(store[len].desc.name, "7");
            store.truncate(len);
        }
        assert!(clone.get(299).is_some_and(|node| node.desc.name == "299"));
    }
}
