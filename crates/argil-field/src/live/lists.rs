//! Which pieces can matter where, and the lists that they make.

use super::groups::Writer;
use super::listed::Near;
use super::piece::Operand;
use super::{LiveProgram, greatest};
use crate::parts::{Part, parts_between};
use crate::pieces::ROOT;
use crate::program::Program;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::Instr;
use argil_math::Aabb;
use argil_scene::{NodeId, Operator, OperatorKind, greatest_fall};
use glam::IVec3;
use rustc_hash::FxHashMap;
use std::borrow::Cow;

impl LiveProgram {
    /// Append the instructions that can matter in a part.
    pub fn list(&self, part: IVec3, out: &mut Vec<Instr>) {
        self.list_of(&self.near_in(part), out);
    }

    /// Append the instructions that can matter in a box within a part, to distances up to a length.
    pub fn list_in(&self, part: IVec3, region: Aabb, reach: f32, out: &mut Vec<Instr>) {
        // Boxes have grown by the far length at least; what blends add to that is no less of nearer distances.
        let region = region.grown(0.999_9 * (reach - self.parts.far).min(0.0));
        let touches =
            |held: &Aabb| held.max.cmpge(region.min).all() && held.min.cmple(region.max).all();
        let mut some: Vec<Near> = Vec::new();
        for own in self.near_by_level(part) {
            some.extend(own.iter().filter(|own| touches(&own.held)));
        }
        // Of levels that are in order, this only joins them.
        some.sort_by_key(|near| near.rank);
        self.list_of(&some, out);
    }

