//! Light that only some images have: lamps, fog, and bent normals.

use super::frame_fog::passed;
use super::lamp_rays::LampRays;
use super::lamp_shadows::LampShadows;
use super::light_source::LightSource;
use super::{bent, haze, lamp_light};
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{FrameUniform, GpuMaterial};
use glam::{Vec3, Vec4, vec3};

/// What it adds to the samples of a tile. Empty where an image has none.
#[derive(Debug, Default)]
pub(crate) struct MoreLight {
    /// What surfaces reflect of lamps.
    lamps: Vec<Vec3>,
    /// The lamps in front of surfaces and of the sky.
    seen: Vec<Vec3>,
    sky_seen: Vec<Vec3>,
    /// Light from fog in front of surfaces and of the sky, and the share of light that passes it.
    fog: Vec<Vec4>,
    sky_fog: Vec<Vec4>,
    /// The share of the sun's light that reaches surfaces through fog.
    sunny: Vec<f32>,
    bent: [Vec<f32>; 3],
    rays: LampRays,
    shadows: LampShadows,
}

impl MoreLight {
    /// Gathers what a frame has. It replaces the visible shares of the sky, if it has bent normals.
    pub(super) fn gather(
        &mut self,
        frame: &FrameUniform,
        (surfaces, sky_samples): (&Surfaces, &Surfaces),
        materials: &[GpuMaterial],
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
        sky: &mut [f32],
    ) {
        let Self {
            lamps,
            seen,
            sky_seen,
            fog,
            sky_fog,
            sunny,
            bent,
            rays,
            shadows,
        } = self;
        sunny.clear();
        lamps.clear();
        seen.clear();
        sky_seen.clear();
        fog.clear();
        sky_fog.clear();
        bent.iter_mut().for_each(Vec::clear);
        if frame.lamp_count > 0 {
            lamp_light::gather(frame, (surfaces, materials), source, points, shadows, lamps);
            lamp_light::look(frame, surfaces, seen);
            lamp_light::look(frame, sky_samples, sky_seen);
        }
        if frame.fog_density > 0.0 {
            haze::gather(frame, surfaces, source, points, rays, fog);
            haze::gather(frame, sky_samples, source, points, rays, sky_fog);
            let sun = frame.sun.into();
            let clear = |i| passed(frame, surfaces.point(i), sun, frame.far);
            sunny.extend((0..surfaces.len()).map(clear));
        }
        if frame.has_bent_normals != 0 {
            bent::gather(frame, surfaces, source, points, (sky, bent));
        }
    }

    /// Takes away what fog takes of the sun's light.
    pub(super) fn dim_sun(&self, first: usize, sun: &mut [f32]) {
        let passed = self.sunny.iter().skip(first);
        for (sun, passed) in sun.iter_mut().zip(passed) {
            *sun *= passed;
        }
    }

    /// Returns the bent normals, if there are any.
    pub(super) fn bent_normals(&self) -> Option<&[Vec<f32>; 3]> {
        (!self.bent[0].is_empty()).then_some(&self.bent)
    }

    /// Adds to the colors of `n` surfaces. The horizon hides shares of the ground.
    pub(super) fn add_to<const N: usize>(
        &self,
        first: usize,
        n: usize,
        hidden: &[f32; N],
        colors: &mut [[f32; N]; 3],
    ) {
        if let Some(lamps) = self.lamps.get(first..first + n) {
            for (i, lamp_light) in lamps.iter().enumerate() {
                let lamp_light = *lamp_light * (1.0 - hidden[i]);
                for (lanes, channel) in colors.iter_mut().zip(lamp_light.to_array()) {
                    lanes[i] += channel;
                }
            }
        }
        mix_fog(&self.fog, first, n, colors);
        add(&self.seen, first, n, colors);
    }

    /// Adds to the colors of `n` samples that show the sky.
    pub(super) fn add_to_sky<const N: usize>(
        &self,
        first: usize,
        n: usize,
        colors: &mut [[f32; N]; 3],
    ) {
        mix_fog(&self.sky_fog, first, n, colors);
        add(&self.sky_seen, first, n, colors);
    }
}

fn add<const N: usize>(light: &[Vec3], first: usize, n: usize, colors: &mut [[f32; N]; 3]) {
    for (i, color) in light.iter().skip(first).take(n).enumerate() {
        for (lanes, channel) in colors.iter_mut().zip(color.to_array()) {
            lanes[i] += channel;
        }
    }
}

fn mix_fog<const N: usize>(fog: &[Vec4], first: usize, n: usize, colors: &mut [[f32; N]; 3]) {
    let Some(fog) = fog.get(first..first + n) else {
        return;
    };
    for (i, fog_light) in fog.iter().enumerate() {
        let behind = vec3(colors[0][i], colors[1][i], colors[2][i]);
        let color = behind * fog_light.w + fog_light.truncate();
        (colors[0][i], colors[1][i], colors[2][i]) = color.into();
    }
}
