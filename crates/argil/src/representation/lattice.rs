//! Where the voxels of a scene's volume lie.

use crate::{BuildError, Scene};
use argil_field::Program;
use argil_math::Aabb;
use argil_volume::{Lattice, MOST_SPARSE};
use glam::Vec3;

/// The lattice of a scene's volume: of so many voxels, or of sparse ones of a size.
pub(crate) fn lattice_of(
    scene: &Scene,
    program: &Program,
    resolution: u32,
    voxel: Option<f32>,
) -> Result<Lattice, BuildError> {
    let frame = frame_of(scene);
    let solid = reach(scene, program);
    Ok(match voxel {
        Some(voxel) => Lattice::of_voxels(solid, frame, voxel, MOST_SPARSE)?,
        None => Lattice::holding(solid, frame, resolution)?,
    })
}

/// Times at which it is looked how far an animated scene reaches.
const LOOKS: u16 = 16;

/// The box of the solid; of a scene that moves, of what it is at times of equal distance.
pub(crate) fn reach(scene: &Scene, program: &Program) -> Aabb {
    let Some(duration) = scene.duration() else {
        return program.aabb();
    };
    let mut moved = scene.clone();
    let boxes = (0..=LOOKS).filter_map(|look| {
        moved.set_time(duration * f32::from(look) / f32::from(LOOKS));
        // What cannot be lowered then is told when it is to be drawn.
        Program::lower(&moved).ok().map(|program| program.aabb())
    });
    boxes.fold(program.aabb(), |all, own| all.union(own))
}

/// The frame that a scene is looked at in.
fn frame_of(scene: &Scene) -> Option<Aabb> {
    let frame = scene.view.frame;
    frame.map(|[min, max]| Aabb::new(min.into(), max.into()))
}

/// The same voxels over a box that holds a scene, found anew.
pub(crate) fn found_again(
    lattice: &Lattice,
    scene: &Scene,
    program: &Program,
) -> Result<Lattice, BuildError> {
    let found = lattice.over_again(reach(scene, program), frame_of(scene));
    Ok(found.map_err(argil_volume::BricksError::from)?)
}

/// The same voxels over a box that holds a scene that was edited: the old one if that does.
pub(crate) fn following(
    lattice: &Lattice,
    scene: &Scene,
    program: &Program,
) -> Result<Lattice, BuildError> {
    let solid = reach(scene, program);
    if lattice.is_cut == (!solid.is_finite() && !solid.is_empty()) {
        let grown = lattice.grown_to(solid, 1);
        return Ok(grown.map_err(argil_volume::BricksError::from)?);
    }
    found_again(lattice, scene, program)
}

/// The view's frame, else the solid's box where it is finite, else what is finite of it.
pub(crate) fn focus(scene: &Scene, program: &Program) -> Aabb {
    if let Some([min, max]) = scene.view.frame {
        return Aabb::new(min.into(), max.into());
    }
    let reach = reach(scene, program);
    if reach.is_finite() {
        reach
    } else {
        Aabb::centered(Vec3::ONE)
    }
}
