//! What the last update of a program has touched.

use super::LiveProgram;
use super::groups::Writer;
use super::piece::Operand;
use crate::parts::{LEVELS, Part};
use argil_abi::Instr;
use argil_scene::NodeId;
use glam::IVec3;
use rustc_hash::FxHashMap;
use std::collections::HashSet;

/// What the last update has touched, as it was and as it is: by instructions of either.
#[derive(Default)]
pub struct Touched {
    /// Operands as they were; their parameters stand until the next update.
    pub(super) before: Vec<Operand>,
    /// Those of each part.
    pub(super) near: FxHashMap<Part, Vec<usize>>,
    /// Operands as they are.
    pub(super) after: HashSet<NodeId>,
    /// Stretches of parameters, ascending.
    pub(super) stretches: Vec<(u32, u32)>,
}

impl Touched {
    /// Whether an instruction was touched, or is as it was before it was.
    pub fn has(&self, instr: &Instr) -> bool {
        let at = self
            .stretches
            .partition_point(|&(begin, _)| begin <= instr.params);
        let last = at.checked_sub(1).map(|last| self.stretches[last]);
        last.is_some_and(|(_, end)| instr.params < end)
    }

    /// Whether a list has an instruction that was touched: without one it gives the same distances as before.
    pub fn any(&self, list: &[Instr]) -> bool {
        list.iter().any(|instr| self.has(instr))
    }

    /// How many instructions of a list were touched.
    pub fn count(&self, list: &[Instr]) -> usize {
        list.iter().filter(|instr| self.has(instr)).count()
    }
}

impl LiveProgram {
    /// Find out what is touched, in which parts.
    pub(super) fn tell(&self, told: &mut Touched) {
        let words = |operand: &Operand, begin: u32, end: u32| {
            let at = operand.params.0;
            &self.tables.params[(at + begin) as usize..(at + end) as usize]
        };
        let mut alike = HashSet::new();
        for old in &told.before {
            let there = self.order.get(&old.rank);
            let now = there
                .filter(|node| told.after.contains(node))
                .map(|node| &self.operands[node]);
            let now = now.filter(|now| old.is_alike(now));
            alike.extend(now.map(|now| now.rank));
            for (begin, end) in old.stretches() {
                if let Some(now) = now {
                    if words(old, begin, end) == words(now, begin, end) {
                        continue;
                    }
                    told.stretches
                        .push((now.params.0 + begin, now.params.0 + end));
                }
                told.stretches
                    .push((old.params.0 + begin, old.params.0 + end));
            }
        }
        for node in &told.after {
            let now = &self.operands[node];
            if !alike.contains(&now.rank) {
                let (at, length) = now.params;
                told.stretches.push((at, at + length));
            }
        }
        told.stretches.sort_unstable();
        for (nth, old) in told.before.iter().enumerate() {
            for part in self.parts_of(old) {
                told.near.entry(part).or_default().push(nth);
            }
        }
    }

    /// What the last update has touched; nothing where that may be anything.
    pub fn touched(&self) -> Option<&Touched> {
        self.touched.as_ref().filter(|_| self.is_told)
    }

    /// [`LiveProgram::list`] as it was before the last update, where what that touched is known.
    pub fn list_before(&self, part: IVec3, out: &mut Vec<Instr>) {
        let Some(touched) = self.touched() else {
            return;
        };
        let stays = |node: &NodeId| !touched.after.contains(node);
        let mut own: Vec<usize> = (0..LEVELS)
            .filter_map(|level| touched.near.get(&(level, part >> (2 * level))))
            .flatten()
            .copied()
            .collect();
        own.sort_unstable();
        own.dedup();
        let own = own.into_iter().map(|nth| &touched.before[nth]);
        let everywhere = self.everywhere.iter().filter(|(_, node)| stays(node));
        let was_everywhere = |old: &&Operand| self.is_everywhere(old);
        let mut others: Vec<(u64, &Operand)> = own
            .chain(touched.before.iter().filter(was_everywhere))
            .map(|old| (old.rank, old))
            .chain(everywhere.map(|(&rank, node)| (rank, &self.operands[node])))
            .collect();
        others.sort_by_key(|&(rank, _)| rank);
        let mut others = others.into_iter().peekable();
        let mut writer = Writer::new(&self.groups, out);
        for own in self.near_in(part).iter().filter(|own| stays(&own.node)) {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                writer.put(other.group, &other.instrs);
            }
            self.put_near(&mut writer, own);
        }
        others.for_each(|(_, other)| writer.put(other.group, &other.instrs));
        writer.end();
    }
}
