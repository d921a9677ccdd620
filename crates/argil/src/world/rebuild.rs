//! Builds a world's representation again, with voxels of the same size.

use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device};
use crate::representation::updated_grid;
use crate::{BuildError, BuildTimings, Engine, RebuildReason, Representation};
use argil_field::Program;
use argil_scene::Scene;
use argil_volume::VoxelGrid;
use web_time::Instant;

/// A representation that was built again.
pub(super) struct Rebuilt {
    pub program: Program,
    pub timings: BuildTimings,
    pub reason: RebuildReason,
    /// How long lowering and building took, in milliseconds.
    pub duration_ms: f64,
}

/// Builds a representation of a scene on a device. Its voxels are those of a grid before, which grows if it has to.
///
/// # Errors
/// If the scene cannot be compiled, or the result exceeds the memory budget.
pub(super) async fn rebuild(
    device: &mut AnyDevice,
    (engine, scene): (&Engine, &Scene),
    (representation, before): (Representation, Option<VoxelGrid>),
    mut reason: RebuildReason,
) -> Result<Rebuilt, BuildError> {
    let start = Instant::now();
    let program = Program::lower(scene)?;
    device.set_program(&program)?;
    let voxel_grid = match before {
        Some(old) => {
            let new = updated_grid(&old, scene, &program)?;
            if new != old && reason == RebuildReason::NotEditable {
                reason = RebuildReason::OutsideBox;
            }
            Some(new)
        }
        None => None,
    };
    let site = BuildContext {
        engine,
        scene,
        program: &program,
    };
    let timings = representation.build(device, &site, voxel_grid).await?;
    Ok(Rebuilt {
        program,
        timings,
        reason,
        duration_ms: start.elapsed().as_secs_f64() * 1e3,
    })
}
