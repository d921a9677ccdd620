//! Lights with a place: spheres and rectangles. They are seen, and hide nothing.
//!
//! *Theory.* A direction to a sphere is chosen evenly in the cone that it fills, and one to a rectangle by a point of it, whose
//! density per solid angle is d² / (area · cosine) (Shirley et al., "Monte Carlo techniques for direct lighting calculations",
//! 1996).

use argil_abi as abi;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// A point of a light, as seen from somewhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterPoint {
    pub direction: Vec3,
    pub distance: f32,
    pub radiance: Vec3,
    /// Per solid angle. Infinite for a point without size, whose radiance is then what arrives.
    pub density: f32,
}

/// Where a light shines, by the angle to an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    axis: Vec3,
    /// Cosines of the angles where light is gone, and where it begins to fade.
    side: f32,
    full: f32,
}

impl Cone {
    /// `fade` is the part of the cone over which light fades.
    pub(super) fn new(axis: Vec3, angle_degrees: f32, fade: f32) -> Self {
        let half = (0.5 * angle_degrees).to_radians();
        Self {
            axis,
            side: half.cos(),
            full: (half * (1.0 - fade)).cos(),
        }
    }

    fn share(&self, away: Vec3) -> f32 {
        let cosine = away.dot(self.axis);
        if cosine >= self.full {
            return 1.0;
        }
        let t = ((cosine - self.side) / (self.full - self.side).max(1e-6)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

/// A sphere that shines in all directions, or into a cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereLight {
    pub center: Vec3,
    pub radius: f32,
    /// Light per solid angle.
    pub intensity: Vec3,
    pub cone: Option<Cone>,
}

/// Spheres below this radius are points: they fill less of the view than numbers can tell.
const LEAST_RADIUS: f32 = 1e-5;

impl SphereLight {
    fn share(&self, away: Vec3) -> f32 {
        self.cone.map_or(1.0, |cone| cone.share(away))
    }

    /// Returns its rows for shaders.
    pub(super) fn rows(&self) -> [[f32; 4]; 4] {
        // All directions are in a cone whose light is full beyond −1.
        let cone = self.cone.unwrap_or(Cone {
            axis: Vec3::Y,
            side: -2.0,
            full: -2.0,
        });
        [
            self.center.extend(abi::LIGHT_SPHERE as f32).to_array(),
            self.intensity.extend(self.radius).to_array(),
            cone.axis.extend(cone.side).to_array(),
            [cone.full, 0.0, 0.0, 0.0],
        ]
    }

    /// Returns an estimate of the light at a point.
    pub(super) fn importance(&self, at: Vec3) -> f32 {
        let square = (self.center - at).length_squared();
        let near = square.max(self.radius * self.radius).max(1e-12);
        let away = (at - self.center).normalize_or_zero();
        // A sphere is seen beyond its axis' cone, too.
        let share = 0.05 + 0.95 * self.share(away);
        self.intensity.element_sum() * share / near
    }

    /// Returns one minus the cosine of the cone that the sphere fills, from outside.
    fn cap(&self, square: f32) -> Option<f32> {
        let sine2 = self.radius * self.radius / square;
        (sine2 < 1.0).then(|| sine2 / (1.0 + (1.0 - sine2).sqrt()))
    }

    /// Returns how bright each point of it is seen, in the direction away from it.
    fn radiance(&self, away: Vec3) -> Vec3 {
        self.intensity * (self.share(away) * FRAC_1_PI / (self.radius * self.radius))
    }

    /// Returns the distances where a ray enters and leaves.
    fn span(&self, origin: Vec3, direction: Vec3) -> Option<(f32, f32)> {
        let to = self.center - origin;
        let along = to.dot(direction);
        let beside = to - along * direction;
        let half2 = self.radius * self.radius - beside.length_squared();
        (half2 > 0.0).then(|| {
            let half = half2.sqrt();
            (along - half, along + half)
        })
    }

    pub(super) fn sample(&self, at: Vec3, [u, v]: [f32; 2]) -> Option<EmitterPoint> {
        let to = self.center - at;
        let square = to.length_squared();
        let axis = to.try_normalize()?;
        if self.radius < LEAST_RADIUS {
            return Some(EmitterPoint {
                direction: axis,
                distance: square.sqrt(),
                radiance: self.intensity * (self.share(-axis) / square),
                density: f32::INFINITY,
            });
        }
        // Nothing shines inward.
        let cap = self.cap(square)?;
        let below = u * cap;
        let (side, turn) = ((below * (2.0 - below)).max(0.0).sqrt(), TAU * v);
        let (x, y) = axis.any_orthonormal_pair();
        let direction = side * turn.cos() * x + side * turn.sin() * y + (1.0 - below) * axis;
        let direction = direction.normalize();
        let middle = to.dot(direction);
        let distance = self
            .span(at, direction)
            .map_or(middle, |(near, _)| near.max(0.0));
        Some(EmitterPoint {
            direction,
            distance,
            radiance: self.radiance(-direction),
            density: 1.0 / (TAU * cap),
        })
    }

    /// Returns where a ray meets the sphere from outside.
    pub(super) fn met(&self, origin: Vec3, direction: Vec3) -> Option<EmitterPoint> {
        if self.radius < LEAST_RADIUS {
            return None;
        }
        let cap = self.cap((self.center - origin).length_squared())?;
        let (distance, _) = self
            .span(origin, direction)
            .filter(|(near, _)| *near > 0.0)?;
        Some(EmitterPoint {
            direction,
            distance,
            radiance: self.radiance(-direction),
            density: 1.0 / (TAU * cap),
        })
    }
}

/// A rectangle that shines on one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct RectangleLight {
    pub center: Vec3,
    /// Unit vectors along its width and its height, and to the side on which it shines.
    pub axes: [Vec3; 3],
    pub half_size: [f32; 2],
    pub radiance: Vec3,
}

impl RectangleLight {
    /// Creates a rectangle that shines at a point. It stands upright, unless it shines straight up or down.
    pub(super) fn new(center: Vec3, target: Vec3, size: [f32; 2], radiance: Vec3) -> Self {
        let out = (target - center).try_normalize().unwrap_or(Vec3::NEG_Y);
        let width = Vec3::Y
            .cross(out)
            .try_normalize()
            .filter(|_| out.y.abs() < 0.999_999)
            .unwrap_or(Vec3::X);
        Self {
            center,
            axes: [width, out.cross(width), out],
            half_size: size.map(|side| 0.5 * side),
            radiance,
        }
    }

