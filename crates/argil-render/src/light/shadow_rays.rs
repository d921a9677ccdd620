//! Rays to lamps, with cones around them. `lamp_shadows.wgsl` is the twin.

use super::lamp_shape::LampShape;
use super::light_source::LightSource;
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use argil_abi::{self as abi, FrameUniform};
use argil_math::Ray;
use glam::Vec3;

/// How near the distance of a plane must be to that of the point, because stored distances are not quite exact.
const PLANE: f32 = 0.9;

/// The longest step, in distances. A ray goes back where that was too far (Keinert et al., "Enhanced sphere tracing", 2014).
const RELAXED: f32 = 1.8;

/// The last step of a ray is this share of what is left of its way, unless all of that is known to be free.
const NEAR_END: f32 = 0.999;

/// A ray to a lamp, with a cone around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    pub id: u32,
    pub origin: Vec3,
    pub direction: Vec3,
    pub t: f32,
    pub begin: f32,
    pub end: f32,
    /// The last place where the cone was free, and what share of the whole way a place is.
    pub free: f32,
    pub share: [f32; 2],
    /// The cone's radius, and the heights above the surface's plane and before the lamp's. Each has its value at the beginning, and
    /// what it gains with the way.
    pub width: [f32; 2],
    pub above: [f32; 2],
    pub before: [f32; 2],
    pub min_step: f32,
    /// Whether it ends where it is in the solid. A cone ends where all of it is.
    pub is_point: bool,
    /// The least distance in cone radii, from −1 to 1.
    pub least: f32,
    /// The last step, and how far it was safe to go.
    last: [f32; 2],
}

/// What a ray saw.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// The least distance in cone radii, from −1 to 1.
    pub least: f32,
    /// The shares of the way up to which and from which on the whole cone is free.
    pub free: [f32; 2],
}

/// Rays that march together. Each has two halves, which begin at the surface and at the lamp. Steps are short where a ray comes
/// near a plane, and become longer where it leaves one.
#[derive(Debug, Default)]
pub(super) struct ShadowRays {
    rays: Vec<ShadowRay>,
    others: Vec<ShadowRay>,
}

impl ShadowRay {
    /// Creates a ray from above a surface to a point of a lamp. `radii` are those of the cone at both ends.
    pub(super) fn new(
        lamp: &LampShape,
        (p, n): (Vec3, Vec3),
        heights: [f32; 2],
        target: Vec3,
        radii: [f32; 2],
        min_step: f32,
    ) -> Self {
        let [lift, spread] = heights;
        let lift = lift.min(0.05 * p.distance(target));
        let origin = p + n * lift;
        let to = target - origin;
        let end = to.length().max(1e-20);
        let direction = to / end;
        let before = if lamp.out == Vec3::ZERO {
            [f32::MAX, 0.0]
        } else {
            let height = (origin - lamp.center).dot(lamp.out);
            [height, direction.dot(lamp.out)]
        };
        Self {
            id: 0,
            origin,
            direction,
            t: 0.0,
            begin: 0.0,
            free: 0.0,
            share: [0.0, 1.0 / end],
            end: end - (0.1 * lamp.extent).min(0.1 * end),
            width: [radii[0], (radii[1] - radii[0]) / end],
            above: [lift - spread, direction.dot(n)],
            before,
            min_step,
            is_point: false,
            least: 1.0,
            last: [0.0; 2],
        }
    }

    /// Cuts the ray to the solids' box, as far as its cone reaches, and to what is not known to be free. Returns whether anything is left.
    fn enter(&mut self, frame: &FrameUniform, free: [f32; 2]) -> bool {
        let ray = Ray {
            origin: self.origin,
            direction: self.direction,
        };
        let widest = self.width[0].max(self.width[0] + self.width[1] * self.end);
        let Some((near, far)) = ray.span(bounds_of(frame).grown(widest)) else {
            return false;
        };
        let [first, last] = free.map(|share| share / self.share[1]);
        (self.begin, self.end) = (near.max(first), self.end.min(far).min(last));
        (self.t, self.free) = (self.begin, self.begin);
        self.begin < self.end
    }

