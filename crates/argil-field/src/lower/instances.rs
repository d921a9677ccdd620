//! Lowers instances.
//!
//! *Practice.* The content is lowered once for each scale, after a map from the instance's frame. The other instances
//! of that scale copy its instructions, which refer to the same parameters, and have a map of their own. So an
//! instance costs its instructions of 16 bytes and a map. A [`Pruner`](crate::Pruner) drops those that are far away
//! as a whole.

use super::error::{LowerError, MAX_INSTRUCTIONS};
use super::frame::{Frame, joint};
use super::lowering::{Lowering, LoweringTask};
use super::params::affine_words;
use argil_abi::{self as abi, Instruction};
use argil_scene::{NodeId, Operator, Pose};
use glam::DAffine3;

fn plain(op: u32) -> Instruction {
    Instruction {
        op,
        ..Instruction::default()
    }
}

impl Lowering<'_> {
    /// Pushes the tasks for the instances of a node with its first `count` modifiers.
    pub(super) fn push_instances(
        &mut self,
        node: NodeId,
        count: usize,
        poses: &[Pose],
        frame: Frame,
    ) {
        let mut sorted = poses.to_vec();
        sorted.sort_by(|a, b| a.scale.total_cmp(&b.scale));
        let same_scale: Vec<&[Pose]> = sorted.chunk_by(|a, b| a.scale == b.scale).collect();
        for (nth, poses) in same_scale.iter().enumerate().rev() {
            let inner = Frame {
                own_from_point: DAffine3::IDENTITY,
                scale: frame.scale * f64::from(poses[0].scale),
                ..frame
            };
            self.tasks.extend([
                LoweringTask::EndInstances {
                    node,
                    others: poses[1..].to_vec(),
                    frame,
                    is_first: nth == 0,
                },
                LoweringTask::Stages {
                    node,
                    count,
                    frame: inner,
                },
                LoweringTask::BeginInstances {
                    node,
                    pose: poses[0],
                    frame,
                    is_first: nth == 0,
                },
            ]);
        }
    }

    pub(super) fn begin_instances(
        &mut self,
        node: NodeId,
        pose: Pose,
        frame: Frame,
        is_first: bool,
    ) -> Result<(), LowerError> {
        let scale = frame.scale * f64::from(pose.scale);
        if !(1e-6..=1e6).contains(&scale) {
            return Err(LowerError::Scale {
                path: self.scene.path(node),
                scale,
            });
        }
        if !is_first {
            self.emit(plain(abi::OP_PUSH_VALUE));
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
        others: &[Pose],
        frame: Frame,
        is_first: bool,
    ) -> Result<(), LowerError> {
        let Some((begin, brushes)) = self.instances.pop() else {
            return Ok(());
        };
        let end = self.program.instructions.len();
        let own = end - begin + 4;
        let needed = end as u64 + own as u64 * others.len() as u64;
        if needed > MAX_INSTRUCTIONS {
            return Err(LowerError::TooManyInstances {
                path: self.scene.path(node),
                needed,
                limit: MAX_INSTRUCTIONS,
            });
        }
        self.emit(plain(abi::OP_POP_POINT));
        let [k, quarter, a, b, r] = joint(&Operator::default(), 1.0);
        let combine = Instruction {
            flags: abi::COMBINE_SMOOTH,
            ..self.with(abi::OP_COMBINE, &[k, quarter, a, b, r, 0.0])
        };
        if !is_first {
            self.emit(combine);
        }
        let brushes = self.program.brushes - brushes;
        self.program.brushes += brushes * others.len();
        self.program.instructions.reserve(own * others.len());
        for &pose in others {
            self.emit(plain(abi::OP_PUSH_VALUE));
            self.emit(plain(abi::OP_PUSH_POINT));
            let moved = (self.program.instructions.len() - begin) as u32;
            let map = self.map_of(pose, frame);
            self.emit(map);
            for nth in begin + 1..end {
                let mut instr = self.program.instructions[nth];
                if instr.op == abi::OP_NEXT {
                    instr.operand += moved;
                }
                self.emit(instr);
            }
            self.emit(plain(abi::OP_POP_POINT));
            self.emit(combine);
        }
        Ok(())
    }

    fn map_of(&mut self, pose: Pose, frame: Frame) -> Instruction {
        let map = pose.own_from_outer() * frame.own_from_point;
        self.with(abi::OP_AFFINE, &affine_words(&map))
    }
}
