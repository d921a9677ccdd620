//! Counting the operands of large groups.

use crate::crowd::{CROWD, Crowd};
use crate::{NodeId, Scene};

impl Crowd {
    fn of(scene: &Scene, group: NodeId) -> Self {
        let mut crowd = Self::default();
        for &child in scene.node(group).children() {
            crowd.add(scene.node(child).acting());
        }
        crowd
    }
}

impl Scene {
    /// Count the large groups around a node, unless they are counted.
    pub(crate) fn count_crowds(&mut self, node: NodeId) {
        let mut at = self.node(node).parent;
        while let Some(group) = at {
            if self.node(group).children.len() > CROWD && !self.crowds.contains_key(&group) {
                let crowd = Crowd::of(self, group);
                self.crowds.insert(group, crowd);
            }
            at = self.node(group).parent;
        }
    }

    /// Count a node in, or out again, where its group is counted.
    pub(crate) fn count(&mut self, node: NodeId, is_there: bool) {
        let Self { nodes, crowds, .. } = self;
        let own = &nodes[node.index()];
        let crowd = own.parent.and_then(|group| crowds.get_mut(&group));
        match crowd {
            Some(crowd) if is_there => crowd.add(own.acting()),
            Some(crowd) => crowd.remove(own.acting()),
            None => {}
        }
    }
}
