//! Collects what an update touched.

use super::IncrementalProgram;
use super::change_set::ChangeSet;
use super::groups::ListWriter;
use super::piece::Operand;
use crate::part_grid::LEVELS;
use argil_abi::Instruction;
use argil_scene::NodeId;
use glam::IVec3;
use std::collections::HashSet;

impl IncrementalProgram {
    /// Finds the parts of what was touched.
    pub(super) fn collect_changes(&self, changes_made: &mut ChangeSet) {
        let words = |operand: &Operand, begin: u32, end: u32| {
            let at = operand.params.0;
            &self.tables.params[(at + begin) as usize..(at + end) as usize]
        };
        let mut alike = HashSet::new();
        for old in &changes_made.before {
            let there = self.order.get(&old.rank);
            let now = there
                .filter(|node| changes_made.after.contains(node))
                .map(|node| &self.operands[node]);
            let now = now.filter(|now| old.same_structure(now));
            alike.extend(now.map(|now| now.rank));
            for (begin, end) in old.stretches() {
                if let Some(now) = now {
                    if words(old, begin, end) == words(now, begin, end) {
                        continue;
                    }
                    changes_made
                        .stretches
                        .push((now.params.0 + begin, now.params.0 + end));
                }
                changes_made
                    .stretches
                    .push((old.params.0 + begin, old.params.0 + end));
            }
        }
        for node in &changes_made.after {
            let now = &self.operands[node];
            if !alike.contains(&now.rank) {
                let (at, length) = now.params;
                changes_made.stretches.push((at, at + length));
            }
        }
        changes_made.stretches.sort_unstable();
        for (index, old) in changes_made.before.iter().enumerate() {
            for part in self.index.parts_of(old, &self.groups) {
                changes_made.near.entry(part).or_default().push(index);
            }
        }
    }

    /// Returns the nodes that the last update touched, or `None` if it may have touched any.
    pub fn changes(&self) -> Option<&ChangeSet> {
        self.update.collected()
    }

    /// Appends the instructions of the whole program before the last update, if they are known.
    pub fn previous_instructions(&self, out: &mut Vec<Instruction>) {
        let Some(touched) = self.changes() else {
            return;
        };
        let stay = self
            .order
            .values()
            .filter(|node| !touched.after.contains(node))
            .map(|node| &self.operands[node]);
        let mut all: Vec<&Operand> = stay.chain(&touched.before).collect();
        all.retain(|operand| operand.takes_part);
        all.sort_by_key(|operand| operand.rank);
        let mut writer = ListWriter::new(&self.groups, out);
        all.iter()
            .for_each(|operand| writer.put(operand.group, &operand.instructions));
        writer.end();
    }

    /// Appends the [`IncrementalProgram::part_program`] before the last update, if it is known.
    pub fn previous_part_program(&self, part: IVec3, out: &mut Vec<Instruction>) {
        let Some(touched) = self.changes() else {
            return;
        };
        let stays = |node: &NodeId| !touched.after.contains(node);
        let mut near: Vec<usize> = (0..LEVELS)
            .filter_map(|level| touched.near.get(&(level, part >> (2 * level))))
            .flatten()
            .copied()
            .collect();
        near.sort_unstable();
        near.dedup();
        let near = near.into_iter().map(|index| &touched.before[index]);
        let everywhere = self.index.everywhere.iter().filter(|(_, node)| stays(node));
        let was_everywhere = |old: &&Operand| self.index.is_everywhere(old, &self.groups);
        let mut others: Vec<(u64, &Operand)> = near
            .chain(touched.before.iter().filter(was_everywhere))
            .map(|old| (old.rank, old))
            .chain(everywhere.map(|(&rank, node)| (rank, &self.operands[node])))
            .collect();
        others.sort_by_key(|&(rank, _)| rank);
        let mut others = others.into_iter().peekable();
        let mut writer = ListWriter::new(&self.groups, out);
        for entry in self
            .index
            .near_in(part)
            .iter()
            .filter(|entry| stays(&entry.node))
        {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < entry.rank) {
                writer.put(other.group, &other.instructions);
            }
            self.put_near(&mut writer, entry);
        }
        others.for_each(|(_, other)| writer.put(other.group, &other.instructions));
        writer.end();
    }
}