    /// Returns its rows for shaders.
    pub(super) fn rows(&self) -> [[f32; 4]; 4] {
        let [width, height, _] = self.axes;
        [
            self.center.extend(abi::LIGHT_RECTANGLE as f32).to_array(),
            self.radiance.extend(0.0).to_array(),
            width.extend(self.half_size[0]).to_array(),
            height.extend(self.half_size[1]).to_array(),
        ]
    }

    fn area(&self) -> f32 {
        4.0 * self.half_size[0] * self.half_size[1]
    }

    /// Returns an estimate of the light at a point.
    pub(super) fn importance(&self, at: Vec3) -> f32 {
        let to = at - self.center;
        let height = to.dot(self.axes[2]);
        if height <= 0.0 {
            return 0.0;
        }
        let square = to.length_squared().max(1e-12);
        let cosine = height / square.sqrt();
        // What fills the view cannot send more than π times its radiance.
        let angle = (self.area() * (0.1 + 0.9 * cosine) / square).min(PI);
        self.radiance.element_sum() * angle
    }

    fn density(&self, distance: f32, cosine: f32) -> f32 {
        distance * distance / (self.area() * cosine)
    }

    pub(super) fn sample(&self, at: Vec3, [u, v]: [f32; 2]) -> Option<EmitterPoint> {
        let [width, height] = self.half_size;
        let point = self.center
            + (2.0 * u - 1.0) * width * self.axes[0]
            + (2.0 * v - 1.0) * height * self.axes[1];
        let to = point - at;
        let distance = to.length();
        let direction = to.try_normalize()?;
        let cosine = -direction.dot(self.axes[2]);
        (cosine > 1e-6).then(|| EmitterPoint {
            direction,
            distance,
            radiance: self.radiance,
            density: self.density(distance, cosine),
        })
    }

    /// Returns where a ray meets the side that shines.
    pub(super) fn met(&self, origin: Vec3, direction: Vec3) -> Option<EmitterPoint> {
        let cosine = -direction.dot(self.axes[2]);
        if cosine <= 1e-6 {
            return None;
        }
        let distance = (origin - self.center).dot(self.axes[2]) / cosine;
        let from_center = origin + distance * direction - self.center;
        let is_in = |axis: usize| from_center.dot(self.axes[axis]).abs() <= self.half_size[axis];
        (distance > 0.0 && is_in(0) && is_in(1)).then(|| EmitterPoint {
            direction,
            distance,
            radiance: self.radiance,
            density: self.density(distance, cosine),
        })
    }
}
