//! The lights of a picture.

use super::sky::Sun;
use crate::light::reflect::sky;
use argil_abi::FrameUniform;
use glam::Vec3;

/// What is behind everything.
#[derive(Clone, Debug)]
pub(super) enum Background {
    /// The sky of the other integrator.
    Sky,
    /// The same light from everywhere.
    Even(Vec3),
}

/// Lights, prepared for paths.
#[derive(Clone, Debug)]
pub struct PathLights {
    background: Background,
    suns: Vec<Sun>,
}

/// A point of a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSample {
    pub direction: Vec3,
    pub light: Vec3,
    pub density: f32,
}

impl PathLights {
    /// The sky and the sun of the other integrator.
    pub fn of_frame(frame: &FrameUniform) -> Self {
        let irradiance = Vec3::from(argil_abi::SUN_LIGHT) * std::f32::consts::FRAC_PI_2;
        Self {
            background: Background::Sky,
            suns: vec![Sun::new(frame.sun.into(), irradiance, SUN_DEGREES)],
        }
    }

    /// The same light from everywhere.
    pub fn even(radiance: [f32; 3]) -> Self {
        Self {
            background: Background::Even(radiance.into()),
            suns: Vec::new(),
        }
    }

    /// Returns what is behind everything, without the suns.
    pub(super) fn background(&self, frame: &FrameUniform, direction: Vec3) -> Vec3 {
        match self.background {
            Background::Sky => sky(frame, direction),
            Background::Even(radiance) => radiance,
        }
    }

    /// Returns what a ray finds that meets nothing. `share` gives that of a density with which lights are sampled.
    pub(super) fn sky(
        &self,
        frame: &FrameUniform,
        direction: Vec3,
        share: impl Fn(f32) -> f32,
    ) -> Vec3 {
        let chance = 1.0 / self.suns.len().max(1) as f32;
        let suns = self.suns.iter().map(|sun| {
            let density = chance * sun.density(direction);
            if density > 0.0 {
                sun.seen(direction) * share(density)
            } else {
                Vec3::ZERO
            }
        });
        self.background(frame, direction) + suns.sum::<Vec3>()
    }

    /// Chooses a light and a point of it.
    pub(super) fn sample(&self, which: f32, point: [f32; 2]) -> Option<LightSample> {
        let count = self.suns.len();
        let sun = self.suns.get((which * count as f32) as usize)?;
        let (direction, light, density) = sun.sample(point);
        Some(LightSample {
            direction,
            light,
            density: density / count as f32,
        })
    }
}

/// The sun's angle, as seen from the earth.
const SUN_DEGREES: f32 = 0.53;
