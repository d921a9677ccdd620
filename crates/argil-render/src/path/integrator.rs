//! Follows paths of light from the viewer.
//!
//! *Theory.* The light transport equation (Kajiya, "The rendering equation", 1986) is estimated by paths. At each surface, a
//! path looks for a light and goes on in a direction that the surface prefers. Where both ways can find a light, each
//! counts by the power heuristic (Veach 1997). A path that carries little ends by chance, and one that goes on carries more
//! (Russian roulette).

use super::bsdf::Bsdf;
use super::lights::{LightSample, PathLights};
use super::sampler::Sampler;
use crate::light::GROUND;
use argil_abi::{FrameUniform, GpuMaterial};
use glam::Vec3;

/// Where a path met a surface.
#[derive(Clone, Copy, Debug)]
pub struct PathHit {
    /// Length of the ray.
    pub distance: f32,
    /// The point, in the scene's space.
    pub point: Vec3,
    /// The unit normal, out of the solid.
    pub normal: Vec3,
    /// The material there.
    pub material: GpuMaterial,
}

/// Surfaces that paths meet.
pub trait PathScene: Sync {
    /// Returns where a ray meets a surface first, within a distance.
    fn nearest(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<PathHit>;

    /// Whether anything is in the way of a ray within a distance.
    fn is_blocked(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> bool;

    /// Returns how far above a surface rays begin that leave it.
    fn lift(&self) -> f32;
}

/// What a path found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathSample {
    pub light: Vec3,
    /// Of the first surface: what it reflects, and its normal and distance. Zero where there is none.
    pub albedo: Vec3,
    pub normal: Vec3,
    pub distance: f32,
    /// Whether the first surface is solid.
    pub is_covered: bool,
}

/// Surfaces that a path passes before chance decides how it goes on.
const CERTAIN_BOUNCES: u32 = 3;

/// What all paths of an image share.
pub(super) struct Integrator<'a> {
    pub frame: &'a FrameUniform,
    pub scene: &'a dyn PathScene,
    pub lights: &'a PathLights,
    pub max_bounces: u32,
    /// The most light that a path may bring after its first surface.
    pub clamp: f32,
}

impl Integrator<'_> {
    pub(super) fn path(
        &self,
        mut origin: Vec3,
        mut direction: Vec3,
        sampler: &mut Sampler,
    ) -> PathSample {
        let mut found = PathSample::default();
        let mut carried = Vec3::ONE;
        // The density of the direction. The viewer's is not compared with any.
        let mut density = f32::INFINITY;
        for bounce in 0..=self.max_bounces {
            let hit = self.nearest(origin, direction);
            let Some((hit, is_solid)) = hit else {
                let sky = self
                    .lights
                    .sky(self.frame, direction, |of_light| shared(density, of_light));
                self.add(&mut found, bounce, carried * sky);
                break;
            };
            let toward = -direction;
            let (normal, outward) = seen_normal(hit.normal, toward);
            if !is_solid {
                // The ground fades into the horizon.
                let haze = (hit.distance / self.frame.far * 2.2).clamp(0.0, 1.0);
                let sky = self.lights.background(self.frame, direction);
                self.add(&mut found, bounce, carried * sky * haze);
                carried *= 1.0 - haze;
            }
            let [er, eg, eb, _] = hit.material.emission_metallic;
            self.add(&mut found, bounce, carried * Vec3::new(er, eg, eb));
            let bsdf = Bsdf::new(&hit.material, normal, toward);
            if bounce == 0 {
                found.albedo = bsdf.albedo;
                (found.normal, found.distance, found.is_covered) = (normal, hit.distance, is_solid);
            }
            if bounce == self.max_bounces {
                break;
            }
            let rounding = 2.0 * f32::EPSILON * hit.point.abs().max_element();
            let start = hit.point + outward * self.scene.lift().max(rounding);
            if let Some(light) = self.lights.sample(sampler.one(), sampler.pair()) {
                let (reflected, of_surface) = bsdf.reflected(light.direction);
                let arrives = carried * reflected * light.light;
                if arrives.max_element() > 0.0 && !self.is_blocked(start, &light) {
                    let share = shared(light.density, of_surface);
                    self.add(&mut found, bounce + 1, arrives * (share / light.density));
                }
            }
            let Some(next) = bsdf.sample(sampler.one(), sampler.pair()) else {
                break;
            };
            if next.direction.dot(normal) <= 0.0 {
                break;
            }
            carried *= next.weight;
            if bounce >= CERTAIN_BOUNCES {
                let chance = carried.max_element().min(0.95);
                if sampler.one() >= chance {
                    break;
                }
                carried /= chance;
            }
            (origin, direction, density) = (start, next.direction, next.density);
        }
        found
    }

    /// Adds light that passed some surfaces.
    fn add(&self, found: &mut PathSample, bounces: u32, light: Vec3) {
        let most = light.max_element();
        let is_bright = bounces > 0 && most > self.clamp;
        if light.is_finite() {
            found.light += if is_bright {
                light * (self.clamp / most)
            } else {
                light
            };
        }
    }

    /// Returns the nearest surface, and whether it is solid: the ground is not.
    fn nearest(&self, origin: Vec3, direction: Vec3) -> Option<(PathHit, bool)> {
        let frame = self.frame;
        let mut reach = frame.far;
        let down = (frame.ground_y - origin.y) / direction.y;
        let is_ground = frame.has_ground != 0 && direction.y <= -1e-6 && down > 0.0 && down < reach;
        if is_ground {
            reach = down;
        }
        let solid = self.scene.nearest(origin, direction, reach);
        let ground = is_ground.then(|| PathHit {
            distance: down,
            point: origin + down * direction,
            normal: Vec3::Y,
            material: GROUND,
        });
        match (solid, ground) {
            (Some(solid), Some(ground)) if ground.distance < solid.distance => {
                Some((ground, false))
            }
            (Some(solid), _) => Some((solid, true)),
            (None, ground) => ground.map(|ground| (ground, false)),
        }
    }

    fn is_blocked(&self, origin: Vec3, light: &LightSample) -> bool {
        let frame = self.frame;
        let reach = frame.far;
        let down = (frame.ground_y - origin.y) / light.direction.y;
        let is_under =
            frame.has_ground != 0 && light.direction.y < 0.0 && down > 0.0 && down < reach;
        is_under || self.scene.is_blocked(origin, light.direction, reach)
    }
}

/// Returns a normal on the viewer's side, and in which direction rays leave the surface. At silhouettes and edges, normals can
/// point slightly away from the viewer. Those that point far away are of a solid that is seen from inside.
fn seen_normal(normal: Vec3, toward: Vec3) -> (Vec3, Vec3) {
    let facing = normal.dot(toward);
    if facing >= LEAST_FACING {
        return (normal, normal);
    }
    if facing < -0.5 {
        return (-normal, -normal);
    }
    let bent = normal + (LEAST_FACING - facing) * toward;
    (bent.normalize(), normal)
}

/// The least cosine between a normal and the direction to the viewer.
const LEAST_FACING: f32 = 0.01;

/// Returns the share of a way that has the first density, if another way has the second (the power heuristic).
fn shared(own: f32, other: f32) -> f32 {
    if own.is_infinite() {
        return 1.0;
    }
    let ratio = other / own.max(1e-30);
    1.0 / (1.0 + ratio * ratio)
}
