//! Lowers brushes and their modifiers.

use super::error::{LowerError, MAX_COPIES, MAX_COPIES_PER_LOOP};
use super::frame::{Frame, joint, map};
use super::lowering::{Lowering, LoweringTask};
use super::params::{affine_words, is_loop, keep, repeat_words, scale_of};
use crate::WORLD_LIMIT;
use crate::domain_ops::COPY_WORDS;
use crate::params::pack;
use crate::places::ENDLESS;
use argil_abi::{self as abi, Instruction};
use argil_scene::{Extent, Modifier, NodeId, NodeKind, Operator, evaluated_copies};
use glam::DAffine3;
use std::f32::consts::TAU;

/// Returns the opcode of a modifier that offsets its content's distance, and the length in the node's unit.
fn offset_of(modifier: &Modifier) -> Option<(u32, f32)> {
    match *modifier {
        Modifier::Round { radius } => Some((abi::OP_ROUND, radius)),
        Modifier::Shell { half_thickness } => Some((abi::OP_SHELL, half_thickness)),
        _ => None,
    }
}

/// Returns the box of a loop's content, the square of the factor from distances to it to those of the content, and what
/// rounding can add to these.
fn bound_words(content: &Extent, scale: f64) -> [f32; COPY_WORDS] {
    let factor = 0.999_99 * scale / f64::from(content.lipschitz_inverse);
    let ends = content
        .aabb
        .min
        .abs()
        .max(content.aabb.max.abs())
        .to_array();
    let size = ends
        .into_iter()
        .filter(|end| end.is_finite())
        .fold(0.0, f32::max);
    let held = |end: f32| end.clamp(-WORLD_LIMIT, WORLD_LIMIT);
    let [low, high] = [content.aabb.min, content.aabb.max].map(|end| end.to_array().map(held));
    let rounding = 1e-5 * f64::from(size) * scale;
    [
        low[0],
        low[1],
        low[2],
        high[0],
        high[1],
        high[2],
        (factor * factor) as f32,
        rounding as f32,
    ]
}

