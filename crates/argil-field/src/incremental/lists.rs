//! Writes the programs of parts.

use super::IncrementalProgram;
use super::groups::ListWriter;
use super::index::PartEntry;
use super::piece::Operand;
use crate::pieces::ROOT;
use crate::program::Program;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::Instruction;
use argil_math::Aabb;
use argil_scene::{NodeId, Operator, OperatorKind};
use glam::IVec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Maximum parts of the boxes that a list is made for.
const MAX_PARTS: i64 = 1 << 15;

impl IncrementalProgram {
    /// Appends the instructions that can matter in a part.
    pub fn part_program(&self, part: IVec3, out: &mut Vec<Instruction>) {
        self.list_of(&self.index.near_in(part), out);
    }

    /// Appends the instructions that can matter in a box within a part, for distances up to a length.
    pub fn part_program_in(
        &self,
        part: IVec3,
        region: Aabb,
        reach: f32,
        out: &mut Vec<Instruction>,
    ) {
        // Boxes have grown by at least the far length. What blends add is no less for smaller distances.
        let region = region.grown(0.999_9 * (reach - self.index.parts.far).min(0.0));
        let touches =
            |held: &Aabb| held.max.cmpge(region.min).all() && held.min.cmple(region.max).all();
        let mut some: Vec<PartEntry> = Vec::new();
        for entries in self.index.near_by_level(part) {
            some.extend(entries.iter().filter(|entry| touches(&entry.held)));
        }
        // Each level is sorted already, so this only merges them.
        some.sort_by_key(|near| near.rank);
        self.list_of(&some, out);
    }

    /// Appends the instructions of nearby entries, and of what matters everywhere.
    fn list_of(&self, near: &[PartEntry], out: &mut Vec<Instruction>) {
        let mut writer = ListWriter::new(&self.groups, out);
        if self.counts.morphs > 0 {
            // A morph affects everything.
            self.acting()
                .for_each(|operand| writer.put(operand.group, &operand.instructions));
            writer.end();
            return;
        }
        let mut others = self
            .index
            .everywhere
            .iter()
            .map(|(&r, &n)| (r, n))
            .peekable();
        for entry in near {
            while let Some((_, other)) = others.next_if(|&(other, _)| other < entry.rank) {
                let other = &self.operands[&other];
                writer.put(other.group, &other.instructions);
            }
            self.put_near(&mut writer, entry);
        }
        for (_, other) in others {
            let other = &self.operands[&other];
            writer.put(other.group, &other.instructions);
        }
        writer.end();
    }

    /// Appends the instructions that can matter in some boxes, for distances up to the far length. Returns false if the boxes
    /// have too many parts.
    pub(super) fn list_near(&self, boxes: &[Aabb], out: &mut Vec<Instruction>) -> bool {
        let mut near: BTreeMap<u64, PartEntry> = BTreeMap::new();
        let mut parts = 0;
        for region in boxes {
            let [low, high] =
                [region.min, region.max].map(|corner| self.index.parts.part_of(corner));
            let [x, y, z] = [0, 1, 2].map(|axis| i64::from(high[axis]) - i64::from(low[axis]) + 1);
            parts += x.saturating_mul(y).saturating_mul(z);
            if !region.is_finite() || parts > MAX_PARTS {
                return false;
            }
            for index in 0..x * y * z {
                let step = [index % x, index / x % y, index / (x * y)];
                let part = low + IVec3::from(step.map(|c| c as i32));
                for level in self.index.near_by_level(part) {
                    near.extend(level.iter().map(|entry| (entry.rank, *entry)));
                }
            }
        }
        let near: Vec<PartEntry> = near.into_values().collect();
        self.list_of(&near, out);
        true
    }

    pub(super) fn put_near(&self, writer: &mut ListWriter<'_>, entry: &PartEntry) {
        match &entry.instr {
            Some(instr) => writer.put(entry.group, std::slice::from_ref(instr)),
            None => writer.put(entry.group, &self.operands[&entry.node].instructions),
        }
    }

    /// Iterates over the pieces that take part, in the scene's order. The first one adds.
    pub(super) fn acting(&self) -> impl Iterator<Item = &Operand> {
        let all = self.order.values().map(|node| &self.operands[node]);
        all.filter(|operand| operand.takes_part)
            .skip_while(|operand| {
                let kind = match self.groups.outermost(operand.group) {
                    ROOT => operand.operator.kind,
                    group => self.groups.operator_of(group).kind,
                };
                kind != OperatorKind::Union
            })
    }

    /// Returns the rank of the first piece that acts. Those before it have nothing to act on.
    pub(super) fn first_acting(&self) -> Option<u64> {
        self.acting().next().map(|operand| operand.rank)
    }

    /// Returns the whole scene's program, equal to [`Program::lower`] except for orders that do not matter.
    pub fn to_program(&self) -> Program {
        let mut whole = self.tables.clone();
        let mut instructions = Vec::with_capacity(self.length);
        let mut operands = Vec::with_capacity(self.order.len());
        let root = GroupSpan {
            parent: ROOT,
            operator: Operator::default(),
            open: Instruction::default(),
            close: Instruction::default(),
        };
        let mut groups = vec![root];
        let mut places = FxHashMap::default();
        places.insert(ROOT, ROOT);
        let mut writer = ListWriter::new(&self.groups, &mut instructions);
        for operand in self.acting() {
            writer.put(operand.group, &operand.instructions);
            let end = writer.len() as u32;
            operands.push(OperandSpan {
                begin: end - operand.instructions.len() as u32,
                end,
                group: self.place_of(operand.group, &mut places, &mut groups),
                operator: operand.operator,
                extent: operand.extent,
            });
            whole.brushes += operand.brushes;
        }
        writer.end();
        whole.instructions = instructions;
        (whole.operands, whole.groups) = (operands, groups);
        whole
    }

    /// Returns the index of an open group in a program, and adds it and the groups around it if needed.
    fn place_of(
        &self,
        group: u32,
        places: &mut FxHashMap<u32, u32>,
        groups: &mut Vec<GroupSpan>,
    ) -> u32 {
        if let Some(&place) = places.get(&group) {
            return place;
        }
        let Some(entry) = self.groups.get(group) else {
            return ROOT;
        };
        // Open groups limit the depth.
        let parent = self.place_of(entry.parent, places, groups);
        let place = groups.len() as u32;
        groups.push(GroupSpan {
            parent,
            operator: entry.operator,
            open: entry.open,
            close: entry.close,
        });
        places.insert(group, place);
        place
    }

    /// Adds an operand to the parts.
    pub(super) fn enter(&mut self, node: NodeId) {
        self.index.enter(node, &self.operands[&node], &self.groups);
    }

    /// Adds all operands to the parts again.
    pub(super) fn index_all(&mut self) {
        self.index
            .begin(self.counts.blend_propagation(self.index.parts.far));
        let all: Vec<NodeId> = self.order.values().copied().collect();
        all.into_iter().for_each(|node| self.enter(node));
    }
}
