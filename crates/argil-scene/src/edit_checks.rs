//! Checks of edits.

use crate::{EditError, NodeDesc, NodeId, NodeKind, Scene};

impl Scene {
    /// Checks that `inner` is neither `node` nor inside it.
    pub(crate) fn check_outside(&self, inner: NodeId, node: NodeId) -> Result<(), EditError> {
        let mut at = Some(inner);
        while let Some(id) = at {
            if id == node {
                return Err(EditError::IntoItself(self.path(node)));
            }
            at = self.get(id).ok_or(EditError::NoSuchNode(id))?.parent;
        }
        Ok(())
    }

    pub(crate) fn check_unused(&self, name: &str) -> Result<(), EditError> {
        if !self.materials.contains_key(name) {
            return Err(EditError::NoSuchMaterial(name.into()));
        }
        let uses = |id: &NodeId| self.node(*id).desc.material.as_deref() == Some(name);
        match self.iter().find(uses) {
            Some(user) => Err(EditError::MaterialInUse {
                name: name.into(),
                user: self.path(user),
            }),
            None => Ok(()),
        }
    }

    /// Checks that a node is in the scene, and is not the root.
    pub(crate) fn check_inner(&self, node: NodeId) -> Result<(), EditError> {
        if node == Self::ROOT {
            return Err(EditError::Root);
        }
        self.check_attached(node)
    }

    pub(crate) fn check_attached(&self, node: NodeId) -> Result<(), EditError> {
        let mut at = node;
        while at != Self::ROOT {
            at = self
                .get(at)
                .and_then(|n| n.parent)
                .ok_or(EditError::NoSuchNode(node))?;
        }
        Ok(())
    }

    pub(crate) fn check_place(&self, parent: NodeId, index: usize) -> Result<(), EditError> {
        self.check_attached(parent)?;
        let group = self.node(parent);
        if !matches!(group.desc.kind, NodeKind::Group) {
            return Err(EditError::NotAGroup(self.path(parent)));
        }
        let len = group.children.len();
        if index > len {
            Err(EditError::BadIndex { index, len })
        } else {
            Ok(())
        }
    }

    pub(crate) fn check_entry(&self, entry: &NodeDesc) -> Result<(), EditError> {
        entry.check()?;
        match &entry.material {
            Some(name) if !self.materials.contains_key(name) => {
                Err(EditError::NoSuchMaterial(name.clone()))
            }
            _ => Ok(()),
        }
    }
}
