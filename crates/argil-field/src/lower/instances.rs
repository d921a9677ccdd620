//! Lowers instances.
//!
//! *Practice.* A brush of few words is lowered once for each pose: one instruction, and its parameters. Other content
//! is lowered once for each scale, after a map from the instance's frame. The other instances of that scale copy its
//! instructions, which refer to the same parameters, and have a map of their own. Neighbors form clusters, and clusters
//! form larger ones. A sphere bounds each of them, so that a batch of points, or a [`Pruner`](crate::Pruner), skips what
//! is farther than the nearest solid.

use super::error::{LowerError, MAX_INSTRUCTIONS};
use super::frame::{Frame, joint, map};
use super::lowering::{Lowering, LoweringTask};
use super::params::affine_words;
use crate::params::pack;
use argil_abi::{self as abi, Instruction};
use argil_math::Aabb;
use argil_scene::{Extent, NodeId, NodeKind, Operator, Pose, Shape};
use glam::{DAffine3, Vec3};
use std::ops::Range;

fn plain(op: u32) -> Instruction {
    Instruction {
        op,
        ..Instruction::default()
    }
}

impl Lowering<'_> {
    /// Emits a brush at each pose, with its first `count` modifiers. Returns `false` if it is not a brush of few words.
    pub(super) fn emit_brush_instances(
        &mut self,
        node: NodeId,
        count: usize,
        poses: &[Pose],
        (content, frame): (&Extent, Frame),
    ) -> Result<bool, LowerError> {
        let entry = self.scene.node(node).at_current_time();
        let inner = &entry.modifiers[..count];
        let NodeKind::Shape(shape) = &entry.kind else {
            return Ok(false);
        };
        if inner.iter().any(|modifier| modifier.affine().is_none()) || !has_few_words(shape) {
            return Ok(false);
        }
        let mut sorted = poses.to_vec();
        sorted.sort_by_cached_key(along_curve);
        let combine = self.hard_union();
        let joint = joint(&Operator::default(), 1.0);
        self.emit_clusters(&sorted, (content, frame), combine, |lowering, pose, _| {
            let mut frame = frame.at(pose);
            lowering.check_scale(node, frame)?;
            for modifier in inner.iter().rev() {
                map(lowering.scene, node, modifier, &mut frame)?;
            }
            lowering.shape(node, frame, joint)
        })?;
        Ok(true)
    }

    /// Pushes the tasks for the instances of a node with its first `count` modifiers.
    pub(super) fn push_instances(
        &mut self,
        node: NodeId,
        count: usize,
        poses: &[Pose],
        (content, frame): (&Extent, Frame),
    ) {
        let mut sorted = poses.to_vec();
        sorted.sort_by(|a, b| a.scale.total_cmp(&b.scale));
        self.tasks.push(LoweringTask::Instances {
            node,
            count,
            sorted,
            begin: 0,
            content: *content,
            frame,
        });
    }

    /// Pushes the tasks for the instances of one scale, and a task for the rest. The instances are sorted by scale, and
    /// those before `begin` are done.
    pub(super) fn push_instances_of_a_scale(
        &mut self,
        (node, count): (NodeId, usize),
        (sorted, begin): (Vec<Pose>, usize),
        (content, frame): (Extent, Frame),
    ) {
        let rest = &sorted[begin..];
        let Some(&pose) = rest.first() else { return };
        let end = begin + rest.partition_point(|other| other.scale <= pose.scale);
        let others = sorted[begin + 1..end].to_vec();
        if end < sorted.len() {
            self.tasks.push(LoweringTask::Instances {
                node,
                count,
                sorted,
                begin: end,
                content,
                frame,
            });
        }
        let inner = Frame {
            own_from_point: DAffine3::IDENTITY,
            scale: frame.scale * f64::from(pose.scale),
            ..frame
        };
        self.tasks.extend([
            LoweringTask::EndInstances {
                node,
                others,
                content,
                frame,
                is_first: begin == 0,
            },
            LoweringTask::Stages {
                node,
                count,
                frame: inner,
            },
            LoweringTask::BeginInstances {
                node,
                pose,
                content,
                frame,
                is_first: begin == 0,
            },
        ]);
    }

    pub(super) fn begin_instances(
        &mut self,
        node: NodeId,
        pose: Pose,
        (content, frame): (&Extent, Frame),
        is_first: bool,
    ) -> Result<(), LowerError> {
        self.check_scale(node, frame.at(pose))?;
        if !is_first {
            self.open_group(sphere(pose, content, frame));
        }
        self.emit(plain(abi::OP_PUSH_POINT));
        let map = self.map_of(pose, frame);
        let begin = self.program.instructions.len();
        self.instances.push((begin, self.program.brushes));
        self.emit(map);
        Ok(())
    }

    pub(super) fn end_instances(
        &mut self,
        node: NodeId,
        mut others: Vec<Pose>,
        content: &Extent,
        frame: Frame,
        is_first: bool,
    ) -> Result<(), LowerError> {
        let Some((begin, brushes)) = self.instances.pop() else {
            return Ok(());
        };
        let end = self.program.instructions.len();
        let of_each = end - begin + 4;
        let needed = end as u64 + of_each as u64 * others.len() as u64;
        if needed > MAX_INSTRUCTIONS {
            return Err(LowerError::TooManyInstances {
                path: self.scene.path(node),
                needed,
                limit: MAX_INSTRUCTIONS,
            });
        }
        self.emit(plain(abi::OP_POP_POINT));
        let combine = self.hard_union();
        if !is_first {
            self.emit(combine);
        }
        let brushes = self.program.brushes - brushes;
        self.program.brushes += brushes * others.len();
        self.program.instructions.reserve(of_each * others.len());
        others.sort_by_cached_key(along_curve);
        let bounds = (content, frame);
        self.emit_clusters(&others, bounds, combine, |lowering, pose, is_alone| {
            if !is_alone {
                lowering.open_group(sphere(pose, content, frame));
            }
            lowering.copy(begin..end, pose, frame);
            if !is_alone {
                lowering.emit(combine);
            }
            Ok(())
        })
    }

    /// Emits instances in clusters, which are united with what is before them. `emit` is told whether an instance is the
    /// first of its cluster, which begins with nothing.
    fn emit_clusters(
        &mut self,
        sorted: &[Pose],
        (content, frame): (&Extent, Frame),
        combine: Instruction,
        mut emit: impl FnMut(&mut Self, Pose, bool) -> Result<(), LowerError>,
    ) -> Result<(), LowerError> {
        let bound = |poses: &[Pose]| {
            let bounds = poses.iter().map(|&pose| sphere(pose, content, frame));
            around(&bounds.collect::<Option<Vec<_>>>()?)
        };
        let is_nested = sorted.len() > LARGE_CLUSTER;
        for large in sorted.chunks(LARGE_CLUSTER) {
            if is_nested {
                self.open_group(bound(large));
            }
            for cluster in large.chunks(CLUSTER) {
                self.open_group(bound(cluster));
                for (index, &pose) in cluster.iter().enumerate() {
                    emit(self, pose, index == 0)?;
                }
                self.emit(combine);
            }
            if is_nested {
                self.emit(combine);
            }
        }
        Ok(())
    }

    /// Returns the instruction that unites a saved value with the current one.
    fn hard_union(&mut self) -> Instruction {
        let [k, quarter, a, b, r] = joint(&Operator::default(), 1.0);
        Instruction {
            flags: abi::COMBINE_SMOOTH,
            ..self.with(abi::OP_COMBINE, &[k, quarter, a, b, r, 0.0])
        }
    }

    fn check_scale(&self, node: NodeId, frame: Frame) -> Result<(), LowerError> {
        let scale = frame.scale;
        if (1e-6..=1e6).contains(&scale) {
            return Ok(());
        }
        let path = self.scene.path(node);
        Err(LowerError::Scale { path, scale })
    }

    /// Begins a union with what is before it. A [`Pruner`](crate::Pruner) and the interpreter skip it by its bound.
    fn open_group(&mut self, bound: Option<[f32; 5]>) {
        let instr = match bound {
            Some(words) => Instruction {
                flags: abi::FLAG_BOUNDED,
                ..self.with(abi::OP_PUSH_VALUE, &words)
            },
            None => plain(abi::OP_PUSH_VALUE),
        };
        self.emit(instr);
    }

    /// Emits an instance, given the range of the first one: its map, and what follows.
    fn copy(&mut self, first: Range<usize>, pose: Pose, frame: Frame) {
        self.emit(plain(abi::OP_PUSH_POINT));
        let moved = (self.program.instructions.len() - first.start) as u32;
        let map = self.map_of(pose, frame);
        self.emit(map);
        for index in first.start + 1..first.end {
            let mut instr = self.program.instructions[index];
            if instr.op == abi::OP_NEXT {
                instr.operand += moved;
            }
            self.emit(instr);
        }
        self.emit(plain(abi::OP_POP_POINT));
    }

    fn map_of(&mut self, pose: Pose, frame: Frame) -> Instruction {
        let map = frame.at(pose).own_from_point;
        self.with_map(abi::OP_AFFINE, &map, &affine_words(&map))
    }
}

