//! What surfaces send toward the viewer. `shade.wgsl` is the twin.
//!
//! *Theory.* There is one sun and a sky. Direct light is a GGX lobe over a body (Walter et al. 2007, with Schlick's
//! Fresnel and Smith's visibility), which gets what facets let through (`lobes.rs`). The tone curve is Narkowicz's fit of ACES
//! (2015).
//!
//! *Practice.* Some surfaces at a time are copied into arrays of fixed length, for which the compiler makes vectors.

#![expect(
    clippy::needless_range_loop,
    reason = "a lane has its place in many arrays"
)]

use super::Light;
use super::lobes::{high, low, mix, reflected_from, schlick};
use crate::surfaces::Surfaces;
use crate::tones::{agx, tone_mapped};
use argil_abi::{self as abi, FrameUniform};
use glam::{Vec3, vec3};
use multiversion::multiversion;

/// Light that what is below reflects, as a share of the light from below.
const BOUNCE: Vec3 = vec3(0.363_636, 0.311_111, 0.255_319);
/// Surfaces that are computed together.
const LANES: usize = 32;

/// One surface's properties.
#[derive(Clone, Copy)]
struct Lane {
    normal: Vec3,
    /// Where the sky's light comes from, on average.
    open: Vec3,
    view: Vec3,
    base: Vec3,
    roughness: f32,
    emission: Vec3,
    metallic: f32,
    sun: f32,
    sky: f32,
    /// How much of it the horizon covers.
    haze: f32,
}

/// Properties of some surfaces, as a structure of arrays.
struct Lanes {
    normal: [[f32; LANES]; 3],
    open: [[f32; LANES]; 3],
    view: [[f32; LANES]; 3],
    material: [[f32; LANES]; 8],
    sun: [f32; LANES],
    sky: [f32; LANES],
    haze: [f32; LANES],
}

impl Lanes {
    const ZERO: Self = Self {
        normal: [[0.0; LANES]; 3],
        open: [[0.0; LANES]; 3],
        view: [[0.0; LANES]; 3],
        material: [[0.0; LANES]; 8],
        sun: [0.0; LANES],
        sky: [0.0; LANES],
        haze: [0.0; LANES],
    };
}

/// Adds the colors of surfaces and of the sky to their pixels: linear, after the tone curve.
pub(crate) fn add_colors(frame: &FrameUniform, light: &Light, out: &mut [[f32; 4]]) {
    let mut colors = [[0.0; LANES]; 3];
    let surfaces = &light.surfaces;
    let mut lanes = Lanes::ZERO;
    for first in (0..surfaces.len()).step_by(LANES) {
        let n = LANES.min(surfaces.len() - first);
        lanes.load(frame, light, first, n);
        reflected(frame, &lanes, &mut colors);
        light.more.add_to(first, n, &lanes.haze, &mut colors);
        toned(frame, &mut colors);
        for i in 0..n {
            let kind = surfaces.kind[first + i];
            let covered = if kind == abi::HIT_GROUND { 0.0 } else { 1.0 };
            let color = [colors[0][i], colors[1][i], colors[2][i], covered];
            add(frame, color, &mut out[surfaces.pixel[first + i] as usize]);
        }
    }
    let missed = &light.sky_samples;
    for first in (0..missed.len()).step_by(LANES) {
        let n = LANES.min(missed.len() - first);
        copy(&missed.direction, first, n, &mut lanes.view);
        skies(frame, &lanes, &mut colors);
        light.more.add_to_sky(first, n, &mut colors);
        toned(frame, &mut colors);
        for i in 0..n {
            let color = [colors[0][i], colors[1][i], colors[2][i], 0.0];
            add(frame, color, &mut out[missed.pixel[first + i] as usize]);
        }
    }
}

#[inline]
fn add(frame: &FrameUniform, color: [f32; 4], out: &mut [f32; 4]) {
    for (out, channel) in out.iter_mut().zip(color) {
        *out += channel * frame.sample_weight;
    }
}

fn copy<const N: usize>(from: &[Vec<f32>; N], first: usize, n: usize, to: &mut [[f32; LANES]; N]) {
    for (to, from) in to.iter_mut().zip(from) {
        to[..n].copy_from_slice(&from[first..first + n]);
    }
}

impl Lanes {
    fn load(&mut self, frame: &FrameUniform, light: &Light, first: usize, n: usize) {
        let Surfaces {
            normal,
            direction,
            kind,
            length,
            ..
        } = &light.surfaces;
        copy(normal, first, n, &mut self.normal);
        let open = light.more.bent_normals().unwrap_or(normal);
        copy(open, first, n, &mut self.open);
        copy(direction, first, n, &mut self.view);
        for (to, &share) in self.sun.iter_mut().zip(&light.sun[first..first + n]) {
            *to = share * share * (3.0 - 2.0 * share);
        }
        light.more.dim_sun(first, &mut self.sun[..n]);
        self.sky[..n].copy_from_slice(&light.sky[first..first + n]);
        for i in 0..n {
            let material = &light.materials[first + i];
            for k in 0..4 {
                self.material[k][i] = material.base_roughness[k];
                self.material[4 + k][i] = material.emission_metallic[k];
            }
            // The ground fades into the horizon.
            let far = length[first + i] / frame.far;
            let is_ground = kind[first + i] == abi::HIT_GROUND;
            self.haze[i] = if is_ground {
                (far * 2.2).clamp(0.0, 1.0)
            } else {
                0.0
            };
        }
    }

