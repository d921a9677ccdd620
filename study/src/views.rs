//! Cameras and settings of images.

use crate::configuration::Configuration;
use crate::plan::Plan;
use crate::task::{CLOSE_SAMPLES, Look, StudyCamera};
use argil::World;
use argil::render::{Camera, RenderMode, RenderSettings};
use argil::scene::CameraPose;

/// Returns a camera of the study.
pub(crate) fn camera(world: &World, eye: StudyCamera) -> Camera {
    match eye {
        StudyCamera::Outside => world.camera(),
        StudyCamera::Inside => world.camera_at(CameraPose::Orbit([25.0, 10.0, 0.3])),
        StudyCamera::Grazing => world.camera_at(CameraPose::Orbit([70.0, 3.0, 0.9])),
    }
}

/// Returns the settings of an image.
pub(crate) fn settings(
    world: &World,
    plan: &Plan,
    (way, look): (&Configuration, &Look),
) -> RenderSettings {
    let defaults = world.render_settings(plan.size(), look.show);
    let voxel = world.volume_info().ok().flatten();
    let voxel = voxel.map(|info| info.voxel_grid.voxel_size);
    RenderSettings {
        samples: if look.is_close { CLOSE_SAMPLES } else { 1 },
        ground: look.is_close && defaults.ground,
        normals: look.normals,
        lookup_start: way.descent(),
        statistics: true,
        normal_bias: look.bias_voxels.zip(voxel).map(|(n, voxel)| n * voxel),
        // The study's limit, which its colors represent.
        max_steps: if look.show == RenderMode::Heat {
            256
        } else {
            defaults.max_steps
        },
        heat_steps: Some(256),
        ..defaults
    }
}

/// Returns the settings of the field's image, which is the truth.
pub(crate) fn exact_settings(field: &World, plan: &Plan, look: &Look) -> RenderSettings {
    let defaults = field.render_settings(plan.size(), look.show);
    let plain = RenderSettings {
        samples: 1,
        ground: false,
        ..defaults
    };
    if !look.is_close {
        return plain;
    }
    RenderSettings {
        samples: CLOSE_SAMPLES,
        ground: defaults.ground,
        epsilon: Some(1e-5),
        normal_bias: Some(2e-4),
        ..plain
    }
}
