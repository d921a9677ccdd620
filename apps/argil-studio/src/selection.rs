//! Selected and locked nodes of a document.

use crate::document::Document;
use argil::scene::{NodeId, Scene};
use std::collections::BTreeSet;

impl Document {
    /// Returns true if a node is in the scene.
    pub fn has(&self, node: NodeId) -> bool {
        let mut at = node;
        while let Some(parent) = self.scene.node(at).parent() {
            at = parent;
        }
        at == Scene::ROOT
    }

    pub(crate) fn forget_removed(&mut self) {
        let mut selection = std::mem::take(&mut self.selection);
        selection.retain(|&node| self.has(node));
        self.selection = selection;
    }

    /// Returns the node that was selected last.
    pub fn active(&self) -> Option<NodeId> {
        self.selection.last().copied()
    }

    /// Selects one node or, with `also`, adds it to the selection.
    pub fn select(&mut self, node: Option<NodeId>, also: bool) {
        if !also {
            self.selection.clear();
        }
        let Some(node) = node else { return };
        match self.selection.iter().position(|&n| n == node) {
            Some(at) => drop(self.selection.remove(at)),
            None => self.selection.push(node),
        }
    }

    /// Returns selected nodes without selected ancestors, in scene order.
    pub fn outermost(&self) -> Vec<NodeId> {
        let selected: BTreeSet<NodeId> = self.selection.iter().copied().collect();
        let is_within = |node: NodeId| {
            let mut at = self.scene.node(node).parent();
            while let Some(parent) = at {
                if selected.contains(&parent) {
                    return true;
                }
                at = self.scene.node(parent).parent();
            }
            false
        };
        let chosen = |node: &NodeId| selected.contains(node) && !is_within(*node);
        if let [one] = self.selection[..]
            && self.has(one)
        {
            return vec![one];
        }
        self.scene.iter().filter(chosen).collect()
    }

    /// Locks or unlocks nodes. Locked nodes cannot be picked or changed.
    ///
    /// # Errors
    /// If a node is no longer in the scene.
    pub fn lock(&mut self, nodes: &[NodeId], locked: bool) -> anyhow::Result<()> {
        let word = if locked { "Lock" } else { "Unlock" };
        self.begin_stroke(word);
        for &node in nodes {
            let mut entry = self.scene.node(node).desc().clone();
            entry.locked = locked;
            self.replace(word, node, entry)?;
        }
        self.end_stroke();
        Ok(())
    }

    /// Returns true if a node, or a group that contains it, is locked.
    pub fn is_locked(&self, node: NodeId) -> bool {
        let mut at = Some(node);
        while let Some(n) = at {
            if self.scene.node(n).desc().locked {
                return true;
            }
            at = self.scene.node(n).parent();
        }
        false
    }
}
