//! The state of lowering a scene or a piece: what is still to be emitted.

use super::error::LowerError;
use super::frame::{Frame, combine_words, extent_in_world, open_of};
use super::params::{align, is_single};
use crate::node_map::NodeMap;
use crate::pieces::scaled;
use crate::places::place_words;
use crate::program::Program;
use crate::regularity::Regularity;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::{self as abi, Instruction};
use argil_scene::{Extent, Extents, NodeId, Pose, Scene};
use glam::DAffine3;
use rustc_hash::FxHashMap;
use std::collections::HashMap;

/// A list of up to this many operands is not worth an index.
pub(super) const FEW_OPERANDS: usize = 64;

/// What is still to be emitted, next on top.
pub(super) enum LoweringTask {
    /// The first `count` operands of a group, into an empty accumulator.
    List {
        group: NodeId,
        count: usize,
        frame: Frame,
    },
    /// A node with its modifiers, into an empty accumulator.
    Solid {
        node: NodeId,
        frame: Frame,
    },
    /// A node with its first `count` modifiers, into an empty accumulator.
    Stages {
        node: NodeId,
        count: usize,
        frame: Frame,
    },
    /// The instances from the one at `begin` on, which are sorted by scale, of a node with its first `count` modifiers.
    Instances {
        node: NodeId,
        count: usize,
        sorted: Vec<Pose>,
        begin: usize,
        content: Extent,
        frame: Frame,
    },
    /// The first of some instances begins. Instances of other scales may come before it.
    BeginInstances {
        node: NodeId,
        pose: Pose,
        content: Extent,
        frame: Frame,
        is_first: bool,
    },
    /// The first of some instances ends. The others follow.
    EndInstances {
        node: NodeId,
        others: Vec<Pose>,
        content: Extent,
        frame: Frame,
        is_first: bool,
    },
    /// A brush without folds or offsets, directly onto the accumulator.
    Brush {
        node: NodeId,
        frame: Frame,
    },
    Emit(Instruction),
    /// The end of the loop that begins at an instruction.
    Next {
        begin: usize,
    },
    /// The beginning of a piece.
    BeginPiece,
    /// The end of a piece.
    EndPiece {
        node: NodeId,
        within: OpenScope,
    },
}

/// An open group that is being lowered.
#[derive(Clone, Copy)]
pub(super) struct OpenScope {
    /// Its index among the program's groups.
    pub(super) group: u32,
    /// The length of its unit in the scene's unit.
    pub(super) scale: f32,
}

pub(super) struct Lowering<'a> {
    pub(super) scene: &'a Scene,
    pub(super) extents: Extents<'a>,
    /// The operands of each group that take part.
    pub(super) operands: HashMap<NodeId, Vec<NodeId>>,
    /// The stack slots that each node needs with an empty accumulator.
    pub(super) slots: NodeMap<u32>,
    /// The regularity of each node's distances.
    pub(super) regular: NodeMap<Regularity>,
    /// The slots that the first 1, 2, … operands of each group need.
    pub(super) prefix_slots: HashMap<NodeId, Vec<u32>>,
    pub(super) material_index: HashMap<&'a str, u32>,
    /// See [`texture_places`](crate::materials::texture_places).
    pub(super) texture_places: Vec<u32>,
    pub(super) program: Program,
    pub(super) points: usize,
    pub(super) tasks: Vec<LoweringTask>,
    /// The open groups, if there are so many pieces that their places are kept. Their contents are emitted in the
    /// scene's order. Also the beginning of the current piece.
    pub(super) open: FxHashMap<NodeId, OpenScope>,
    pub(super) begun: u32,
    /// Where the instances begin that are being lowered, innermost last, and the number of brushes before them.
    pub(super) instances: Vec<(usize, usize)>,
}

impl<'a> Lowering<'a> {
    pub(super) fn emit_all(&mut self) -> Result<(), LowerError> {
        while let Some(task) = self.tasks.pop() {
            match task {
                LoweringTask::Emit(instr) => self.emit(instr),
                LoweringTask::Next { begin } => self.emit(Instruction {
                    op: abi::OP_NEXT,
                    operand: begin as u32,
                    ..Instruction::default()
                }),
                LoweringTask::BeginPiece => self.begun = self.program.instructions.len() as u32,
                LoweringTask::EndPiece { node, within } => {
                    let operator = scaled(
                        &self.scene.node(node).at_current_time().operator,
                        within.scale,
                    );
                    let extent = extent_in_world(self.scene, &mut self.extents, node);
                    self.program.operands.push(OperandSpan {
                        begin: self.begun,
                        end: self.program.instructions.len() as u32,
                        group: within.group,
                        operator,
                        extent,
                    });
                }
                LoweringTask::List {
                    group,
                    count,
                    frame,
                } => self.list(group, count, frame),
                LoweringTask::Solid { node, frame } => self.solid(node, frame)?,
                LoweringTask::Stages { node, count, frame } => self.stages(node, count, frame)?,
                LoweringTask::Instances {
                    node,
                    count,
                    sorted,
                    begin,
                    content,
                    frame,
                } => {
                    self.push_instances_of_a_scale((node, count), (sorted, begin), (content, frame))
                }
                LoweringTask::BeginInstances {
                    node,
                    pose,
                    content,
                    frame,
                    is_first,
                } => self.begin_instances(node, pose, (&content, frame), is_first)?,
                LoweringTask::EndInstances {
                    node,
                    others,
                    content,
                    frame,
                    is_first,
                } => self.end_instances(node, others, &content, frame, is_first)?,
                LoweringTask::Brush { node, frame } => self.brush(node, frame)?,
            }
        }
        Ok(())
    }

