//! The light of lamps that reaches the viewer: by surfaces, and without them.

use super::frame_fog::passed;
use super::lamp_shadows::LampShadows;
use super::lamps::{lamp_above, met};
use super::light_source::LightSource;
use super::lobes::{mix, reflected_from};
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{self as abi, FrameUniform, GpuMaterial};
use glam::Vec3;

/// Adds what surfaces reflect of all lamps.
pub(super) fn gather(
    frame: &FrameUniform,
    (surfaces, materials): (&Surfaces, &[GpuMaterial]),
    source: &mut LightSource<'_, '_>,
    points: &mut Points,
    shadows: &mut LampShadows,
    out: &mut Vec<Vec3>,
) {
    out.clear();
    out.resize(surfaces.len(), Vec3::ZERO);
    for rows in frame.lamps.chunks(4).take(frame.lamp_count as usize) {
        let shares = shadows.gather(frame, rows, surfaces, source, points);
        for (i, &share) in shares.iter().enumerate() {
            if share <= 0.0 {
                continue;
            }
            let (p, n) = (surfaces.point(i), surfaces.normal(i));
            let lamp = lamp_above(rows, p, n);
            let [r, g, b, roughness] = materials[i].base_roughness;
            let (base, metallic) = (Vec3::new(r, g, b), materials[i].emission_metallic[3]);
            let body = base * (1.0 - metallic);
            let mirror = mix(Vec3::splat(0.04), base, metallic);
            let view = -surfaces.ray(i);
            let reflected = reflected_from(n, view, lamp.direction, (body, mirror, roughness));
            let clear = passed(frame, p, lamp.direction, lamp.distance);
            out[i] += reflected * lamp.light * (share * clear);
        }
    }
}

/// Adds the lamps that samples show: spheres and rectangles in front of what a sample hits. Fog dims them.
pub(super) fn look(frame: &FrameUniform, samples: &Surfaces, out: &mut Vec<Vec3>) {
    out.clear();
    out.resize(samples.len(), Vec3::ZERO);
    let eye = Vec3::from(frame.eye);
    for rows in frame.lamps.chunks(4).take(frame.lamp_count as usize) {
        for (i, out) in out.iter_mut().enumerate() {
            let is_sky = samples.kind[i] == abi::HIT_NONE;
            let reach = if is_sky { f32::MAX } else { samples.length[i] };
            let direction = samples.ray(i);
            if let Some((length, radiance)) = met(rows, eye, direction)
                && length < reach
            {
                *out += radiance * passed(frame, eye, direction, length);
            }
        }
    }
}
