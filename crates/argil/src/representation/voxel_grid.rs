//! Chooses the voxel grid of a scene's volume.

use crate::BuildError;
use argil_field::Program;
use argil_math::Aabb;
use argil_scene::Scene;
use argil_volume::{MAX_SPARSE_RESOLUTION, VoxelGrid};
use glam::Vec3;

/// Returns the voxel grid of a scene, from a resolution or a voxel size.
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

/// Number of times at which an animated scene's box is measured.
const PROBE_COUNT: u16 = 16;

/// Returns the box of the solid. For an animated scene, it is the union of boxes at equally spaced times.
pub(crate) fn sampled_box(scene: &Scene, program: &Program) -> Aabb {
    let Some(duration) = scene.duration() else {
        return program.aabb();
    };
    let mut moved = scene.clone();
    let boxes = (0..=PROBE_COUNT).filter_map(|look| {
        moved.set_time(duration * f32::from(look) / f32::from(PROBE_COUNT));
        // A scene that cannot be lowered at that time is reported when it is rendered.
        Program::lower(&moved).ok().map(|program| program.aabb())
    });
    boxes.fold(program.aabb(), |all, own| all.union(own))
}

/// Returns the bounds of the scene's view.
fn frame_of(scene: &Scene) -> Option<Aabb> {
    let frame = scene.view.bounds;
    frame.map(|[min, max]| Aabb::new(min.into(), max.into()))
}

/// Returns a grid with the same voxels over the scene's current box.
pub(crate) fn recomputed_grid(
    lattice: &VoxelGrid,
    scene: &Scene,
    program: &Program,
) -> Result<VoxelGrid, BuildError> {
    let found = lattice.covering_on(sampled_box(scene, program), frame_of(scene));
    Ok(found.map_err(argil_volume::BricksError::from)?)
}

/// Returns a grid with the same voxels that contains an edited scene: the old one, if it does.
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

/// Returns the view's bounds, or the solid's box if it is finite, or its finite part.
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
