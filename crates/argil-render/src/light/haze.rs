//! Light in fog. `haze.wgsl` is the twin.
//!
//! *Theory.* Along each primary ray, light is gathered at some places, each of which represents as much of the light that fog
//! scatters toward the viewer. The places follow from the fog's density, and the sun and all lamps shine there as far as nothing is
//! in their way: so they make shafts. Light that is scattered twice is left out.
//!
//! *Practice.* Places differ from pixel to pixel (Jimenez, "Next generation post processing in Call of Duty: Advanced Warfare",
//! 2014), so that steps become noise.

use super::frame_fog::{fog_of, passed};
use super::lamp_rays::LampRays;
use super::lamps::{LampLight, lamp_at};
use super::light_source::LightSource;
use crate::path::fog;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{self as abi, FrameUniform};
use argil_scene::Fog;
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_PI_2;

/// Of the sky's shadow: the reciprocal of the tangent of half its angle.
const SKY_SHARPNESS: f32 = 1.0;
/// The length of rays that meet nothing.
const ENDLESS: f32 = 1e6;

/// Returns a number from 0 to 1 that differs between neighboring pixels and samples.
pub(super) fn noise([x, y]: [f32; 2]) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let noise_of_pixel = 52.982_918 * (0.067_110_56 * column + 0.005_837_15 * row).fract();
    (noise_of_pixel.fract() + (x - column) + 0.37 * (y - row)).fract()
}

/// Returns the sky's light at a place in fog: the mean over all directions, as far as the way up is free.
fn sky_light(frame: &FrameUniform) -> LampLight {
    let [zenith, horizon, nadir] = [frame.zenith, frame.horizon, frame.nadir].map(Vec3::from);
    LampLight {
        direction: Vec3::Y,
        distance: f32::MAX,
        light: zenith * 0.328_05 + horizon * 0.234_45 + nadir * (7.0 / 16.0),
        sharpness: SKY_SHARPNESS,
    }
}

/// Returns the share of the sky's light that comes through the fog above a point. Light that is scattered again and again is lost
/// more slowly than light from one direction (diffusion: Ishimaru, "Wave propagation and scattering in random media", 1978).
fn sky_passed(medium: &Fog, p: Vec3, far: f32) -> Vec3 {
    let depth = fog::depth(medium, p, Vec3::Y, far);
    Vec3::from(medium.albedo).map(|albedo| {
        let rate = (3.0 * (1.0 - albedo) * (1.0 - albedo * medium.anisotropy)).max(0.0);
        (-rate.sqrt() * depth).exp()
    })
}

fn sun_light(frame: &FrameUniform) -> LampLight {
    LampLight {
        direction: frame.sun.into(),
        distance: f32::MAX,
        light: Vec3::from(frame.sun_light) * FRAC_PI_2,
        sharpness: abi::SHADOW_SHARPNESS,
    }
}

/// Computes the light that fog scatters toward the viewer in front of samples, and the share of light that passes it.
pub(super) fn gather(
    frame: &FrameUniform,
    samples: &Surfaces,
    source: &mut LightSource<'_, '_>,
    points: &mut Points,
    rays: &mut LampRays,
    out: &mut Vec<Vec4>,
) {
    let medium = fog_of(frame);
    let eye = Vec3::from(frame.eye);
    out.clear();
    let reach = |i: usize| {
        let is_sky = samples.kind[i] == abi::HIT_NONE;
        if is_sky { ENDLESS } else { samples.length[i] }
    };
    let depths: Vec<f32> = (0..samples.len())
        .map(|i| fog::depth(&medium, eye, samples.ray(i), reach(i)))
        .collect();
    out.extend(
        depths
            .iter()
            .map(|depth| Vec4::new(0.0, 0.0, 0.0, (-depth).exp())),
    );
    let lamps = frame.lamps.chunks(4).take(frame.lamp_count as usize);
    let min_step = source.min_step(frame);
    let mut lengths = Vec::with_capacity(samples.len());
    for index in 0..abi::FOG_PLACES {
        let place = |i: usize| {
            let share = (index as f32 + noise(samples.image_place(i))) / abi::FOG_PLACES as f32;
            let depth = -(1.0 - share * (1.0 - out_share(depths[i]))).ln();
            let length = fog::length_of(&medium, eye, samples.ray(i), depth);
            length.map_or(reach(i), |length| length.min(reach(i)))
        };
        lengths.clear();
        lengths.extend((0..samples.len()).map(place));
        let at = |i: usize| eye + lengths[i] * samples.ray(i);
        let mut add = |lamp_of: &dyn Fn(Vec3) -> LampLight, is_sky: bool| {
            rays.clear();
            for (i, &length) in lengths.iter().enumerate() {
                let lamp = lamp_of(at(i));
                if lamp.light.max_element() > 0.0 {
                    rays.push(frame, at(i), &lamp, min_step.at(length));
                } else {
                    rays.skip();
                }
            }
            rays.march(frame, source, points);
            for (i, &share) in rays.shares.iter().enumerate() {
                let lamp = lamp_of(at(i));
                let factor = if is_sky {
                    sky_passed(&medium, at(i), frame.far)
                } else {
                    let phase = fog::phase(medium.anisotropy, samples.ray(i).dot(lamp.direction));
                    Vec3::splat(phase * passed(frame, at(i), lamp.direction, lamp.distance))
                };
                out[i] += (lamp.light * factor * share).extend(0.0);
            }
        };
        add(&|_| sun_light(frame), false);
        add(&|_| sky_light(frame), true);
        for rows in lamps.clone() {
            add(&|p| lamp_at(rows, p), false);
        }
    }
    for color in out.iter_mut() {
        let light = color.truncate() / abi::FOG_PLACES as f32;
        let scattered = light * Vec3::from(frame.fog_albedo) * (1.0 - color.w);
        *color = scattered.extend(color.w);
    }
}

fn out_share(depth: f32) -> f32 {
    (-depth).exp()
}
