//! What an update has put behind all that was there.

use super::IncrementalProgram;
use crate::combine::Joint;
use crate::eval_brush::BrushParams;
use crate::pieces::ROOT;
use crate::{FAR, Program};
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use argil_scene::Extent;
use glam::Vec3;

/// Brushes that the last update has put behind all that was there, as a carve is: the scene as it was is what they are joined
/// with, so that distances which somebody has kept tell where they can matter.
#[derive(Debug)]
pub struct Additions<'a> {
    program: &'a Program,
    brushes: Vec<(Extent, Joint, Instruction)>,
}

/// A brush that is joined hard with all that was there: how, and the instruction that measures it.
#[derive(Debug)]
pub struct HardUnionBrush {
    instr: Instruction,
    /// Whether it is united, not subtracted.
    pub adds: bool,
}

impl HardUnionBrush {
    /// A list that begins with [`HardUnionBrush::start`] and then is what it joins the scene with: the nearer of both where it
    /// adds, else the farther.
    pub fn list(&self) -> &[Instruction] {
        std::slice::from_ref(&self.instr)
    }

    /// See [`HardUnionBrush::list`].
    pub fn start(&self) -> f32 {
        if self.adds { FAR } else { -FAR }
    }
}

impl IncrementalProgram {
    /// The brushes that are all that the last update has touched; nothing where that was more, where one is no single brush that
    /// is united or subtracted, where something jumps or takes its share of everything.
    pub fn added(&self) -> Option<Additions<'_>> {
        let touched = self.changes()?;
        let program = self.program();
        let is_plain = self.counts.morphs == 0 && program.slack + program.hidden_slack == 0.0;
        if !is_plain || !touched.before.is_empty() {
            return None;
        }
        let last = self.order.values().rev().take(touched.after.len());
        let brushes = last.map(|node| {
            let own = &self.operands[node];
            let [instr] = own.instrs[..] else { return None };
            let joint = BrushParams::read(&program.params, instr.params as usize).joint;
            let is_plain = own.visible && own.is_plain() && own.group == ROOT;
            let is_brush = instr.op < abi::OP_SHAPES_END && joint.sb > 0.0;
            (touched.after.contains(node) && is_plain && is_brush)
                .then_some((own.extent, joint, instr))
        });
        let brushes: Option<Vec<_>> = brushes.collect();
        Some(Additions {
            program,
            brushes: brushes?,
        })
    }
}

impl Additions<'_> {
    /// All of them, the last first, if each is joined hard.
    pub fn hard(&self) -> Option<Vec<HardUnionBrush>> {
        let brushes = self.brushes.iter().map(|(_, joint, instr)| {
            (joint.k == 0.0).then_some(HardUnionBrush {
                instr: *instr,
                adds: joint.sa > 0.0,
            })
        });
        brushes.collect()
    }

    /// The greatest length of a distance where that of the scene without them is so much at most.
    pub fn greatest(&self, before: f32) -> f32 {
        let all = self.brushes.iter();
        let [depth, blends] = all.fold([0.0f32; 2], |[depth, blends], (extent, joint, _)| {
            // No point inside is farther from the way out than half of the box.
            let own = 0.5 * extent.aabb.size().min_element();
            [depth.max(own), blends + joint.k]
        });
        before.max(self.program.lipschitz() * depth) + blends
    }

    /// Whether one of them can matter within `radius` of a point at which the scene without them is from `least` to `most`.
    /// [`Pruner`](crate::Pruner) leaves the others out of lists.
    pub fn can_matter(&self, point: Vec3, radius: f32, [least, most]: [f32; 2]) -> bool {
        let region = Aabb::new(point, point).grown(radius);
        let change = self.program.lipschitz() * radius * 1.000_01;
        let margin = 2.0 * (change + self.program.rounding(region));
        self.brushes.iter().any(|(extent, joint, _)| {
            let held = extent.aabb;
            let gap = (held.min - point).max(point - held.max).max(Vec3::ZERO);
            let own = gap.length() / (1.000_1 * extent.lipschitz_inverse);
            let scene = if joint.sa > 0.0 { most } else { -least };
            // Not a number, of what is endless, is no less.
            let loses = own > 0.0 && own - scene > margin + joint.k;
            !loses
        })
    }
}
