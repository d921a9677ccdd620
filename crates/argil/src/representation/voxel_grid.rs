//! Chooses the voxel grid of a scene's volume.

use crate::BuildError;
use argil_field::Program;
use argil_math::Aabb;
use argil_scene::{Extents, Scene};
use argil_volume::{MAX_SPARSE_RESOLUTION, RESOLUTION_RANGE, VoxelGrid};

/// Returns the voxel grid of a scene, from a resolution or a voxel size.
pub(crate) fn voxel_grid_of(
    scene: &Scene,
    program: &Program,
    resolution: u32,
    voxel: Option<f32>,
    most: u32,
) -> Result<VoxelGrid, BuildError> {
    let solid = sampled_box(scene, program);
    let bounds = clip_box(scene, solid);
    Ok(match voxel {
        Some(voxel) => VoxelGrid::with_voxel_size(solid, bounds, voxel, MAX_SPARSE_RESOLUTION)?,
        None if most.min(resolution) > *RESOLUTION_RANGE.end() => {
            let widest = *RESOLUTION_RANGE.end();
            let coarse = VoxelGrid::fitting(solid, bounds, widest)?;
            let voxel = coarse.voxel_size * (widest as f32 / resolution as f32);
            VoxelGrid::with_voxel_size(solid, bounds, voxel, most)?
        }
        None => VoxelGrid::fitting(solid, bounds, resolution)?,
    })
}

/// Number of times at which an animated scene's box is measured.
const PROBE_COUNT: u16 = 16;

/// Returns the box of the solid. For an animated scene, it is the union of boxes at equally spaced times.
pub(crate) fn sampled_box(scene: &Scene, program: &Program) -> Aabb {
    // A scene that cannot be lowered at that time is reported when it is rendered.
    let at_time =
        |moved: &Scene| Program::lower(moved).map_or(Aabb::EMPTY, |lowered| lowered.aabb());
    program.aabb().union(union_over_time(scene, at_time))
}

/// Returns the union of a box of an animated scene at equally spaced times. Empty for other scenes.
fn union_over_time(scene: &Scene, at_time: impl Fn(&Scene) -> Aabb) -> Aabb {
    let Some(duration) = scene.duration() else {
        return Aabb::EMPTY;
    };
    let mut moved = scene.clone();
    let boxes = (0..=PROBE_COUNT).map(|look| {
        moved.set_time(duration * f32::from(look) / f32::from(PROBE_COUNT));
        at_time(&moved)
    });
    boxes.fold(Aabb::EMPTY, Aabb::union)
}

/// Returns the bounds of the scene's view. An infinite solid without them gets a box around its finite part.
pub(crate) fn clip_box(scene: &Scene, solid: Aabb) -> Option<Aabb> {
    if let Some([min, max]) = scene.view.bounds {
        return Some(Aabb::new(min.into(), max.into()));
    }
    let is_infinite = !solid.is_finite() && !solid.is_empty();
    is_infinite.then(|| box_around_finite_part(scene))
}

/// The margin around the finite part of an infinite solid, in multiples of its longest side.
const FINITE_PART_MARGIN: f32 = 0.125;

/// Returns a box around the finite part of an infinite solid. Along an axis where no brush is finite, it contains
/// −1 to 1.
fn box_around_finite_part(scene: &Scene) -> Aabb {
    let part = finite_part_of(scene);
    let mut held = part;
    for axis in 0..3 {
        // One side alone, such as the height of a plane, tells no size.
        if held.min[axis] >= held.max[axis] {
            held.min[axis] = held.min[axis].min(-1.0);
            held.max[axis] = held.max[axis].max(1.0);
        }
    }
    let margin = FINITE_PART_MARGIN * held.size().max_element();
    for axis in 0..3 {
        // What reaches the border gets room around it.
        if part.min[axis] <= held.min[axis] {
            held.min[axis] -= margin;
        }
        if part.max[axis] >= held.max[axis] {
            held.max[axis] += margin;
        }
    }
    held
}

/// Whether the finite part of an infinite solid reaches outside the box that clips it.
pub(crate) fn has_outgrown(grid: &VoxelGrid, scene: &Scene) -> bool {
    let (held, part) = (grid.aabb(), finite_part_of(scene));
    // Along an axis where nothing is finite, both comparisons are false.
    part.min.cmplt(held.min).any() || part.max.cmpgt(held.max).any()
}

/// Returns a box around everything finite, at equally spaced times of an animated scene.
fn finite_part_of(scene: &Scene) -> Aabb {
    let part_of = |scene: &Scene| Extents::of(scene).finite_part(Scene::ROOT);
    part_of(scene).union(union_over_time(scene, part_of))
}

/// Returns a grid with the same voxels over the scene's current box. A box around an infinite solid's finite part
/// changes only if that part has outgrown it, and then also contains the old box.
fn recomputed_grid(
    grid: &VoxelGrid,
    scene: &Scene,
    program: &Program,
) -> Result<VoxelGrid, BuildError> {
    let solid = sampled_box(scene, program);
    let mut bounds = clip_box(scene, solid);
    let is_infinite = !solid.is_finite() && !solid.is_empty();
    if grid.is_clipped && is_infinite && scene.view.bounds.is_none() {
        if !has_outgrown(grid, scene) {
            return Ok(*grid);
        }
        bounds = bounds.map(|bounds| bounds.union(grid.aabb()));
    }
    let found = grid.recomputed(solid, bounds);
    Ok(found.map_err(argil_volume::BricksError::from)?)
}

/// Returns a grid with the same voxels that contains an edited scene: the old one, if it does.
pub(crate) fn updated_grid(
    grid: &VoxelGrid,
    scene: &Scene,
    program: &Program,
) -> Result<VoxelGrid, BuildError> {
    let solid = sampled_box(scene, program);
    let is_infinite = !solid.is_finite() && !solid.is_empty();
    if grid.is_clipped != is_infinite || (is_infinite && scene.view.bounds.is_none()) {
        return recomputed_grid(grid, scene, program);
    }
    let grown = grid.grown_to(solid, 1);
    Ok(grown.map_err(argil_volume::BricksError::from)?)
}