    /// Append the instructions of what is near a place, and of what matters everywhere.
    fn list_of(&self, near: &[Near], out: &mut Vec<Instr>) {
        let mut writer = Writer::new(&self.groups, out);
        if self.morphs > 0 {
            // A morph takes its share of everything.
            self.acting()
                .for_each(|own| writer.put(own.group, &own.instrs));
            writer.end();
            return;
        }
        let mut others = self.everywhere.iter().map(|(&r, &n)| (r, n)).peekable();
        for own in near {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < own.rank) {
                let other = &self.operands[&other];
                writer.put(other.group, &other.instrs);
            }
            self.put_near(&mut writer, own);
        }
        for (_, other) in others {
            let other = &self.operands[&other];
            writer.put(other.group, &other.instrs);
        }
        writer.end();
    }

    pub(super) fn put_near(&self, writer: &mut Writer<'_>, own: &Near) {
        match &own.instr {
            Some(instr) => writer.put(own.group, std::slice::from_ref(instr)),
            None => writer.put(own.group, &self.operands[&own.node].instrs),
        }
    }

    /// The visible pieces in the scene's order. The first to act is in what adds.
    pub(super) fn acting(&self) -> impl Iterator<Item = &Operand> {
        let all = self.order.values().map(|node| &self.operands[node]);
        all.filter(|own| own.visible).skip_while(|own| {
            let kind = match self.groups.outermost(own.group) {
                ROOT => own.operator.kind,
                group => self.groups.operator_of(group).kind,
            };
            kind != OperatorKind::Union
        })
    }

    /// The operands that are entered in a part, and in those of other levels that hold it, each level's by rank.
    fn near_by_level(&self, part: IVec3) -> impl Iterator<Item = &[Near]> {
        (0..self.levels).filter_map(move |level| {
            let own = self.near.get(&(level, part >> (2 * level)));
            own.map(Vec::as_slice)
        })
    }

    /// All of them by rank.
    pub(super) fn near_in(&self, part: IVec3) -> Cow<'_, [Near]> {
        let mut all = Cow::Borrowed(&[][..]);
        for own in self.near_by_level(part) {
            if all.is_empty() {
                all = Cow::Borrowed(own);
            } else {
                let joined = all.to_mut();
                joined.extend_from_slice(own);
                joined.sort_by_key(|near| near.rank);
            }
        }
        all
    }

    /// The whole scene's program, as [`Program::lower`] gives it but for the order of what does not depend on order.
    pub fn whole(&self) -> Program {
        let mut whole = self.tables.clone();
        let mut instrs = Vec::with_capacity(self.length);
        let mut operands = Vec::with_capacity(self.order.len());
        let root = GroupSpan {
            parent: ROOT,
            operator: Operator::default(),
            open: Instr::default(),
            close: Instr::default(),
        };
        let mut groups = vec![root];
        let mut places = FxHashMap::default();
        places.insert(ROOT, ROOT);
        let mut writer = Writer::new(&self.groups, &mut instrs);
        for own in self.acting() {
            writer.put(own.group, &own.instrs);
            let end = writer.len() as u32;
            operands.push(OperandSpan {
                begin: end - own.instrs.len() as u32,
                end,
                group: self.place_of(own.group, &mut places, &mut groups),
                operator: own.operator,
                extent: own.extent,
            });
            whole.brushes += own.brushes;
        }
        writer.end();
        whole.instrs = instrs;
        (whole.operands, whole.groups) = (operands, groups);
        whole
    }

    /// The place of an open group among a program's, which are entered with those around them.
    fn place_of(
        &self,
        group: u32,
        places: &mut FxHashMap<u32, u32>,
        groups: &mut Vec<GroupSpan>,
    ) -> u32 {
        if let Some(&place) = places.get(&group) {
            return place;
        }
        let Some(own) = self.groups.get(group) else {
            return ROOT;
        };
        // No more deep than open groups are.
        let parent = self.place_of(own.parent, places, groups);
        let place = groups.len() as u32;
        groups.push(GroupSpan {
            parent,
            operator: own.operator,
            open: own.open,
            close: own.close,
        });
        places.insert(group, place);
        place
    }

    /// How far values can fall through the joints of the root, and of each open group, before anything of a change is lost in
    /// rounding.
    pub(super) fn needed_falls(&self) -> [f32; 2] {
        let root = greatest(&self.blends);
        [
            greatest_fall(root, self.chamfers > 0, self.parts.far),
            greatest_fall(greatest(&self.inner_blends), false, 0.0),
        ]
    }

    /// The box in which an operand can matter where it is not everywhere that others do.
    pub(super) fn grown_box(&self, operand: &Operand) -> Aabb {
        let mut joints = vec![operand.operator];
        let mut at = operand.group;
        while let Some(group) = self.groups.get(at) {
            joints.push(group.operator);
            at = group.parent;
        }
        let outermost_first = joints.iter().rev();
        self.parts
            .reached_by(outermost_first, &operand.extent, self.falls)
    }

    pub(super) fn is_everywhere(&self, operand: &Operand) -> bool {
        let acts = operand.visible && !operand.extent.aabb.is_empty();
        let is_intersection = operand.operator.kind == OperatorKind::Intersect;
        (operand.visible && is_intersection)
            || (acts && self.parts.level_of(self.grown_box(operand)).is_none())
    }

    /// The parts in which an operand can matter.
    pub(super) fn parts_of(&self, operand: &Operand) -> impl Iterator<Item = Part> + use<> {
        let is_near = operand.visible
            && operand.operator.kind != OperatorKind::Intersect
            && !operand.extent.aabb.is_empty();
        let found = is_near
            .then(|| self.parts.level_of(self.grown_box(operand)))
            .flatten();
        found.into_iter().flat_map(parts_between)
    }

    /// Enter an operand into the parts.
    pub(super) fn index(&mut self, node: NodeId) {
        let operand = &self.operands[&node];
        let rank = operand.rank;
        let instr = match operand.instrs[..] {
            [only] => Some(only),
            _ => None,
        };
        let own = Near {
            rank,
            node,
            group: operand.group,
            instr,
            held: self.grown_box(operand),
        };
        if self.is_everywhere(operand) {
            self.everywhere.insert(rank, node);
        }
        for at in self.parts_of(operand) {
            self.levels = self.levels.max(at.0 + 1);
            let list = self.near.entry(at).or_default();
            if let Err(place) = list.binary_search_by_key(&rank, |near| near.rank) {
                list.insert(place, own);
            }
        }
    }

    /// Enter all operands anew.
    pub(super) fn index_all(&mut self) {
        // With some room, so that a blend which grows does not do this each time.
        let needed = self.needed_falls();
        self.falls = std::array::from_fn(|i| self.falls[i].max(1.25 * needed[i]));
        self.near.clear();
        self.everywhere.clear();
        let all: Vec<NodeId> = self.order.values().copied().collect();
        all.into_iter().for_each(|node| self.index(node));
    }
}
