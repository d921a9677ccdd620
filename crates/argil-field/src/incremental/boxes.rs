//! Where the last update changed distances, up to a length.

use super::IncrementalProgram;
use super::piece::Operand;
use crate::part_grid::PartGrid;
use crate::pieces::ROOT;
use argil_math::Aabb;
use argil_scene::{OperatorKind, max_blend_propagation};

impl IncrementalProgram {
    /// Returns boxes outside which the last update changed no distance below `far`, and no material of a surface.
    /// Returns `None` if it may have changed any.
    pub fn changed_boxes(&self, far: f32) -> Option<Vec<Aabb>> {
        let touched = self.changes()?;
        let after = touched.after.iter().map(|node| self.operands.get(node));
        let after = after.collect::<Option<Vec<&Operand>>>()?;
        let all = || touched.before.iter().chain(after.iter().copied());
        let acts = |operand: &&Operand| operand.takes_part;
        let is_everywhere = |operand: &Operand| {
            operand.operator.kind == OperatorKind::Intersect || !operand.extent.aabb.is_finite()
        };
        if all()
            .filter(|operand| operand.takes_part)
            .any(is_everywhere)
        {
            return None;
        }
        // The blends of what is gone count too.
        let [root, inner] = self.counts.largest_blends();
        let blend_of = |is_inner: bool, known: f32| {
            let gone = touched
                .before
                .iter()
                .filter(|operand| (operand.group != ROOT) == is_inner);
            gone.map(|gone| gone.operator.blend).fold(known, f32::max)
        };
        let chamfered = self.counts.has_chamfers() || all().any(Operand::is_chamfered);
        let falls = [
            max_blend_propagation(blend_of(false, root), chamfered, far),
            max_blend_propagation(blend_of(true, inner), false, 0.0),
        ];
        let parts = PartGrid {
            far,
            ..self.index.parts
        };
        let boxes = all().filter(acts).map(|operand| {
            let joints = self.groups.joints_of(operand.operator, operand.group);
            parts.reached_by(joints.iter().rev(), &operand.extent, falls)
        });
        Some(boxes.collect())
    }
}
