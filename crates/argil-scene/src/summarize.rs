//! Maintains the summaries of large groups.

use crate::group_summary::{GroupSummary, SUMMARY_THRESHOLD};
use crate::{NodeId, Scene};

impl GroupSummary {
    fn of(scene: &Scene, group: NodeId) -> Self {
        let mut crowd = Self::default();
        for &child in scene.node(group).children() {
            crowd.add(scene.node(child).at_current_time());
        }
        crowd
    }
}

impl Scene {
    /// Creates the summaries of large groups around a node, unless they exist.
    pub(crate) fn summarize_groups(&mut self, node: NodeId) {
        let mut at = self.node(node).parent;
        while let Some(group) = at {
            if self.node(group).children.len() > SUMMARY_THRESHOLD
                && !self.summaries.contains_key(&group)
            {
                let crowd = GroupSummary::of(self, group);
                self.summaries.insert(group, crowd);
            }
            at = self.node(group).parent;
        }
    }

    /// Adds a node to its group's summary, or removes it.
    pub(crate) fn count(&mut self, node: NodeId, is_there: bool) {
        let Self {
            nodes,
            summaries: crowds,
            ..
        } = self;
        let own = &nodes[node.index()];
        let crowd = own.parent.and_then(|group| crowds.get_mut(&group));
        match crowd {
            Some(crowd) if is_there => crowd.add(own.at_current_time()),
            Some(crowd) => crowd.remove(own.at_current_time()),
            None => {}
        }
    }
}
