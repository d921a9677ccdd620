//! A scene's list of brushes as a program.

mod error;
mod words;

use crate::by_node::ByNode;
use crate::loose::loose_of;
use crate::materials::materials_of;
use crate::pack::pack;
use crate::pieces::{
    self, OpenGroup, Piece, Pieces, ROOT, Told, is_open, magnitude, regularity_of, scaled,
};
use crate::program::Program;
use crate::regular::{Regularity, regularity};
use crate::spans::{GroupSpan, OperandSpan};
use argil_abi::{self as abi, Instr};
use argil_scene::{
    Body, Entry, Extent, Extents, Modifier, NodeId, Operator, OperatorKind, Profile, Scene,
    copies_looked_at,
};
pub use error::LowerError;
use error::{MAX_COPIES, MAX_COPIES_A_LOOP};
use glam::DAffine3;
use rustc_hash::FxHashMap;
use std::collections::HashMap;
use std::f32::consts::TAU;
use words::{affine_words, is_loop, is_single, keep, repeat_words, scale_of};

/// Where a node is evaluated: the map from the interpreter's point to the node's frame, the factor from its distances
/// to the world's, its material, and the copies looked at around it.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    own_from_point: DAffine3,
    scale: f64,
    material: u32,
    copies: u64,
    /// By how much the distances of the operand of the root can jump that it is in, once that is known.
    jump: Option<f32>,
}

/// Of no more operands than this a list is as soon looked through.
const FEW_OPERANDS: usize = 64;

/// What is still to be emitted, the next on top.
enum Task {
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
struct Open {
    /// Its place among the program's.
    group: u32,
    /// What a length in it is in the world.
    scale: f32,
}

struct Lowering<'a> {
    scene: &'a Scene,
    extents: Extents<'a>,
    /// By group: its operands that take part.
    operands: HashMap<NodeId, Vec<NodeId>>,
    /// By node: stack slots to evaluate it into an empty accumulator.
    slots: ByNode<u32>,
    /// By node: what can be said of its distances.
    regular: ByNode<Regularity>,
    /// By group: slots to evaluate its first 1, 2, … operands.
    prefix_slots: HashMap<NodeId, Vec<u32>>,
    material_index: HashMap<&'a str, u32>,
    program: Program,
    points: usize,
    tasks: Vec<Task>,
    /// The open groups, where there are so many pieces that their places are kept: what those hold is emitted in the scene's
    /// order. And where the piece begins that is emitted.
    open: FxHashMap<NodeId, Open>,
    begun: u32,
}

impl Program {
    /// Lower a scene. Time and memory are linear in the number of its nodes.
    pub fn lower(scene: &Scene) -> Result<Self, LowerError> {
        let pieces = Pieces::of(scene);
        let mut lowering = Lowering::of(scene, Scene::ROOT, Some(&pieces));
        lowering.measure_pieces(&pieces);
        lowering.program.materials = materials_of(scene);
        lowering.tasks.push(Task::Solid {
            node: Scene::ROOT,
            frame: Frame::OF_WORLD,
        });
        lowering.emit_all()?;
        Ok(lowering.program)
    }