impl Lowering<'_> {
    pub(super) fn brush(&mut self, node: NodeId, frame: Frame) -> Result<(), LowerError> {
        let entry = self.scene.node(node).at_current_time();
        let mut frame = self.enter(node, frame);
        for modifier in entry.modifiers.iter().rev() {
            map(self.scene, node, modifier, &mut frame)?;
        }
        let joint = joint(&entry.operator, frame.scale / scale_of(entry));
        self.shape(node, frame, joint)
    }

    /// Emits a brush's shape.
    pub(super) fn shape(
        &mut self,
        node: NodeId,
        frame: Frame,
        joint: [f32; 5],
    ) -> Result<(), LowerError> {
        let entry = self.scene.node(node).at_current_time();
        let NodeKind::Shape(shape) = &entry.kind else {
            return Ok(());
        };
        if let Some((path, _, grid)) = shape.file()
            && grid.0.is_none()
        {
            return Err(LowerError::NotLoaded {
                path: self.scene.path(node),
                file: path.to_owned(),
            });
        }
        let m = frame.own_from_point;
        let is_translation =
            frame.scale == 1.0 && m.matrix3.abs_diff_eq(glam::DMat3::IDENTITY, 1e-12);
        let rows = affine_words(&m);
        let mut words = rows.to_vec();
        words.push(frame.scale as f32);
        words.extend(joint);
        let op = pack(shape, &mut words);
        let textures = self.texture_places.get(frame.material as usize);
        let flags = keep(entry)
            | textures.map_or(0, |place| place << abi::TEXTURES_SHIFT)
            | if is_translation {
                abi::FLAG_TRANSLATION
            } else {
                0
            };
        let instr = Instruction {
            flags,
            operand: frame.material,
            ..self.with_map(op, &m, &words)
        };
        self.emit(instr);
        self.program.brushes += 1;
        Ok(())
    }

    pub(super) fn solid(&mut self, node: NodeId, frame: Frame) -> Result<(), LowerError> {
        let count = self.scene.node(node).at_current_time().modifiers.len();
        let frame = self.enter(node, frame);
        self.stages(node, count, frame)
    }

    /// Emits a node with its first `count` modifiers, in its own frame.
    pub(super) fn stages(
        &mut self,
        node: NodeId,
        count: usize,
        mut frame: Frame,
    ) -> Result<(), LowerError> {
        let entry = self.scene.node(node).at_current_time();
        let stages = self.extents.modifier_stages(node);
        // The modifiers from the outermost inward: what opens now, and what closes after the content, innermost
        // first.
        let mut closing: Vec<LoweringTask> = Vec::new();
        let modifiers = entry.modifiers[..count].iter().zip(&stages);
        for (index, (modifier, content)) in modifiers.enumerate().rev() {
            if let Modifier::Instances { poses } = modifier {
                self.tasks.extend(closing);
                let bounds = (content, frame);
                if !self.emit_brush_instances(node, index, poses, bounds)? {
                    self.push_instances(node, index, poses, bounds);
                }
                return Ok(());
            }
            if modifier.affine().is_some() {
                map(self.scene, node, modifier, &mut frame)?;
            } else if let Some((op, length)) = offset_of(modifier) {
                let length = (f64::from(length) * frame.scale) as f32;
                closing.push(LoweringTask::Emit(self.with(op, &[length])));
            } else if !matches!(modifier, Modifier::Repeat { .. }) || is_loop(modifier) {
                // One copy is not a repetition.
                self.open(node, modifier, content, &mut frame, &mut closing)?;
            }
        }
        self.tasks.extend(closing);
        if matches!(entry.kind, NodeKind::Shape(_)) {
            // Onto an empty accumulator, with a hard union.
            self.shape(node, frame, joint(&Operator::default(), 1.0))?;
        } else {
            let count = self.operands[&node].len();
            self.tasks.push(LoweringTask::List {
                group: node,
                count,
                frame,
            });
        }
        Ok(())
    }

    /// Opens a modifier that changes the point in the node's own frame. The outer point is saved.
    fn open(
        &mut self,
        node: NodeId,
        modifier: &Modifier,
        content: &Extent,
        frame: &mut Frame,
        closing: &mut Vec<LoweringTask>,
    ) -> Result<(), LowerError> {
        self.emit(Instruction {
            op: abi::OP_PUSH_POINT,
            ..Instruction::default()
        });
        closing.push(LoweringTask::Emit(Instruction {
            op: abi::OP_POP_POINT,
            ..Instruction::default()
        }));
        if frame.own_from_point != DAffine3::IDENTITY {
            let map = frame.own_from_point;
            let instr = self.with_map(abi::OP_AFFINE, &map, &affine_words(&map));
            self.emit(instr);
            frame.own_from_point = DAffine3::IDENTITY;
        }
        match *modifier {
            Modifier::Mirror { axes } => {
                let instr = self.with(abi::OP_MIRROR, &axes.map(|on| if on { 1.0 } else { 0.0 }));
                self.emit(instr);
            }
            Modifier::Elongate { by } => {
                let instr = self.with(abi::OP_ELONGATE, &by);
                self.emit(instr);
            }
            Modifier::Repeat { spacing, count } => {
                let looked_at = evaluated_copies(modifier, content);
                let (words, copies) = repeat_words(spacing, count, looked_at);
                self.open_loop(
                    node,
                    (abi::OP_REPEAT, &words, copies),
                    content,
                    frame,
                    closing,
                )?;
            }
            Modifier::RadialRepeat { count } => {
                let copies = evaluated_copies(modifier, content)[0];
                let words = [count as f32, TAU / count as f32, copies as f32];
                let copies = u64::from(copies);
                self.open_loop(
                    node,
                    (abi::OP_RADIAL, &words, copies),
                    content,
                    frame,
                    closing,
                )?;
            }
            Modifier::Twist { degrees_per_unit } | Modifier::Bend { degrees_per_unit } => {
                self.open_warp(node, modifier, degrees_per_unit, content, frame, closing)?;
            }
            Modifier::Displace {
                amplitude,
                frequency,
                seed,
                octaves,
            } => {
                let stretch = f64::from(modifier.stretch(content));
                let most =
                    f64::from(amplitude) * frame.scale * (2.0 - 0.5f64.powi(octaves as i32 - 1));
                frame.scale /= stretch;
                // Where the distance less the most is longer than the divided one with the most noise.
                let far =
                    (most / stretch) * (1.0 + 1.0 / stretch) / (1.0 - 1.0 / stretch).max(1e-9);
                let words = [
                    f64::from(amplitude) * frame.scale,
                    f64::from(frequency),
                    f64::from(octaves),
                    stretch,
                    most,
                    1.000_01 * far,
                ];
                closing.push(LoweringTask::Emit(Instruction {
                    operand: seed,
                    ..self.with(abi::OP_DISPLACE, &words.map(|word| word as f32))
                }));
            }
            _ => self.open_section(node, modifier, content, frame, closing)?,
        }
        Ok(())
    }

    fn open_warp(
        &mut self,
        node: NodeId,
        modifier: &Modifier,
        degrees_per_unit: f32,
        content: &Extent,
        frame: &mut Frame,
        closing: &mut Vec<LoweringTask>,
    ) -> Result<(), LowerError> {
        let (op, what) = match modifier {
            Modifier::Twist { .. } => (abi::OP_TWIST, "twist"),
            _ => (abi::OP_BEND, "bend"),
        };
        if content.aabb.is_empty() {
            return Ok(());
        }
        let held = modifier.clamp(content).filter(|held| held.aabb.is_finite());
        let Some(held) = held else {
            return Err(LowerError::Infinite {
                path: self.scene.path(node),
                what,
            });
        };
        let [mut min, mut max] = [held.aabb.min, held.aabb.max];
        if held.radius.is_finite() {
            // The radius holds the points.
            (min.x, min.z, max.x, max.z) = (-ENDLESS, -ENDLESS, ENDLESS, ENDLESS);
        }
        let mut words = [min.to_array(), max.to_array()].concat();
        // The gap to the box is in the node's own unit, and distances are in the scene's.
        words.extend([
            degrees_per_unit.to_radians(),
            frame.scale as f32,
            held.radius.min(ENDLESS),
        ]);
        let instr = self.with(op, &words);
        self.emit(instr);
        frame.scale /= f64::from(modifier.stretch(content));
        closing.push(LoweringTask::Emit(self.with(abi::OP_UNCLAMP, &words)));
        Ok(())
    }

    pub(super) fn open_loop(
        &mut self,
        node: NodeId,
        (op, words, copies): (u32, &[f32], u64),
        content: &Extent,
        frame: &mut Frame,
        closing: &mut Vec<LoweringTask>,
    ) -> Result<(), LowerError> {
        frame.copies = frame.copies.saturating_mul(copies);
        if copies > MAX_COPIES_PER_LOOP && op == abi::OP_REPEAT || frame.copies > MAX_COPIES {
            return Err(LowerError::TooManyCopies {
                path: self.scene.path(node),
                count: if frame.copies > MAX_COPIES {
                    frame.copies
                } else {
                    copies
                },
                limit: if frame.copies > MAX_COPIES {
                    MAX_COPIES
                } else {
                    MAX_COPIES_PER_LOOP
                },
            });
        }
        let jump = [frame.jump.unwrap_or(0.0)];
        let words = [words, &jump, &bound_words(content, frame.scale)].concat();
        let instr = self.with(op, &words);
        closing.push(LoweringTask::Next {
            begin: self.program.instructions.len(),
        });
        self.emit(instr);
        Ok(())
    }
}