impl Frame {
    /// Returns the frame of an instance.
    fn at(self, pose: Pose) -> Self {
        Self {
            own_from_point: pose.own_from_outer() * self.own_from_point,
            scale: self.scale * f64::from(pose.scale),
            ..self
        }
    }
}

/// Instances in a cluster, and in a cluster of clusters. Each is skipped as a whole where it is far.
const CLUSTER: usize = 16;
pub(super) const LARGE_CLUSTER: usize = CLUSTER * CLUSTER;
/// Maximum words of a shape that instances repeat. A map and a bound for each instance take more.
const FEW_WORDS: usize = 16;

/// Whether a shape is so small that instances repeat its words.
fn has_few_words(shape: &Shape) -> bool {
    let mut words = Vec::new();
    shape.file().is_none() && {
        pack(shape, &mut words);
        words.len() <= FEW_WORDS
    }
}

/// Returns a position along the Morton curve, in steps of 1/64 of a unit, within 16,384 units of the origin.
fn along_curve(pose: &Pose) -> u64 {
    let place = pose
        .position
        .map(|c| (c.clamp(-16_384.0, 16_383.0) * 64.0) as i32 + (1 << 20));
    (0..21).fold(0, |code, bit| {
        let bits = place.map(|c| u64::from(c as u32 >> bit & 1));
        code | (bits[0] | bits[1] << 1 | bits[2] << 2) << (3 * bit)
    })
}

