//! Stills by path tracing, on the CPU.
//!
//! *Practice.* Passes of one path per pixel follow each other until all were made, the time is over, or somebody cancels. What
//! is there then is the picture: pixels that a last pass did not reach have one path less.

mod albedo;
mod bsdf;
mod denoise;
mod develop;
mod emitters;
mod environment;
mod fog;
mod glass;
mod integrator;
mod lights;
mod material;
mod microfacets;
mod sampler;
mod sky;
mod still;

pub use denoise::denoised;
pub use develop::{Development, developed};
pub use integrator::{PathHit, PathScene};
pub use lights::{EnvironmentNotLoaded, PathLights};
pub use material::PathMaterial;
pub use still::Still;

use crate::camera::through;
use crate::tile::{Tile, tiles};
use argil_abi::FrameUniform;
use argil_math::Control;
use argil_scene::Fog;
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
    /// Whether what is behind everything is left out: see [`Still::opacity`].
    pub is_transparent: bool,
}

impl Default for StillOptions {
    fn default() -> Self {
        Self {
            samples: 64,
            max_bounces: 32,
            firefly_clamp: None,
            time_limit: None,
            is_transparent: false,
        }
    }
}

/// The lens of a camera whose picture is sharp at one distance (thin lens: Cook, Porter and Carpenter, "Distributed ray
/// tracing", 1984).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLens {
    /// Radius of the opening.
    pub radius: f32,
    /// Distance of what is sharp, along the view's axis.
    pub focus: f32,
}

/// What paths find besides surfaces.
#[derive(Clone, Debug)]
pub struct PathView {
    /// The lights, and what is behind everything.
    pub lights: PathLights,
    /// Fog around all surfaces.
    pub fog: Option<Fog>,
    /// The camera's lens. Without one, all is sharp.
    pub lens: Option<PathLens>,
}

impl PathView {
    /// Creates a view with lights, and nothing else.
    pub fn new(lights: PathLights) -> Self {
        Self {
            lights,
            fog: None,
            lens: None,
        }
    }

    /// Returns where the ray of a place in the image begins, and its direction. `random` is a point of the unit square.
    fn ray(&self, frame: &FrameUniform, [x, y]: [f32; 2], [u, v]: [f32; 2]) -> (Vec3, Vec3) {
        let eye = Vec3::from(frame.eye);
        let direction = through(frame, x, y);
        let Some(lens) = self.lens.filter(|lens| lens.radius > 0.0) else {
            return (eye, direction);
        };
        let [right, up, forward] = [frame.right, frame.up, frame.forward].map(Vec3::from);
        let sharp = eye + direction * (lens.focus / direction.dot(forward).max(1e-4));
        let (radius, turn) = (lens.radius * u.sqrt(), std::f32::consts::TAU * v);
        let beside = right.normalize_or_zero() * turn.cos() + up.normalize_or_zero() * turn.sin();
        let origin = eye + radius * beside;
        (origin, (sharp - origin).normalize())
    }
}

/// Makes a still, on rayon's current threads. The frame has the camera, the size and the ground. Canceled work returns what is
/// there.
pub fn trace_paths(
    scene: &dyn PathScene,
    view: &PathView,
    frame: &FrameUniform,
    options: &StillOptions,
    control: &Control,
) -> Still {
    let mut still = Still::new([frame.width, frame.height]);
    continue_paths(scene, view, frame, options, control, &mut still);
    still
}

/// Adds paths to a still of the same frame: see [`trace_paths`]. As many as one call would have made, made by several, are the same
/// paths.
///
/// # Panics
/// If the still has another size than the frame.
pub fn continue_paths(
    scene: &dyn PathScene,
    view: &PathView,
    frame: &FrameUniform,
    options: &StillOptions,
    control: &Control,
    still: &mut Still,
) {
    let start = Instant::now();
    let size = [frame.width, frame.height];
    assert_eq!(still.size, size, "a still of this frame");
    let first = still.samples();
    let all: Vec<_> = tiles(size[0], size[1]).collect();
    let row_of = |tile: &Tile, row: usize| {
        let begin = (tile.first_row as usize + row) * size[0] as usize + tile.first_x as usize;
        begin..begin + tile.width as usize
    };
    let mut own: Vec<Vec<Pixel>> = all
        .iter()
        .map(|tile| {
            let rows = 0..tile.area() / tile.width as usize;
            let rows = rows.map(|row| &still.pixels[row_of(tile, row)]);
            rows.flatten().copied().collect()
        })
        .collect();
    let integrator = Integrator {
        frame,
        scene,
        lights: &view.lights,
        fog: view.fog.filter(|fog| fog.density > 0.0),
        is_transparent: options.is_transparent,
        max_bounces: options.max_bounces,
        clamp: options.firefly_clamp.unwrap_or(f32::INFINITY),
    };
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
                let mut sampler = Sampler::new(y * size[0] + x, first + pass);
                let [u, v] = sampler.pair();
                let on_lens = sampler.pair();
                let (origin, direction) = view.ray(frame, [x as f32 + u, y as f32 + v], on_lens);
                pixel.add(&integrator.path(origin, direction, &mut sampler));
            }
            control.advance(1);
        });
        if control.is_cancelled() {
            break;
        }
    }
    for (tile, own) in all.iter().zip(own) {
        for (row, own) in own.chunks(tile.width as usize).enumerate() {
            still.pixels[row_of(tile, row)].copy_from_slice(own);
        }
    }
}
