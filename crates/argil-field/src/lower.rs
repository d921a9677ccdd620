//! Lowers a scene to a program.

mod error;
mod frame;
mod instances;
mod lowering;
mod measure;
mod params;
mod sections;
mod solid;

use crate::materials::MaterialTable;
use crate::pieces::{self, Pieces, is_open, magnitude};
use crate::program::Program;
use argil_scene::{NodeId, Scene};
pub use error::LowerError;
use frame::open_of;
pub(crate) use frame::{EnclosingGroup, Frame, extent_in_world};
use lowering::{Lowering, LoweringTask};
use params::is_single;

impl Program {
    /// Lowers a scene to a program. Time and memory are linear in the number of nodes.
    ///
    /// # Errors
    /// If the scene exceeds a limit, such as too many copies in a `Repeat`, or if nested scales leave the range of
    /// `f32`.
    pub fn lower(scene: &Scene) -> Result<Self, LowerError> {
        let pieces = Pieces::of(scene);
        let mut lowering = Lowering::of(scene, Scene::ROOT, Some(&pieces));
        lowering.measure_pieces(&pieces);
        lowering.program.materials = MaterialTable::of(scene)?;
        lowering.tasks.push(LoweringTask::Solid {
            node: Scene::ROOT,
            frame: Frame::OF_WORLD,
        });
        lowering.emit_all()?;
        lowering.program.is_hard_union = lowering.program.joints_are_hard_unions();
        Ok(lowering.program)
    }

    /// Checks that the piece that contains a node can be lowered, except for meshes that are not loaded. An open
    /// group is checked as a whole.
    ///
    /// # Errors
    /// If it exceeds a limit: see [`Program::lower`].
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
            frame = EnclosingGroup::of(scene, outer, frame)?.frame;
            scale *= pieces::scale_of(scene.node(outer).at_current_time());
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

    /// Lowers a node with its first `count` modifiers, in its own frame.
    pub(crate) fn lower_stages(
        scene: &Scene,
        node: NodeId,
        count: usize,
    ) -> Result<Self, LowerError> {
        let mut lowering = Lowering::of(scene, node, None);
        lowering.program.materials = MaterialTable::of(scene)?;
        let frame = Frame::OF_WORLD;
        lowering
            .tasks
            .push(LoweringTask::Stages { node, count, frame });
        lowering.emit_all()?;
        Ok(lowering.program)
    }

    /// Lowers a piece onto the current accumulator, as a program whose list can follow any other. `within` is the
    /// frame of its group, whose unit has length `scale` in the scene.
    pub(crate) fn lower_piece(
        scene: &Scene,
        node: NodeId,
        within: Frame,
        scale: f32,
    ) -> Result<Self, LowerError> {
        let mut lowering = Lowering::of(scene, node, None);
        let regularity = lowering.regular[node].scaled(scale);
        lowering.program.magnitude = magnitude(&lowering.extents.node_bounds(node), scale);
        lowering.set_regularity(regularity);
        let frame = Frame {
            jump: Some(regularity.slack + regularity.hidden),
            ..within
        };
        let entry = scene.node(node).at_current_time();
        if is_single(entry) {
            lowering.tasks.push(LoweringTask::Brush { node, frame });
        } else {
            lowering.program.value_slots += 1;
            let ramp = lowering.ramp_before_joint(entry, frame);
            let combine = lowering.combine(node, frame, false);
            lowering.emit(open_of(combine.flags));
            lowering.tasks.push(LoweringTask::Emit(combine));
            lowering.tasks.extend(ramp.map(LoweringTask::Emit));
            lowering.tasks.push(LoweringTask::Solid { node, frame });
        }
        lowering.emit_all()?;
        Ok(lowering.program)
    }
}
