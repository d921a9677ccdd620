//! Which operands of a program's root can matter where.
//!
//! *Practice.* A program knows the stretch of instructions and the box of each operand of the root, where those stand one after
//! the other. An [`OperandIndex`] enters them into a grid of parts: the list of a part costs what is near it, however many
//! operands there are.

use crate::Program;
use crate::live::append;
use crate::parts::{LEVELS, Part, Parts, parts_between};
use argil_abi::Instr;
use argil_scene::{Extent, Operator, OperatorKind, Profile, greatest_fall};
use glam::IVec3;
use rustc_hash::FxHashMap;

/// An operand of a program's root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OperandSpan {
    /// The instruction behind its last; it begins where the one before ends.
    pub end: u32,
    pub operator: Operator,
    pub extent: Extent,
}

/// Lists of what can matter in each part of a grid. See the module's page.
pub struct OperandIndex {
    parts: Parts,
    near: FxHashMap<Part, Vec<u32>>,
    levels: u32,
    /// Operands that matter wherever others do.
    everywhere: Vec<u32>,
}

impl Program {
    /// Operands of the root that an [`OperandIndex`] can tell apart: none where they are few, or do not stand one after the other.
    pub fn operand_count(&self) -> usize {
        self.operands.len()
    }
}

impl OperandIndex {
    /// Enters a program's operands. `None` where they cannot be [told apart](Program::operand_count), or where some morph, which
    /// makes all matter everywhere.
    pub fn new(program: &Program, parts: Parts) -> Option<Self> {
        let all = &program.operands;
        let morphs = |own: &OperandSpan| own.operator.kind == OperatorKind::Morph;
        if all.is_empty() || all.iter().any(morphs) {
            return None;
        }
        let blend = all.iter().map(|own| own.operator.blend).fold(0.0, f32::max);
        let is_chamfered = |own: &OperandSpan| {
            own.operator.profile == Profile::Chamfer && own.operator.blend > 0.0
        };
        let falls = greatest_fall(blend, all.iter().any(is_chamfered), parts.far);
        let mut index = Self {
            parts,
            near: FxHashMap::default(),
            levels: 1,
            everywhere: Vec::new(),
        };
        for (nth, own) in (0..).zip(all) {
            if own.operator.kind == OperatorKind::Intersect {
                index.everywhere.push(nth);
                continue;
            }
            if own.extent.aabb.is_empty() {
                continue;
            }
            match parts.level_of(parts.reached_by(
                std::iter::once(&own.operator),
                &own.extent,
                [falls, 0.0],
            )) {
                None => index.everywhere.push(nth),
                Some(found) => {
                    index.levels = index.levels.max(found.0 + 1);
                    for part in parts_between(found) {
                        index.near.entry(part).or_default().push(nth);
                    }
                }
            }
        }
        Some(index)
    }

    /// The grid.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Appends the instructions that can matter in a part, in the program's order. There they give the program's distances, as far
    /// as those are below [`Parts::far`]. `program` is the one that was entered.
    pub fn list(&self, program: &Program, part: IVec3, out: &mut Vec<Instr>) {
        let mut found: Vec<u32> = self.everywhere.clone();
        for level in 0..self.levels.min(LEVELS) {
            if let Some(near) = self.near.get(&(level, part >> (2 * level))) {
                found.extend_from_slice(near);
            }
        }
        found.sort_unstable();
        let all = &program.operands;
        for nth in found {
            let nth = nth as usize;
            let begin = if nth == 0 { 0 } else { all[nth - 1].end };
            let own = &program.instrs[begin as usize..all[nth].end as usize];
            append_span(own, begin, out);
        }
    }
}

/// Append an operand's instructions, which begin at `begin` in the program.
fn append_span(instrs: &[Instr], begin: u32, out: &mut Vec<Instr>) {
    let from = out.len();
    append(instrs, out);
    for instr in &mut out[from..] {
        if instr.op == argil_abi::OP_NEXT {
            instr.operand -= begin;
        }
    }
}
