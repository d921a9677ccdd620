//! What a still is made of besides surfaces, and how.

use super::lights::PathLights;
use crate::camera::through;
use argil_abi::FrameUniform;
use argil_scene::Fog;
use glam::Vec3;
use std::time::Duration;

/// How a still is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StillOptions {
    /// Paths per pixel, from 1 to 1,048,576.
    pub samples: u32,
    /// Surfaces that a path passes at most, from 1 to 1,024.
    pub max_bounces: u32,
    /// The most light that a path may bring after its first surface. It removes bright dots, and light with them.
    pub firefly_clamp: Option<f32>,
    /// The time after which no row of a tile begins, or no band on a GPU. On the CPU, one pixel of each 4 × 4 gets a path in any case (see
    /// [`Still::fill_gaps`](crate::Still::fill_gaps)), on the GPU each pixel.
    pub time_limit: Option<Duration>,
    /// Whether what is behind everything is left out: see [`Still::opacity`](crate::Still::opacity).
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
    pub(super) fn ray(
        &self,
        frame: &FrameUniform,
        [x, y]: [f32; 2],
        [u, v]: [f32; 2],
    ) -> (Vec3, Vec3) {
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
