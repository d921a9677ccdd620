//! Maintains the summaries of large groups.

use crate::group_summary::{GroupSummary, SUMMARY_THRESHOLD};
use crate::{NodeId, Scene};

impl GroupSummary {
    fn of(scene: &Scene, group: NodeId) -> Self {
        let mut summary = Self::default();
        for &child in scene.node(group).children() {
            summary.add(scene.node(child).at_current_time());
        }
        summary
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
                let summary = GroupSummary::of(self, group);
                self.summaries.insert(group, summary);
            }
            at = self.node(group).parent;
        }
    }

    /// Adds a node to its group's summary, or removes it.
    pub(crate) fn count(&mut self, node: NodeId, is_there: bool) {
        let Self {
            nodes, summaries, ..
        } = self;
        let member = &nodes[node.index()];
        let summary = member.parent.and_then(|group| summaries.get_mut(&group));
        match summary {
            Some(summary) if is_there => summary.add(member.at_current_time()),
            Some(summary) => summary.remove(member.at_current_time()),
            None => {}
        }
    }
}