    pub(super) fn emit(&mut self, instr: Instruction) {
        match instr.op {
            abi::OP_REPEAT | abi::OP_RADIAL => self.points += 1,
            abi::OP_NEXT => self.points -= 1,
            op if abi::saves_point(op) => self.points += 1,
            op if abi::restores_point(op) => self.points -= 1,
            _ => {}
        }
        self.program.point_slots = self.program.point_slots.max(self.points);
        self.program.instructions.push(instr);
    }

    /// Emits an instruction with parameters.
    pub(super) fn with(&mut self, op: u32, words: &[f32]) -> Instruction {
        let params = self.program.params.len() as u32;
        self.program.params.extend_from_slice(words);
        align(&mut self.program.params);
        Instruction {
            op,
            params,
            ..Instruction::default()
        }
    }

    /// Emits parameters that begin with a map, after the place that it moves to its frame's origin.
    pub(super) fn with_map(&mut self, op: u32, map: &DAffine3, words: &[f32]) -> Instruction {
        self.program.params.extend_from_slice(&place_words(map));
        self.with(op, words)
    }

    pub(super) fn list(&mut self, group: NodeId, count: usize, frame: Frame) {
        let Some(last) = count.checked_sub(1) else {
            return;
        };
        let node = self.operands[&group][last];
        let entry = self.scene.node(node).at_current_time();
        let around = self.open.get(&group).copied();
        let is_piece = around.is_some() && !self.open.contains_key(&node);
        let begin = is_piece.then_some(LoweringTask::BeginPiece);
        let end = around.filter(|_| is_piece);
        let end = end.map(|within| LoweringTask::EndPiece { node, within });
        self.tasks.extend(end);
        if last == 0 {
            // The first operand of a group is in nothing else, and so are the contents of an open group.
            if let Some(within) = around
                && let Some(scope) = self.open.get_mut(&node)
            {
                scope.group = within.group;
            }
            self.tasks.push(LoweringTask::Solid { node, frame });
            self.tasks.extend(begin);
            return;
        }
        let before = LoweringTask::List {
            group,
            count: last,
            frame,
        };
        if is_single(entry) {
            self.tasks.push(LoweringTask::Brush { node, frame });
            self.tasks.extend(begin);
            self.tasks.push(before);
            return;
        }
        let swapped = around.is_none() && self.slots[node] > self.prefix_slots[&group][last - 1];
        let ramp = self.ramp_before_joint(entry, frame);
        let close = self.combine(node, frame, swapped);
        let open = open_of(close.flags);
        if let Some(within) = around
            && let Some(known_scope) = self.open.get(&node)
        {
            self.program.groups[known_scope.group as usize] = GroupSpan {
                parent: within.group,
                operator: scaled(&entry.operator, within.scale),
                open,
                close,
            };
        }
        self.tasks.push(LoweringTask::Emit(close));
        self.tasks.extend(ramp.map(LoweringTask::Emit));
        let solid = LoweringTask::Solid { node, frame };
        let (first, second) = if swapped {
            (solid, before)
        } else {
            (before, solid)
        };
        self.tasks.extend([second, LoweringTask::Emit(open)]);
        self.tasks.extend(begin);
        self.tasks.push(first);
    }

    pub(super) fn combine(&mut self, node: NodeId, frame: Frame, swapped: bool) -> Instruction {
        let entry = self.scene.node(node).at_current_time();
        let (mut flags, words) = combine_words(entry, frame, swapped);
        let mut words = words.to_vec();
        if let Some(ramp) = &entry.ramp {
            flags = flags & !abi::COMBINE_MASK | abi::COMBINE_RAMPED;
            words.extend([
                (f64::from(ramp.max_difference) * frame.scale) as f32,
                1.0 / self.scene.ramp_stretch(node),
            ]);
        }
        Instruction {
            flags,
            ..self.with(abi::OP_COMBINE, &words)
        }
    }

    /// Returns a node's frame, given its group's.
    pub(super) fn enter(&self, node: NodeId, frame: Frame) -> Frame {
        let entry = self.scene.node(node).at_current_time();
        let material = match &entry.material {
            Some(name) => self
                .material_index
                .get(name.as_str())
                .copied()
                .unwrap_or(frame.material),
            None => frame.material,
        };
        let jump_of_node = || {
            let regularity = self.regular[node];
            (node != Scene::ROOT).then_some(regularity.slack + regularity.hidden)
        };
        Frame {
            material,
            jump: frame.jump.or_else(jump_of_node),
            ..frame
        }
    }
}
