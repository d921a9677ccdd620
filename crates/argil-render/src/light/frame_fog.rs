//! A frame's fog, and what it takes from light on its way.

use crate::path::fog;
use argil_abi::FrameUniform;
use argil_scene::Fog;
use glam::Vec3;

/// Returns a frame's fog.
pub(super) fn fog_of(frame: &FrameUniform) -> Fog {
    Fog {
        density: frame.fog_density,
        height: frame.fog_height,
        falloff: frame.fog_falloff,
        albedo: frame.fog_albedo,
        anisotropy: frame.fog_anisotropy,
    }
}

/// Returns the share of light from a direction that fog lets through to a point.
pub(super) fn passed(frame: &FrameUniform, p: Vec3, direction: Vec3, length: f32) -> f32 {
    if frame.fog_density <= 0.0 {
        return 1.0;
    }
    fog::transmitted(&fog_of(frame), p, direction, length.min(frame.far))
}