    #[inline(always)]
    fn lane(&self, i: usize) -> Lane {
        let of = |lanes: &[[f32; LANES]; 3]| vec3(lanes[0][i], lanes[1][i], lanes[2][i]);
        let m = |k: usize| self.material[k][i];
        Lane {
            normal: of(&self.normal),
            open: of(&self.open),
            view: of(&self.view),
            base: vec3(m(0), m(1), m(2)),
            roughness: m(3),
            emission: vec3(m(4), m(5), m(6)),
            metallic: m(7),
            sun: self.sun[i],
            sky: self.sky[i],
            haze: self.haze[i],
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn reflected(frame: &FrameUniform, lanes: &Lanes, out: &mut [[f32; LANES]; 3]) {
    for i in 0..LANES {
        let color = surface(frame, &lanes.lane(i));
        (out[0][i], out[1][i], out[2][i]) = (color.x, color.y, color.z);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn skies(frame: &FrameUniform, lanes: &Lanes, out: &mut [[f32; LANES]; 3]) {
    for i in 0..LANES {
        let direction = vec3(lanes.view[0][i], lanes.view[1][i], lanes.view[2][i]);
        let color = sky(frame, direction);
        (out[0][i], out[1][i], out[2][i]) = (color.x, color.y, color.z);
    }
}

/// Applies the exposure and the tone curve.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn toned(frame: &FrameUniform, colors: &mut [[f32; LANES]; 3]) {
    let exposure = frame.exposure;
    match frame.tone {
        abi::TONE_ACES => {
            for lanes in colors {
                lanes
                    .iter_mut()
                    .for_each(|c| *c = tone_mapped(*c * exposure));
            }
        }
        abi::TONE_AGX => {
            let [r, g, b] = colors;
            for ((r, g), b) in r.iter_mut().zip(g).zip(b) {
                (*r, *g, *b) = agx(exposure * vec3(*r, *g, *b)).into();
            }
        }
        _ => {
            for lanes in colors {
                lanes
                    .iter_mut()
                    .for_each(|c| *c = low(high(*c * exposure, 0.0), 1.0));
            }
        }
    }
}

/// Returns the light that a surface sends toward the viewer.
#[inline(always)]
fn surface(frame: &FrameUniform, lane: &Lane) -> Vec3 {
    let (n, direction, roughness) = (lane.normal, lane.view, lane.roughness);
    let (view, sun) = (-direction, Vec3::from_array(frame.sun));
    let facing = high(n.dot(view), 1e-3);
    let body = lane.base * (1.0 - lane.metallic);
    let mirror = mix(Vec3::splat(0.04), lane.base, lane.metallic);

    // The sun.
    let light = Vec3::from_array(frame.sun_light) * (lane.sun * std::f32::consts::FRAC_PI_2);
    let direct = reflected_from(n, view, sun, (body, mirror, roughness)) * light;

    // The sky: its mean over the normal's half space for the body, and along the reflection for the mirror.
    let [zenith, horizon, nadir] = [frame.zenith, frame.horizon, frame.nadir].map(Vec3::from_array);
    let around = mix(nadir, mix(zenith, horizon, 0.5), 0.5 + 0.5 * lane.open.y);
    let reflected = direction - n * (2.0 * direction.dot(n));
    let gloss = 1.0 - roughness;
    let environment = mix(around, sky(frame, reflected), gloss * gloss);
    let rim = schlick(mirror, facing, gloss);
    let ambient = (body * around * 0.9 + rim * environment) * lane.sky;

    // Light reflected from below.
    let bounce = body * (nadir * BOUNCE) * ((0.5 - 0.5 * lane.open.y) * lane.sky);
    let color = direct + ambient + bounce + lane.emission;
    mix(color, sky(frame, direction), lane.haze)
}

/// Up to this height, the sky leaves the color of the horizon gradually, so that the horizon is no line.
const LOW_SKY: f32 = 0.12;

/// Returns the share of the zenith's color at a height above the horizon, from 0 to 1.
#[inline(always)]
fn sky_share(up: f32) -> f32 {
    let rise = low(up * (1.0 / LOW_SKY), 1.0);
    up.sqrt() * (rise * rise * (3.0 - 2.0 * rise))
}

/// Returns the sky's light from a direction.
#[inline(always)]
pub(crate) fn sky(frame: &FrameUniform, direction: Vec3) -> Vec3 {
    let up = direction.y;
    let [zenith, horizon, nadir] = [frame.zenith, frame.horizon, frame.nadir].map(Vec3::from_array);
    let above = mix(horizon, zenith, sky_share(high(up, 0.0)));
    let below = mix(horizon, nadir, low(high(-up * 4.0, 0.0), 1.0));
    // With a ground, only haze is visible below the horizon.
    let below = if frame.has_ground != 0 {
        horizon
    } else {
        below
    };
    let base = select(up >= 0.0, above, below);
    let glow = high(direction.dot(Vec3::from_array(frame.sun)), 0.0);
    let glow2 = glow * glow;
    let glow8 = glow2 * glow2 * glow2 * glow2;
    base + vec3(0.25, 0.18, 0.08) * (frame.glow * (glow8 * glow8))
}

#[inline(always)]
fn select(which: bool, a: Vec3, b: Vec3) -> Vec3 {
    let choose = |a: f32, b: f32| if which { a } else { b };
    vec3(choose(a.x, b.x), choose(a.y, b.y), choose(a.z, b.z))
}
