//! Stills by path tracing, on the CPU.
//!
//! *Practice.* Passes of one path per pixel follow each other until all were made, the time is over, or somebody cancels. What
//! is there then is the picture: pixels that a last pass did not reach have one path less.

mod albedo;
mod bsdf;
mod denoise;
mod integrator;
mod lights;
mod microfacets;
mod sampler;
mod sky;
mod still;

pub use denoise::denoised;
pub use integrator::{PathHit, PathScene};
pub use lights::PathLights;
pub use still::Still;

use crate::camera::through;
use crate::light::reflect::tone_mapped;
use crate::srgb::SRGB;
use crate::tile::tiles;
use argil_abi::FrameUniform;
use argil_math::Control;
use glam::Vec3;
use integrator::Integrator;
use rayon::prelude::*;
use sampler::Sampler;
use std::time::Duration;
use still::Pixel;
use web_time::Instant;

/// How a still is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StillOptions {
    /// Paths per pixel, from 1 to 1,048,576.
    pub samples: u32,
    /// Surfaces that a path passes at most, from 1 to 1,024.
    pub max_bounces: u32,
    /// The most light that a path may bring after its first surface. It removes bright dots, and light with them.
    pub firefly_clamp: Option<f32>,
    /// The time after which no pass begins. The first one is made in any case.
    pub time_limit: Option<Duration>,
}

impl Default for StillOptions {
    fn default() -> Self {
        Self {
            samples: 64,
            max_bounces: 32,
            firefly_clamp: None,
            time_limit: None,
        }
    }
}

/// Converts light to 8-bit sRGB as the other integrator does, three bytes a pixel.
pub fn developed(radiance: &[[f32; 3]]) -> Vec<u8> {
    let toned: Vec<[f32; 4]> = radiance
        .iter()
        .map(|light| {
            let [r, g, b] = light.map(tone_mapped);
            [r, g, b, 0.0]
        })
        .collect();
    let mut rgb = vec![0; 3 * radiance.len()];
    SRGB.show(&toned, &mut rgb);
    rgb
}

/// Makes a still, on rayon's current threads. The frame has the camera, the size and the ground. Canceled work returns what is
/// there. `passed` is called after each pass.
pub fn trace_paths(
    scene: &dyn PathScene,
    lights: &PathLights,
    frame: &FrameUniform,
    options: &StillOptions,
    control: &Control,
) -> Still {
    let start = Instant::now();
    let size = [frame.width, frame.height];
    let all: Vec<_> = tiles(size[0], size[1]).collect();
    let mut own: Vec<Vec<Pixel>> = all
        .iter()
        .map(|tile| vec![Pixel::default(); tile.area()])
        .collect();
    let integrator = Integrator {
        frame,
        scene,
        lights,
        max_bounces: options.max_bounces,
        clamp: options.firefly_clamp.unwrap_or(f32::INFINITY),
    };
    let eye = Vec3::from(frame.eye);
    control.begin("paths", u64::from(options.samples) * all.len() as u64);
    for pass in 0..options.samples {
        let is_late = options
            .time_limit
            .is_some_and(|limit| start.elapsed() >= limit);
        if pass > 0 && is_late {
            break;
        }
        own.par_iter_mut().zip(&all).for_each(|(pixels, tile)| {
            if control.is_cancelled() {
                return;
            }
            for (nth, pixel) in (0u32..).zip(pixels) {
                let (x, y) = (
                    tile.first_x + nth % tile.width,
                    tile.first_row + nth / tile.width,
                );
                let mut sampler = Sampler::new(y * size[0] + x, pass);
                let [u, v] = sampler.pair();
                let direction = through(frame, x as f32 + u, y as f32 + v);
                pixel.add(&integrator.path(eye, direction, &mut sampler));
            }
            control.advance(1);
        });
        if control.is_cancelled() {
            break;
        }
    }
    let mut pixels = vec![Pixel::default(); size[0] as usize * size[1] as usize];
    for (tile, own) in all.iter().zip(own) {
        for (row, own) in own.chunks(tile.width as usize).enumerate() {
            let begin = (tile.first_row as usize + row) * size[0] as usize + tile.first_x as usize;
            pixels[begin..begin + own.len()].copy_from_slice(own);
        }
    }
    Still { size, pixels }
}
