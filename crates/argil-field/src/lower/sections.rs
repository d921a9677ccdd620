//! Lowers ramps, and the modifiers that change a solid's space along them or take its section.

use super::error::LowerError;
use super::frame::Frame;
use super::lowering::{Lowering, LoweringTask};
use super::params::{affine_words, repeat_words};
use crate::FAR;
use crate::ramps::RAMP_WORDS;
use argil_abi as abi;
use argil_scene::{Curve, Extent, Modifier, NodeDesc, NodeId, Ramp, wrap_copies, wrap_core};
use glam::Vec3;

impl Lowering<'_> {
    /// Opens a modifier of this file in the node's own frame. The outer point is saved.
    pub(super) fn open_section(
        &mut self,
        node: NodeId,
        modifier: &Modifier,
        content: &Extent,
        frame: &mut Frame,
        closing: &mut Vec<LoweringTask>,
    ) -> Result<(), LowerError> {
        match *modifier {
            Modifier::Shift { by, ref along } => {
                let words = [&by[..], &ramp_words(along)].concat();
                let instr = self.with(abi::OP_SHIFT, &words);
                self.emit(instr);
                frame.scale /= f64::from(modifier.stretch(content));
            }
            Modifier::Extrude { half_depth } => {
                let words = [half_depth, frame.scale as f32];
                let instr = self.with(abi::OP_FLATTEN, &words);
                self.emit(instr);
                closing.push(LoweringTask::Emit(abi::Instruction {
                    op: abi::OP_EXTRUDE,
                    ..instr
                }));
            }
            Modifier::Revolve { offset } => {
                let instr = self.with(abi::OP_REVOLVE, &[offset]);
                self.emit(instr);
            }
            Modifier::Wrap {
                from,
                to,
                radius,
                ref curve,
            } => {
                let length = to - from;
                let core = wrap_core(radius, content.aabb);
                let length_scale = frame.scale as f32;
                frame.scale /= f64::from(modifier.stretch(content));
                let (low, high) = (content.aabb.min.y.max(-FAR), content.aabb.max.y.min(FAR));
                let outer = (radius + content.aabb.max.z).clamp(0.0, FAR);
                let measures = [
                    from,
                    length,
                    radius,
                    core,
                    frame.scale as f32,
                    low,
                    high,
                    outer,
                    length_scale,
                ];
                let words = [&measures[..], &curve_words(curve)].concat();
                let instr = self.with(abi::OP_WRAP, &words);
                self.emit(instr);
                closing.push(LoweringTask::Emit(abi::Instruction {
                    op: abi::OP_UNWRAP,
                    ..instr
                }));
                let copies = wrap_copies([from, to], curve, content.aabb);
                if copies.spacing <= 0.0 {
                    return Ok(());
                }
                let count = [2 * copies.sides + 1, 1, 1];
                let (words, copies) = repeat_words([copies.spacing, 0.0, 0.0], Some(count), count);
                self.open_loop(
                    node,
                    (abi::OP_REPEAT, &words, copies),
                    content,
                    frame,
                    closing,
                )?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Emits the ramp of a node's morph, before its joint.
    pub(super) fn ramp_before_joint(
        &mut self,
        entry: &NodeDesc,
        frame: Frame,
    ) -> Option<abi::Instruction> {
        let ramp = entry.ramp.as_deref()?;
        let map = affine_words(&frame.own_from_point);
        let mut words = [&map[..], &ramp_words(&ramp.along)].concat();
        for coefficient in &mut words[map.len() + RAMP_WORDS + 1..] {
            *coefficient *= entry.operator.morph_amount;
        }
        Some(self.with_map(abi::OP_RAMP, &frame.own_from_point, &words))
    }
}

fn ramp_words(ramp: &Ramp) -> Vec<f32> {
    let measures = match *ramp {
        Ramp::Line { from, to, .. } => {
            let (from, to) = (Vec3::from(from).as_dvec3(), Vec3::from(to).as_dvec3());
            let per_length = (to - from) / (to - from).length_squared();
            let [x, y, z] = per_length.to_array();
            [0.0, x, y, z, -from.dot(per_length)]
        }
        Ramp::Radius { from, to, .. } => {
            let per_length = 1.0 / (f64::from(to) - f64::from(from));
            [1.0, per_length, -f64::from(from) * per_length, 0.0, 0.0]
        }
    };
    let measures = measures.map(|word| word as f32);
    [&measures[..], &curve_words(ramp.curve())].concat()
}

fn curve_words(curve: &Curve) -> Vec<f32> {
    let pieces = curve.pieces();
    [&[pieces.len() as f32][..], pieces.as_flattened()].concat()
}
