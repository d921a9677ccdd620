//! Suns.
//!
//! *Theory.* A sun is small: a path looks for it (next-event estimation), and where both ways find it, they share it by their
//! densities (multiple importance sampling, Veach 1997). The sky is so smooth that a surface's own directions find it.

use glam::Vec3;
use std::f32::consts::TAU;

/// A disc in the sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    direction: Vec3,
    /// What a surface receives that faces it.
    irradiance: Vec3,
    /// Solid angle, and the cosine of the angle between its middle and its rim.
    angle: f32,
    rim: f32,
}

impl Sun {
    /// Creates a sun with an angle in degrees between its sides.
    pub(super) fn new(direction: Vec3, irradiance: Vec3, angle_degrees: f32) -> Self {
        let half = (0.5 * angle_degrees.max(0.01)).to_radians();
        // 1 − cos, without losing digits.
        let cap = 2.0 * (0.5 * half).sin().powi(2);
        Self {
            direction,
            irradiance,
            angle: TAU * cap,
            rim: 1.0 - cap,
        }
    }

    /// Returns what a surface receives that faces it.
    pub(super) fn irradiance(&self) -> Vec3 {
        self.irradiance
    }

    /// Returns its rows for shaders.
    pub(super) fn rows(&self) -> [[f32; 4]; 4] {
        let kind = argil_abi::LIGHT_SUN as f32;
        [
            self.direction.extend(kind).to_array(),
            self.irradiance.extend(self.angle).to_array(),
            [self.rim, 0.0, 0.0, 0.0],
            [0.0; 4],
        ]
    }

    /// Returns what is seen in a direction.
    pub(super) fn seen(&self, direction: Vec3) -> Vec3 {
        if direction.dot(self.direction) < self.rim {
            return Vec3::ZERO;
        }
        self.irradiance / self.angle
    }

    /// Returns a direction to a point of it, what comes from there, and the density.
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> (Vec3, Vec3, f32) {
        let cap = u * (1.0 - self.rim);
        let (side, turn) = ((cap * (2.0 - cap)).max(0.0).sqrt(), TAU * v);
        let (x, y) = self.direction.any_orthonormal_pair();
        let direction =
            side * turn.cos() * x + side * turn.sin() * y + (1.0 - cap) * self.direction;
        (
            direction.normalize(),
            self.irradiance / self.angle,
            1.0 / self.angle,
        )
    }

    /// Returns the density with which a direction is chosen.
    pub(super) fn density(&self, direction: Vec3) -> f32 {
        let is_in = direction.dot(self.direction) >= self.rim;
        if is_in { 1.0 / self.angle } else { 0.0 }
    }
}
