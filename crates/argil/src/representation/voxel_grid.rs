//! Where the voxels of a scene's volume lie.

use crate::BuildError;
use argil_field::Program;
use argil_math::Aabb;
use argil_scene::Scene;
use argil_volume::{MAX_SPARSE_RESOLUTION, VoxelGrid};
use glam::Vec3;

/// The lattice of a scene's volume: of so many voxels, or of sparse ones of a size.
pub(crate) fn voxel_grid_of(
    scene: &Scene,
    program: &Program,
    resolution: u32,
    voxel: Option<f32>,
) -> Result<VoxelGrid, BuildError> {
    let frame = frame_of(scene);
    let solid = sampled_box(scene, program);
    Ok(match voxel {
        Some(voxel) => VoxelGrid::of_voxels(solid, frame, voxel, MAX_SPARSE_RESOLUTION)?,
        None => VoxelGrid::fitting(solid, frame, resolution)?,
    })
}

/// Times at which it is looked how far an animated scene reaches.
const PROBE_COUNT: u16 = 16;

/// The box of the solid; of a scene that moves, of what it is at times of equal distance.
pub(crate) fn sampled_box(scene: &Scene, program: &Program) -> Aabb {
    let Some(duration) = scene.duration() else {
        return program.aabb();
    };
    let mut moved = scene.clone();
    let boxes = (0..=PROBE_COUNT).filter_map(|look| {
        moved.set_time(duration * f32::from(look) / f32::from(PROBE_COUNT));
        // What cannot be lowered then is told when it is to be drawn.
        Program::lower(&moved).ok().map(|program| program.aabb())
    });
    boxes.fold(program.aabb(), |all, own| all.union(own))
}

/// The frame that a scene is looked at in.
fn frame_of(scene: &Scene) -> Option<Aabb> {
    let frame = scene.view.bounds;
    frame.map(|[min, max]| Aabb::new(min.into(), max.into()))
}

/// The same voxels over a box that holds a scene, found anew.
pub(crate) fn recomputed_grid(
    lattice: &VoxelGrid,
    scene: &Scene,
    program: &Program,
) -> Result<VoxelGrid, BuildError> {
    let found = lattice.covering_on(sampled_box(scene, program), frame_of(scene));
    Ok(found.map_err(argil_volume::BricksError::from)?)
}

/// The same voxels over a box that holds a scene that was edited: the old one if that does.
pub(crate) fn updated_grid(
    lattice: &VoxelGrid,
    scene: &Scene,
    program: &Program,
) -> Result<VoxelGrid, BuildError> {
    let solid = sampled_box(scene, program);
    if lattice.is_clipped == (!solid.is_finite() && !solid.is_empty()) {
        let grown = lattice.grown_to(solid, 1);
        return Ok(grown.map_err(argil_volume::BricksError::from)?);
    }
    recomputed_grid(lattice, scene, program)
}

/// The view's frame, else the solid's box where it is finite, else what is finite of it.
pub(crate) fn view_bounds_of(scene: &Scene, program: &Program) -> Aabb {
    if let Some([min, max]) = scene.view.bounds {
        return Aabb::new(min.into(), max.into());
    }
    let reach = sampled_box(scene, program);
    if reach.is_finite() {
        reach
    } else {
        Aabb::centered(Vec3::ONE)
    }
}
