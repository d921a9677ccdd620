//! Brushes that an update appended to the scene.

use super::IncrementalProgram;
use crate::combine::Joint;
use crate::eval_brush::BrushParams;
use crate::pieces::ROOT;
use crate::{FAR, Program};
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use argil_scene::Extent;
use glam::Vec3;

/// Brushes that the last update appended after everything else, as carving does. They combine with the scene as it
/// was, so distances stored before the update tell where they can matter.
#[derive(Debug)]
pub struct Additions<'a> {
    program: &'a Program,
    brushes: Vec<(Extent, Joint, Instruction)>,
}

/// An appended brush with a hard joint: its operator, and the instruction that measures it.
#[derive(Debug)]
pub struct HardBrush {
    instr: Instruction,
    /// Whether it is added rather than subtracted.
    pub is_union: bool,
}

impl HardBrush {
    /// Returns instructions that start with [`HardBrush::start`] and give what combines with the scene: the
    /// smaller of both for a union, and the larger otherwise.
    pub fn list(&self) -> &[Instruction] {
        std::slice::from_ref(&self.instr)
    }

    /// Returns the start value for [`HardBrush::list`].
    pub fn start(&self) -> f32 {
        if self.is_union { FAR } else { -FAR }
    }
}

impl IncrementalProgram {
    /// Returns the appended brushes, if the last update touched nothing else. Returns `None` if one of them is not
    /// a single brush that is united or subtracted, if something jumps, or if there is a morph.
    pub fn added(&self) -> Option<Additions<'_>> {
        let touched = self.changes()?;
        let program = self.program();
        let is_plain = self.counts.morphs == 0 && program.slack + program.hidden_slack == 0.0;
        if !is_plain || !touched.before.is_empty() {
            return None;
        }
        let last = self.order.values().rev().take(touched.after.len());
        let brushes = last.map(|node| {
            let operand = &self.operands[node];
            let [instr] = operand.instructions[..] else {
                return None;
            };
            let joint = BrushParams::read(&program.params, instr.params as usize).joint;
            let is_plain = operand.takes_part && operand.is_plain() && operand.group == ROOT;
            let is_brush = instr.op < abi::OP_SHAPES_END && joint.sb > 0.0;
            (touched.after.contains(node) && is_plain && is_brush).then_some((
                operand.extent,
                joint,
                instr,
            ))
        });
        let brushes: Option<Vec<_>> = brushes.collect();
        Some(Additions {
            program,
            brushes: brushes?,
        })
    }
}

impl Additions<'_> {
    /// Returns all brushes, last first, if each has a hard joint.
    pub fn hard_brushes(&self) -> Option<Vec<HardBrush>> {
        let brushes = self.brushes.iter().map(|(_, joint, instr)| {
            (joint.k == 0.0).then_some(HardBrush {
                instr: *instr,
                is_union: joint.sa > 0.0,
            })
        });
        brushes.collect()
    }

    /// Returns the maximum distance at points where the scene's distance without the brushes is at most `before`.
    pub fn max_distance_after(&self, before: f32) -> f32 {
        let all = self.brushes.iter();
        let [depth, blends] = all.fold([0.0f32; 2], |[depth, blends], (extent, joint, _)| {
            // No interior point is farther from the surface than half of the box.
            let half = 0.5 * extent.aabb.size().min_element();
            [depth.max(half), blends + joint.k]
        });
        before.max(self.program.lipschitz() * depth) + blends
    }

    /// Whether a brush can matter within `radius` of a point where the scene's distance without the brushes is from
    /// `least` to `most`. [`Pruner`](crate::Pruner) drops the others.
    pub fn can_matter(&self, point: Vec3, radius: f32, scene: [f32; 2]) -> bool {
        let region = Aabb::new(point, point).grown(radius);
        let change = self.program.lipschitz() * radius * 1.000_01;
        let margin = 2.0 * (change + self.program.rounding(region));
        self.can_reach(Aabb::new(point, point), scene, margin)
    }

    /// Whether a brush can matter anywhere in a box, where the scene's distance without the brushes is from `least` to `most`.
    pub fn can_matter_in(&self, region: Aabb, scene: [f32; 2]) -> bool {
        self.can_reach(region, scene, 2.0 * self.program.rounding(region))
    }

    /// Whether no surface comes to a box without one, which is all solid or all air. Distances there stay as they were, or are at
    /// least `least`. Digging in the air brings none, and neither does a brush that is far enough away.
    pub fn keep_clear(&self, region: Aabb, is_solid: bool, least: f32) -> bool {
        let least = least + 2.0 * self.program.rounding(region);
        self.brushes.iter().all(|(extent, joint, _)| {
            let is_union = joint.sa > 0.0;
            // Where neither wins by a blend's width, both are farther than the brush less that width, and a blend takes a quarter.
            is_union == is_solid || distance_from(region, extent) > least + 1.25 * joint.k
        })
    }

    /// Whether a brush loses nowhere in a box by more than a margin.
    fn can_reach(&self, region: Aabb, [least, most]: [f32; 2], margin: f32) -> bool {
        self.brushes.iter().any(|(extent, joint, _)| {
            let of_brush = distance_from(region, extent);
            let scene = if joint.sa > 0.0 { most } else { -least };
            // NaN, from an infinite solid, does not count as less.
            let loses = of_brush > 0.0 && of_brush - scene > margin + joint.k;
            !loses
        })
    }
}

/// Returns a lower bound of a brush's distance anywhere in a box. It is NaN for an infinite solid.
fn distance_from(region: Aabb, extent: &Extent) -> f32 {
    let held = extent.aabb;
    let gap = (held.min - region.max).max(region.min - held.max);
    gap.max(Vec3::ZERO).length() / (1.000_1 * extent.lipschitz_inverse)
}