    /// Splits the ray in the middle. Returns the other half, which leads from the lamp back to there.
    fn split(&mut self) -> Self {
        let last = self.end;
        self.end = 0.5 * (self.begin + last);
        let back = |line: [f32; 2]| [line[0] + line[1] * last, -line[1]];
        Self {
            origin: self.origin + last * self.direction,
            direction: -self.direction,
            t: 0.0,
            begin: 0.0,
            end: last - self.end,
            free: 0.0,
            share: back(self.share),
            width: back(self.width),
            above: back(self.above),
            before: back(self.before),
            ..*self
        }
    }

    /// Goes on by a distance, and at least so far that the last step arrives.
    fn step(&mut self, index: u32, d: f32, scale: f32) {
        let at = |line: [f32; 2]| line[0] + line[1] * self.t;
        let width = at(self.width);
        let planes = PLANE * at(self.above).min(at(self.before)).max(0.0);
        let radius = width.min(planes).max(1e-20);
        // Whole cones take the distance that is certain, and points the likely one.
        let (certain, dark) = if self.is_point {
            (d, radius)
        } else {
            (d * scale, width)
        };
        let free = (certain / width.max(1e-20)).max(d / planes.max(1e-20));
        self.least = self.least.min(free.max(-1.0));
        if certain <= -dark {
            (self.least, self.end) = (-1.0, -1.0);
        } else if d < 0.0 && !self.is_point {
            self.least = self.least.max(-0.99);
        }
        let safe = d.abs() * scale;
        let [last, was_safe] = self.last;
        if last > was_safe + safe {
            // The balls around both places do not touch.
            self.t += was_safe - last;
            self.last = [0.0; 2];
            return;
        }
        if self.least >= 1.0 {
            self.free = self.t;
        }
        let share = (index + 1) as f32 / abi::LAMP_SHADOW_STEPS as f32;
        let due = self.begin + share * share * share * (self.end - self.begin) - self.t;
        let least = self.min_step.max(0.5 * radius).max(due);
        let mut way = (RELAXED * safe).max(least);
        let left = self.end - self.t;
        if way >= left && safe < left {
            // What is at the end tells whether the step was too long.
            way = NEAR_END * left;
        }
        self.last = [way, safe.max(least)];
        self.t += way;
    }
}

impl ShadowRays {
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.others.clear();
    }

    /// Adds a ray with an id, if anything can be in its way.
    pub(super) fn push(
        &mut self,
        id: usize,
        mut ray: ShadowRay,
        frame: &FrameUniform,
        free: [f32; 2],
    ) {
        ray.id = id as u32;
        if ray.enter(frame, free) {
            self.others.push(ray.split());
            self.rays.push(ray);
        }
    }

    /// Marches all rays, and reduces what they saw.
    pub(super) fn march(
        &mut self,
        seen: &mut [Seen],
        frame: &FrameUniform,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        march(&mut self.rays, seen, frame, source, points);
        let others = &mut self.others;
        others.retain(|ray| seen[ray.id as usize].least > -1.0);
        march(others, seen, frame, source, points);
    }
}

fn march(
    rays: &mut Vec<ShadowRay>,
    seen: &mut [Seen],
    frame: &FrameUniform,
    source: &mut LightSource<'_, '_>,
    points: &mut Points,
) {
    let (batch, far) = (source.batch(), source.far());
    for index in 0..abi::LAMP_SHADOW_STEPS {
        if rays.is_empty() {
            break;
        }
        for rays in rays.chunks_mut(batch) {
            points.clear();
            for ray in rays.iter() {
                points.push(ray.origin + ray.t * ray.direction);
            }
            source.measure(points);
            for (ray, &d) in rays.iter_mut().zip(&points.d) {
                let d = if d < far { d } else { f32::MAX };
                ray.step(index, d, frame.inv_lipschitz);
            }
        }
        rays.retain(|ray| {
            let seen = &mut seen[ray.id as usize];
            seen.least = seen.least.min(ray.least);
            let free = ray.share[0] + ray.share[1] * ray.free;
            if ray.share[1] > 0.0 {
                seen.free[0] = seen.free[0].max(free);
            } else {
                seen.free[1] = seen.free[1].min(free);
            }
            ray.t < ray.end
        });
    }
}

/// Returns the share of a ray's light that passes something in its way, from −1 for all of it to 1 for nothing.
pub(super) fn covered(seen: f32) -> f32 {
    let t = (0.5 + 0.5 * seen).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