/// Returns a bound of an instance: a sphere in the interpreter's frame, and the factor from the distance to it to the
/// scene's distance. Returns `None` if the solid is infinite, or the frame does not keep angles.
fn sphere(pose: Pose, content: &Extent, frame: Frame) -> Option<[f32; 5]> {
    let own_from_point = pose.own_from_outer() * frame.own_from_point;
    let point_from_own = own_from_point.inverse();
    let axes = point_from_own.matrix3;
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length());
    let is_similar = (x - y).abs().max((x - z).abs()) < 1e-6 * x;
    if !content.aabb.is_finite() || content.aabb.is_empty() || !is_similar {
        return None;
    }
    let center = point_from_own.transform_point3(content.aabb.center().as_dvec3());
    let radius = f64::from(content.aabb.half_diagonal()) * x;
    // Distances are measured with rounding.
    let rounding = 1e-6 * (center.abs().max_element() + radius);
    let factor = frame.scale * f64::from(pose.scale) / (x * f64::from(content.lipschitz_inverse));
    let [cx, cy, cz] = center.as_vec3().to_array();
    Some([
        cx,
        cy,
        cz,
        (radius + rounding) as f32,
        (0.9999 * factor) as f32,
    ])
}

/// Returns a bound of several.
fn around(bounds: &[[f32; 5]]) -> Option<[f32; 5]> {
    let centers = || bounds.iter().map(|&[x, y, z, ..]| Vec3::new(x, y, z));
    let middle = Aabb::around(centers()).center();
    let radius = centers()
        .zip(bounds)
        .map(|(center, sphere)| center.distance(middle) + sphere[3])
        .fold(0.0, f32::max);
    let factor = bounds
        .iter()
        .map(|sphere| sphere[4])
        .fold(f32::INFINITY, f32::min);
    (!bounds.is_empty()).then(|| {
        let rounding = 1e-6 * (middle.abs().max_element() + radius);
        [middle.x, middle.y, middle.z, radius + rounding, factor]
    })
}
