//! A scene, or a piece of one, while it is lowered: what is still to be emitted.

use super::error::LowerError;
use super::frame::{Frame, combine_words, extent_in_world};
use super::words::is_single;
use crate::by_node::ByNode;
use crate::pieces::scaled;
use crate::program::Program;
use crate::regular::Regularity;
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::{self as abi, Instr};
use argil_scene::{Entry, Extents, NodeId, Scene};
use rustc_hash::FxHashMap;
use std::collections::HashMap;

/// Of no more operands than this a list is as soon looked through.
pub(super) const FEW_OPERANDS: usize = 64;

/// What is still to be emitted, the next on top.
pub(super) enum Task {
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
    /// A brush without folds or offsets, straight onto the accumulator.
    Brush {
        node: NodeId,
        frame: Frame,
    },
    Emit(Instr),
    /// The end of the loop that begins at an instruction.
    Next {
        begin: usize,
    },
    /// The beginning of a piece.
    BeginPiece,
    /// Its end.
    EndPiece {
        node: NodeId,
        within: Open,
    },
}

/// An open group where it is lowered.
#[derive(Clone, Copy)]
pub(super) struct Open {
    /// Its place among the program's.
    pub(super) group: u32,
    /// What a length in it is in the world.
    pub(super) scale: f32,
}

pub(super) struct Lowering<'a> {
    pub(super) scene: &'a Scene,
    pub(super) extents: Extents<'a>,
    /// By group: its operands that take part.
    pub(super) operands: HashMap<NodeId, Vec<NodeId>>,
    /// By node: stack slots to evaluate it into an empty accumulator.
    pub(super) slots: ByNode<u32>,
    /// By node: what can be said of its distances.
    pub(super) regular: ByNode<Regularity>,
    /// By group: slots to evaluate its first 1, 2, … operands.
    pub(super) prefix_slots: HashMap<NodeId, Vec<u32>>,
    pub(super) material_index: HashMap<&'a str, u32>,
    pub(super) program: Program,
    pub(super) points: usize,
    pub(super) tasks: Vec<Task>,
    /// The open groups, where there are so many pieces that their places are kept: what those hold is emitted in the scene's
    /// order. And where the piece begins that is emitted.
    pub(super) open: FxHashMap<NodeId, Open>,
    pub(super) begun: u32,
}

impl<'a> Lowering<'a> {
    pub(super) fn emit_all(&mut self) -> Result<(), LowerError> {
        while let Some(task) = self.tasks.pop() {
            match task {
                Task::Emit(instr) => self.emit(instr),
                Task::Next { begin } => self.emit(Instr {
                    op: abi::OP_NEXT,
                    operand: begin as u32,
                    ..Instr::default()
                }),
                Task::BeginPiece => self.begun = self.program.instrs.len() as u32,
                Task::EndPiece { node, within } => {
                    let operator = scaled(&self.scene.node(node).acting().operator, within.scale);
                    let extent = extent_in_world(self.scene, &mut self.extents, node);
                    self.program.operands.push(OperandSpan {
                        begin: self.begun,
                        end: self.program.instrs.len() as u32,
                        group: within.group,
                        operator,
                        extent,
                    });
                }
                Task::List {
                    group,
                    count,
                    frame,
                } => self.list(group, count, frame),
                Task::Solid { node, frame } => self.solid(node, frame)?,
                Task::Brush { node, frame } => self.brush(node, frame)?,
            }
        }
        Ok(())
    }

    pub(super) fn emit(&mut self, instr: Instr) {
        match instr.op {
            abi::OP_PUSH_POINT | abi::OP_REPEAT | abi::OP_RADIAL | abi::OP_TWIST | abi::OP_BEND => {
                self.points += 1
            }
            abi::OP_POP_POINT | abi::OP_NEXT | abi::OP_UNCLAMP => self.points -= 1,
            _ => {}
        }
        self.program.point_slots = self.program.point_slots.max(self.points);
        self.program.instrs.push(instr);
    }

    /// An instruction with parameters.
    pub(super) fn with(&mut self, op: u32, words: &[f32]) -> Instr {
        let params = self.program.params.len() as u32;
        self.program.params.extend_from_slice(words);
        Instr {
            op,
            params,
            ..Instr::default()
        }
    }

    pub(super) fn list(&mut self, group: NodeId, count: usize, frame: Frame) {
        let Some(last) = count.checked_sub(1) else {
            return;
        };
        let node = self.operands[&group][last];
        let entry = self.scene.node(node).acting();
        let around = self.open.get(&group).copied();
        let is_piece = around.is_some() && !self.open.contains_key(&node);
        let begin = is_piece.then_some(Task::BeginPiece);
        let end = around.filter(|_| is_piece);
        let end = end.map(|within| Task::EndPiece { node, within });
        self.tasks.extend(end);
        if last == 0 {
            // What is first in a group is in nothing else: so is what an open group holds.
            if let Some(within) = around
                && let Some(own) = self.open.get_mut(&node)
            {
                own.group = within.group;
            }
            self.tasks.push(Task::Solid { node, frame });
            self.tasks.extend(begin);
            return;
        }
        let before = Task::List {
            group,
            count: last,
            frame,
        };
        if is_single(entry) {
            self.tasks.push(Task::Brush { node, frame });
            self.tasks.extend(begin);
            self.tasks.push(before);
            return;
        }
        let swapped = around.is_none() && self.slots[node] > self.prefix_slots[&group][last - 1];
        let close = self.combine(entry, frame, swapped);
        let open = Instr {
            op: abi::OP_PUSH_VALUE,
            ..Instr::default()
        };
        if let Some(within) = around
            && let Some(own) = self.open.get(&node)
        {
            self.program.groups[own.group as usize] = GroupSpan {
                parent: within.group,
                operator: scaled(&entry.operator, within.scale),
                open,
                close,
            };
        }
        self.tasks.push(Task::Emit(close));
        let solid = Task::Solid { node, frame };
        let (first, second) = if swapped {
            (solid, before)
        } else {
            (before, solid)
        };
        self.tasks.extend([second, Task::Emit(open)]);
        self.tasks.extend(begin);
        self.tasks.push(first);
    }

    pub(super) fn combine(&mut self, entry: &Entry, frame: Frame, swapped: bool) -> Instr {
        let (flags, words) = combine_words(entry, frame, swapped);
        Instr {
            flags,
            ..self.with(abi::OP_COMBINE, &words)
        }
    }

    /// A node's frame from that of its group.
    pub(super) fn enter(&self, node: NodeId, frame: Frame) -> Frame {
        let entry = self.scene.node(node).acting();
        let material = match &entry.material {
            Some(name) => self
                .material_index
                .get(name.as_str())
                .copied()
                .unwrap_or(frame.material),
            None => frame.material,
        };
        let own = || {
            let own = self.regular[node];
            (node != Scene::ROOT).then_some(own.slack + own.hidden)
        };
        Frame {
            material,
            jump: frame.jump.or_else(own),
            ..frame
        }
    }
}