    /// Whether the piece that holds a node can be lowered, but for meshes that are not loaded yet; all of an open group where the node
    /// is that.
    ///
    /// # Errors
    /// As [`Program::lower`].
    pub fn check(scene: &Scene, node: NodeId) -> Result<(), LowerError> {
        // From the node up to the root.
        let mut path = vec![node];
        while let Some(parent) = scene.node(path[path.len() - 1]).parent() {
            path.push(parent);
        }
        if path.pop() != Some(Scene::ROOT) {
            return Ok(());
        }
        let (mut frame, mut scale) = (Frame::OF_WORLD, 1.0);
        let mut depth = 0;
        while let [.., _, outer] = path[..]
            && is_open(scene, outer, depth)
        {
            frame = Around::of(scene, outer, frame)?.frame;
            scale *= pieces::scale_of(scene.node(outer).acting());
            path.pop();
            depth += 1;
        }
        let Some(&piece) = path.last() else {
            return Ok(());
        };
        match Self::lower_piece(scene, piece, frame, scale) {
            Err(LowerError::NotLoaded { .. }) | Ok(_) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Lower a piece, onto whatever is in the accumulator: a program whose list can follow any other's. `within` is the frame of the
    /// group that it is in, whose unit is `scale` in the world.
    pub(crate) fn lower_piece(
        scene: &Scene,
        node: NodeId,
        within: Frame,
        scale: f32,
    ) -> Result<Self, LowerError> {
        let mut lowering = Lowering::of(scene, node, None);
        let own = lowering.regular[node].scaled(scale);
        lowering.program.magnitude = magnitude(&lowering.extents.outer(node), scale);
        lowering.set_regularity(own);
        let frame = Frame {
            jump: Some(own.slack + own.hidden),
            ..within
        };
        let entry = scene.node(node).acting();
        if is_single(entry) {
            lowering.tasks.push(Task::Brush { node, frame });
        } else {
            lowering.program.value_slots += 1;
            let combine = lowering.combine(entry, frame, false);
            lowering.emit(Instr {
                op: abi::OP_PUSH_VALUE,
                ..Instr::default()
            });
            lowering.tasks.push(Task::Emit(combine));
            lowering.tasks.push(Task::Solid { node, frame });
        }
        lowering.emit_all()?;
        Ok(lowering.program)
    }
}

/// What stands around the pieces of an open group.
pub(crate) struct Around {
    /// The frame of what is in it.
    pub frame: Frame,
    /// What puts aside what is before it, and what joins it to that; both with parameters at 0.
    pub open: Instr,
    pub close: Instr,
    pub params: Vec<f32>,
}

impl Around {
    /// Of a group in a frame.
    pub fn of(scene: &Scene, node: NodeId, within: Frame) -> Result<Self, LowerError> {
        let entry = scene.node(node).acting();
        let names = || scene.materials().keys().zip(1..);
        let named = entry.material.as_ref();
        let found = named.and_then(|name| names().find(|(own, _)| *own == name));
        let mut frame = Frame {
            material: found.map_or(within.material, |(_, index)| index),
            ..within
        };
        for modifier in entry.modifiers.iter().rev() {
            map(scene, node, modifier, &mut frame)?;
        }
        let (flags, words) = combine_words(entry, within, false);
        Ok(Self {
            frame,
            open: Instr {
                op: abi::OP_PUSH_VALUE,
                ..Instr::default()
            },
            close: Instr {
                op: abi::OP_COMBINE,
                flags,
                ..Instr::default()
            },
            params: words.to_vec(),
        })
    }
}

/// k, 1/(4k) and the signs.
fn joint(operator: &Operator, scale: f64) -> [f32; 5] {
    let k = (f64::from(operator.blend) * scale) as f32;
    let quarter = if k > 0.0 { 0.25 / k } else { 0.0 };
    let [a, b, r] = match operator.kind {
        OperatorKind::Subtract => [-1.0, 1.0, -1.0],
        OperatorKind::Intersect => [-1.0, -1.0, -1.0],
        _ => [1.0, 1.0, 1.0],
    };
    [k, quarter, a, b, r]
}

/// The flags and words of a joint with what was put aside.
fn combine_words(entry: &Entry, frame: Frame, swapped: bool) -> (u32, [f32; 6]) {
    let mode = match (entry.operator.kind, entry.operator.profile) {
        (OperatorKind::Paint, _) => abi::COMBINE_PAINT,
        (OperatorKind::Morph, _) => abi::COMBINE_MORPH,
        (_, Profile::Chamfer) => abi::COMBINE_CHAMFER,
        (_, Profile::Smooth) => abi::COMBINE_SMOOTH,
    };
    let [k, quarter, a, b, r] = joint(&entry.operator, frame.scale);
    let flags = mode | keep(entry) | if swapped { abi::FLAG_SWAPPED } else { 0 };
    (flags, [k, quarter, a, b, r, entry.operator.amount])
}

/// A node's extent in the world, where all groups around it are open.
pub(crate) fn extent_in_world(scene: &Scene, extents: &mut Extents<'_>, node: NodeId) -> Extent {
    let mut extent = extents.outer(node);
    let mut at = scene.node(node).parent();
    while let Some(group) = at {
        extent = extent.under(&scene.node(group).acting().modifiers);
        at = scene.node(group).parent();
    }
    extent
}

/// A translate, rotate, scale or stretch.
fn map(
    scene: &Scene,
    node: NodeId,
    modifier: &Modifier,
    frame: &mut Frame,
) -> Result<(), LowerError> {
    if let Some(map) = modifier.affine() {
        frame.own_from_point = map * frame.own_from_point;
        frame.scale *= f64::from(modifier.scale());
        if !(1e-6..=1e6).contains(&frame.scale) {
            return Err(LowerError::Scale {
                path: scene.path(node),
                scale: frame.scale,
            });
        }
    }
    Ok(())
}

impl Frame {
    pub const OF_WORLD: Self = Self {
        own_from_point: DAffine3::IDENTITY,
        scale: 1.0,
        material: 0,
        copies: 1,
        jump: None,
    };
}

impl<'a> Lowering<'a> {
    /// Of a node and all that it holds; nothing is emitted yet. `pieces` are those of the root.
    fn of(scene: &'a Scene, root: NodeId, pieces: Option<&Pieces>) -> Self {
        let names = scene.materials().keys().map(String::as_str);
        let material_index = names.zip(1..).collect();
        let mut extents = Extents::of(scene);
        let aabb = extents.outer(root).aabb;
        let parents_first: Vec<NodeId> = scene.walk_from(root).collect();
        let all = regularity(scene, &mut extents, &parents_first);
        let regular = all[root];
        let mut lowering = Lowering {
            scene,
            extents,
            operands: HashMap::new(),
            slots: ByNode::of(&parents_first, 0),
            regular: all,
            prefix_slots: HashMap::new(),
            material_index,
            program: Program {
                instrs: Vec::new(),
                params: Vec::new(),
                materials: Vec::new(),
                aabb,
                magnitude: 0.0,
                lipschitz: regular.lipschitz,
                slack: regular.slack,
                hidden_slack: regular.hidden,
                isolation: regular.isolation,
                underestimate: regular.underestimate,
                loose: Vec::new(),
                operands: Vec::new(),
                groups: Vec::new(),
                value_slots: 0,
                point_slots: 0,
                brushes: 0,
            },
            points: 0,
            tasks: Vec::new(),
            open: FxHashMap::default(),
            begun: 0,
        };
        if let Some(pieces) = pieces.filter(|pieces| pieces.all.len() > FEW_OPERANDS) {
            let groups = pieces.groups.iter().zip(0..);
            let open = |(own, group): (&OpenGroup, u32)| {
                let scale = own.scale;
                (own.node, Open { group, scale })
            };
            lowering.open = groups.map(open).collect();
            let root = GroupSpan {
                parent: ROOT,
                operator: Operator::default(),
                open: Instr::default(),
                close: Instr::default(),
            };
            lowering.program.groups = vec![root; pieces.groups.len()];
        }
        lowering.measure(&parents_first);
        lowering
    }

    /// Which operands take part, and what of the stack each node needs, from the leaves up.
    fn measure(&mut self, parents_first: &[NodeId]) {
        for &id in parents_first.iter().rev() {
            let node = self.scene.node(id);
            let mut need = 0;
            if matches!(node.acting().body, Body::Group) {
                // What stands first has nothing to act on unless it adds.
                let mut operands: Vec<NodeId> = Vec::new();
                let mut prefix: Vec<u32> = Vec::new();
                for &child in node.children() {
                    let entry = self.scene.node(child).acting();
                    let acts = !operands.is_empty() || entry.operator.kind == OperatorKind::Union;
                    if !entry.visible || !acts {
                        continue;
                    }
                    let own = self.slots[child];
                    need = match operands.is_empty() {
                        true => own,
                        false if is_single(entry) => need,
                        false if self.open.contains_key(&id) => need.max(1 + own),
                        // The needier goes first; the other then has one slot less.
                        false => need.max(own).max(1 + need.min(own)),
                    };
                    operands.push(child);
                    prefix.push(need);
                }
                self.operands.insert(id, operands);
                self.prefix_slots.insert(id, prefix);
            }
            self.slots[id] = need
                + node
                    .acting()
                    .modifiers
                    .iter()
                    .filter(|m| is_loop(m))
                    .count() as u32;
        }
        if let Some(&root) = parents_first.first() {
            self.program.value_slots = self.slots[root] as usize;
        }
    }

    fn emit_all(&mut self) -> Result<(), LowerError> {
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

    fn emit(&mut self, instr: Instr) {
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
    fn with(&mut self, op: u32, words: &[f32]) -> Instr {
        let params = self.program.params.len() as u32;
        self.program.params.extend_from_slice(words);
        Instr {
            op,
            params,
            ..Instr::default()
        }
    }

    fn list(&mut self, group: NodeId, count: usize, frame: Frame) {
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

    fn combine(&mut self, entry: &Entry, frame: Frame, swapped: bool) -> Instr {
        let (flags, words) = combine_words(entry, frame, swapped);
        Instr {
            flags,
            ..self.with(abi::OP_COMBINE, &words)
        }
    }

    fn set_regularity(&mut self, own: Regularity) {
        let program = &mut self.program;
        program.lipschitz = own.lipschitz;
        program.slack = own.slack;
        program.hidden_slack = own.hidden;
        program.isolation = own.isolation;
        program.underestimate = own.underestimate;
    }

    /// What is said of a piece, if it is visible.
    fn told(&mut self, groups: &Pieces, piece: Piece) -> Option<Told> {
        let entry = self.scene.node(piece.node).acting();
        let scale = groups.groups[piece.group as usize].scale;
        entry.visible.then(|| Told {
            group: piece.group,
            operator: scaled(&entry.operator, scale),
            regularity: self.regular[piece.node].scaled(scale),
            extent: extent_in_world(self.scene, &mut self.extents, piece.node),
        })
    }

    /// What holds of the whole scene, from what holds of its pieces.
    fn measure_pieces(&mut self, pieces: &Pieces) {
        let mut greatest = 0.0f32;
        for piece in &pieces.all {
            if self.scene.node(piece.node).acting().visible {
                let scale = pieces.groups[piece.group as usize].scale;
                greatest = greatest.max(magnitude(&self.extents.outer(piece.node), scale));
            }
        }
        self.program.magnitude = greatest;
        let parent_of = |group: u32| pieces.groups[group as usize].parent;
        let operator_of = |group: u32| pieces.groups[group as usize].operator;
        let told = pieces
            .all
            .iter()
            .filter_map(|&piece| self.told(pieces, piece));
        let all = regularity_of(told, parent_of, operator_of);
        self.set_regularity(all);
        if all.slack + all.hidden > 0.0 {
            let last_first = pieces.all.iter().rev();
            let told = last_first.filter_map(|&piece| self.told(pieces, piece));
            self.program.loose = loose_of(told, parent_of, operator_of, all);
        }
    }

    /// A node's frame from that of its group.
    fn enter(&self, node: NodeId, frame: Frame) -> Frame {
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

    fn brush(&mut self, node: NodeId, frame: Frame) -> Result<(), LowerError> {
        let entry = self.scene.node(node).acting();
        let mut frame = self.enter(node, frame);
        for modifier in entry.modifiers.iter().rev() {
            map(self.scene, node, modifier, &mut frame)?;
        }
        let joint = joint(&entry.operator, frame.scale / scale_of(entry));
        self.shape(node, frame, joint)
    }

    /// The instruction of a brush's shape.
    fn shape(&mut self, node: NodeId, frame: Frame, joint: [f32; 5]) -> Result<(), LowerError> {
        let entry = self.scene.node(node).acting();
        let Body::Shape(shape) = &entry.body else {
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
        let flags = keep(entry)
            | if is_translation {
                abi::FLAG_TRANSLATION
            } else {
                0
            };
        let instr = Instr {
            flags,
            operand: frame.material,
            ..self.with(op, &words)
        };
        self.emit(instr);
        self.program.brushes += 1;
        Ok(())
    }

    fn solid(&mut self, node: NodeId, frame: Frame) -> Result<(), LowerError> {
        let entry = self.scene.node(node).acting();
        let mut frame = self.enter(node, frame);
        let stages = self.extents.stages(node);
        // The modifiers from the outermost in: what opens now, and what closes after the content, innermost first.
        let mut closing: Vec<Task> = Vec::new();
        for (modifier, content) in entry.modifiers.iter().zip(&stages).rev() {
            if modifier.affine().is_some() {
                map(self.scene, node, modifier, &mut frame)?;
                continue;
            }
            let looked_at = copies_looked_at(modifier, content);
            let content = content.aabb;
            match *modifier {
                Modifier::Round { radius } => {
                    let instr =
                        self.with(abi::OP_ROUND, &[(f64::from(radius) * frame.scale) as f32]);
                    closing.push(Task::Emit(instr));
                    continue;
                }
                Modifier::Shell { thickness } => {
                    let instr = self.with(
                        abi::OP_SHELL,
                        &[(f64::from(thickness) * frame.scale) as f32],
                    );
                    closing.push(Task::Emit(instr));
                    continue;
                }
                _ => {}
            }

            // One copy is no repetition.
            if matches!(modifier, Modifier::Repeat { .. }) && !is_loop(modifier) {
                continue;
            }

            // Everything else works on the point in the node's own frame: save the outer one.
            self.emit(Instr {
                op: abi::OP_PUSH_POINT,
                ..Instr::default()
            });
            closing.push(Task::Emit(Instr {
                op: abi::OP_POP_POINT,
                ..Instr::default()
            }));
            if frame.own_from_point != DAffine3::IDENTITY {
                let instr = self.with(abi::OP_AFFINE, &affine_words(&frame.own_from_point));
                self.emit(instr);
                frame.own_from_point = DAffine3::IDENTITY;
            }
            match *modifier {
                Modifier::Mirror { axes } => {
                    let instr =
                        self.with(abi::OP_MIRROR, &axes.map(|on| if on { 1.0 } else { 0.0 }));
                    self.emit(instr);
                }
                Modifier::Elongate { by } => {
                    let instr = self.with(abi::OP_ELONGATE, &by);
                    self.emit(instr);
                }
                Modifier::Repeat { spacing, count } => {
                    let (words, copies) = repeat_words(spacing, count, looked_at);
                    self.open_loop(
                        node,
                        abi::OP_REPEAT,
                        &words,
                        copies,
                        &mut frame,
                        &mut closing,
                    )?;
                }
                Modifier::RadialRepeat { count } => {
                    let step = TAU / count as f32;
                    let copies = looked_at[0];
                    let words = [count as f32, step, copies as f32];
                    self.open_loop(
                        node,
                        abi::OP_RADIAL,
                        &words,
                        u64::from(copies),
                        &mut frame,
                        &mut closing,
                    )?;
                }
                Modifier::Twist { degrees_per_unit } | Modifier::Bend { degrees_per_unit } => {
                    let is_twist = matches!(modifier, Modifier::Twist { .. });
                    let (op, what) = if is_twist {
                        (abi::OP_TWIST, "twist")
                    } else {
                        (abi::OP_BEND, "bend")
                    };
                    if content.is_empty() {
                        continue;
                    }
                    let held = modifier.clamp_box(content).filter(|b| b.is_finite());
                    let Some(held) = held else {
                        return Err(LowerError::Endless {
                            path: self.scene.path(node),
                            what,
                        });
                    };
                    let mut words = [held.min.to_array(), held.max.to_array()].concat();
                    // The gap to the box is measured in the node's own unit, distances in the world's.
                    words.extend([degrees_per_unit.to_radians(), frame.scale as f32]);
                    let instr = self.with(op, &words);
                    self.emit(instr);
                    frame.scale /= f64::from(modifier.stretch(content));
                    closing.push(Task::Emit(self.with(abi::OP_UNCLAMP, &words)));
                }
                Modifier::Displace {
                    amplitude,
                    frequency,
                    seed,
                    octaves,
                } => {
                    frame.scale /= f64::from(modifier.stretch(content));
                    for octave in (0..octaves).rev() {
                        let part = 0.5f64.powi(octave as i32);
                        let amplitude = (f64::from(amplitude) * part * frame.scale) as f32;
                        let words = [amplitude, (f64::from(frequency) / part) as f32];
                        let operand = seed.wrapping_add(octave);
                        closing.push(Task::Emit(Instr {
                            operand,
                            ..self.with(abi::OP_DISPLACE, &words)
                        }));
                    }
                }
                _ => {}
            }
        }
        self.tasks.extend(closing);
        if matches!(entry.body, Body::Shape(_)) {
            // Onto an empty accumulator, by a hard union.
            self.shape(node, frame, joint(&Operator::default(), 1.0))?;
        } else {
            let count = self.operands[&node].len();
            self.tasks.push(Task::List {
                group: node,
                count,
                frame,
            });
        }
        Ok(())
    }

    fn open_loop(
        &mut self,
        node: NodeId,
        op: u32,
        words: &[f32],
        copies: u64,
        frame: &mut Frame,
        closing: &mut Vec<Task>,
    ) -> Result<(), LowerError> {
        frame.copies = frame.copies.saturating_mul(copies);
        if copies > MAX_COPIES_A_LOOP && op == abi::OP_REPEAT || frame.copies > MAX_COPIES {
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
                    MAX_COPIES_A_LOOP
                },
            });
        }
        let words = [words, &[frame.jump.unwrap_or(0.0)]].concat();
        let instr = self.with(op, &words);
        closing.push(Task::Next {
            begin: self.program.instrs.len(),
        });
        self.emit(instr);
        Ok(())
    }
}
