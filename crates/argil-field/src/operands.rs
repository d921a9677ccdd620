//! Finds the pieces of a program that can matter at a place.
//!
//! *Practice.* A program of many [pieces](crate::pieces) records the range of instructions and the box of each, and
//! the open groups that contain it. An [`OperandIndex`] enters them into a grid of parts. A part's program then
//! costs what is near it, however many pieces there are.

use crate::Program;
use crate::part_grid::{LEVELS, Part, PartGrid, parts_between};
use crate::pieces::{MAX_OPEN_GROUPS, PieceWalk, ROOT, chain};
use crate::spans::{OperandSpan, append};
use argil_abi::Instruction;
use argil_math::Aabb;
use argil_scene::{BlendProfile, OperatorKind, max_blend_propagation};
use glam::IVec3;
use rustc_hash::FxHashMap;

/// An index from parts of space to the pieces that can matter there.
///
/// Only programs of many pieces have one.
#[derive(Debug)]
pub struct OperandIndex {
    parts: PartGrid,
    near: FxHashMap<Part, Vec<u32>>,
    levels: u32,
    /// Operands that matter wherever others do.
    everywhere: Vec<u32>,
}

impl Program {
    /// Returns the number of pieces that an [`OperandIndex`] can track, or 0 if there are few.
    pub fn operand_count(&self) -> usize {
        self.operands.len()
    }

    /// Whether no piece morphs. A morph makes everything matter everywhere.
    pub(crate) fn is_local(&self) -> bool {
        let morphs = |operand: &OperandSpan| operand.operator.kind == OperatorKind::Morph;
        !self.operands.is_empty() && !self.operands.iter().any(morphs)
    }

    fn group_around(&self, group: u32) -> u32 {
        self.groups
            .get(group as usize)
            .map_or(ROOT, |span| span.parent)
    }

    /// Returns the box in which a piece can matter for distances below the parts' far length, given how far values
    /// can fall through joints.
    pub(crate) fn reach_of(
        &self,
        operand: &OperandSpan,
        parts: &PartGrid,
        falls: [f32; 2],
    ) -> Aabb {
        let mut room = [ROOT; MAX_OPEN_GROUPS];
        let around = chain(operand.group, &|group| self.group_around(group), &mut room);
        let groups = around
            .iter()
            .map(|&group| &self.groups[group as usize].operator);
        let joints = groups.chain([&operand.operator]);
        parts.reached_by(joints, &operand.extent, falls)
    }

    /// Returns how far values below `far` can fall through the joints of the root, and of each group.
    pub(crate) fn falls(&self, far: f32) -> [f32; 2] {
        let of_operands = self
            .operands
            .iter()
            .map(|operand| (operand.group, &operand.operator));
        let groups = self.groups.iter().skip(1);
        let all =
            of_operands.chain(groups.map(|group_span| (group_span.parent, &group_span.operator)));
        let (mut outer, mut inner, mut is_chamfered) = (0.0f32, 0.0f32, false);
        for (group, operator) in all {
            if group == ROOT {
                outer = outer.max(operator.blend);
                is_chamfered |= operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
            } else {
                inner = inner.max(operator.blend);
            }
        }
        [
            max_blend_propagation(outer, is_chamfered, far),
            max_blend_propagation(inner, false, 0.0),
        ]
    }

    /// Appends the instructions of pieces, given in the program's order, with the joints of the groups around them.
    pub(crate) fn append_operands(&self, some: &[u32], out: &mut Vec<Instruction>) {
        let mut walk = PieceWalk::default();
        let parent_of = |group: u32| self.group_around(group);
        let step = |out: &mut Vec<Instruction>, group: u32, enters: bool| {
            let span = &self.groups[group as usize];
            out.push(if enters { span.open } else { span.close });
        };
        for &index in some {
            let operand = &self.operands[index as usize];
            walk.go_to(operand.group, parent_of, |group, enters| {
                step(out, group, enters)
            });
            match &self.instructions[operand.begin as usize..operand.end as usize] {
                [only] => out.push(*only),
                all => append_span(all, operand.begin, out),
            }
        }
        walk.go_to(ROOT, parent_of, |group, enters| step(out, group, enters));
    }
}

impl OperandIndex {
    /// Creates an index. Returns `None` if the program's pieces are not [tracked](Program::operand_count), or if
    /// there is a morph.
    pub fn new(program: &Program, parts: PartGrid) -> Option<Self> {
        let all = &program.operands;
        if !program.is_local() {
            return None;
        }
        let falls = program.falls(parts.far);
        let mut index = Self {
            parts,
            near: FxHashMap::default(),
            levels: 1,
            everywhere: Vec::new(),
        };
        for (number, operand) in (0..).zip(all) {
            if operand.operator.kind == OperatorKind::Intersect {
                index.everywhere.push(number);
                continue;
            }
            if operand.extent.aabb.is_empty() {
                continue;
            }
            match parts.level_of(program.reach_of(operand, &parts, falls)) {
                None => index.everywhere.push(number),
                Some(found) => {
                    index.levels = index.levels.max(found.0 + 1);
                    for part in parts_between(found) {
                        index.near.entry(part).or_default().push(number);
                    }
                }
            }
        }
        Some(index)
    }

    /// Returns the number of entries that an index would have.
    pub fn entries(program: &Program, parts: PartGrid) -> u64 {
        let falls = program.falls(parts.far);
        let entries = program.operands.iter().map(|operand| {
            let is_entered =
                operand.operator.kind != OperatorKind::Intersect && !operand.extent.aabb.is_empty();
            let found =
                is_entered.then(|| parts.level_of(program.reach_of(operand, &parts, falls)));
            let found = found.flatten();
            found.map_or(0, |(_, first, last)| {
                // No level has more than a few hundred.
                u64::from((last - first + 1).as_uvec3().element_product())
            })
        });
        entries.sum()
    }

    /// Returns the grid of parts.
    pub fn parts(&self) -> &PartGrid {
        &self.parts
    }

    /// Whether nothing can matter in a part.
    pub fn is_empty(&self, part: IVec3) -> bool {
        let mut levels = 0..self.levels.min(LEVELS);
        self.everywhere.is_empty()
            && !levels.any(|level| self.near.contains_key(&(level, part >> (2 * level))))
    }

    /// Appends the instructions that can matter in a part, in the program's order. In the part, they give the
    /// program's distances below [`PartGrid::far`]. `program` must be the indexed one.
    pub fn part_program(&self, program: &Program, part: IVec3, out: &mut Vec<Instruction>) {
        let mut found: Vec<u32> = self.everywhere.clone();
        for level in 0..self.levels.min(LEVELS) {
            if let Some(near) = self.near.get(&(level, part >> (2 * level))) {
                found.extend_from_slice(near);
            }
        }
        found.sort_unstable();
        program.append_operands(&found, out);
    }
}

/// Appends a piece's instructions, which begin at `begin` in the program.
fn append_span(instructions: &[Instruction], begin: u32, out: &mut Vec<Instruction>) {
    let from = out.len();
    append(instructions, out);
    for instr in &mut out[from..] {
        if instr.op == argil_abi::OP_NEXT {
            instr.operand -= begin;
        }
    }
}
