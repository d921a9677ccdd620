//! Follows paths of light from the viewer.
//!
//! *Theory.* The light transport equation (Kajiya, "The rendering equation", 1986) is estimated by paths. At each surface, a
//! path looks for a light and goes on in a direction that the surface prefers. Where both ways can find a light, each
//! counts by the power heuristic (Veach 1997). A path that carries little ends by chance, and one that goes on carries more
//! (Russian roulette). In fog, a path turns after a length that follows from the fog's density.
//!
//! *Practice.* At glass, a path does not look for lights: only its own direction finds one.

use super::bsdf::Bsdf;
use super::lights::{LightSample, PathLights};
use super::material::PathMaterial;
use super::sampler::Sampler;
use super::{fog, glass};
use crate::light::GROUND;
use argil_abi::{CERTAIN_BOUNCES, FrameUniform};
use argil_scene::Fog;
use glam::Vec3;

/// Where a path met a surface.
#[derive(Clone, Copy, Debug)]
pub struct PathHit {
    /// Length of the ray.
    pub distance: f32,
    /// The point, in the scene's space.
    pub point: Vec3,
    /// The unit normal of the surface, out of the solid.
    pub normal: Vec3,
    /// The unit normal that light sees, which a bump texture turns.
    pub shading_normal: Vec3,
    /// The material there.
    pub material: PathMaterial,
}

/// Surfaces that paths meet.
pub trait PathScene: Sync {
    /// Returns where a ray meets a surface first, within a distance. A ray that begins inside of glass meets the surface where it
    /// leaves, or something opaque inside.
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
    /// How much of what is behind everything is hidden, from 0 to 1.
    pub opacity: f32,
}

/// What all paths of an image share.
pub(super) struct Integrator<'a> {
    pub frame: &'a FrameUniform,
    pub scene: &'a dyn PathScene,
    pub lights: &'a PathLights,
    pub fog: Option<Fog>,
    /// Whether what is behind everything is left out of the picture.
    pub is_transparent: bool,
    pub max_bounces: u32,
    /// The most light that a path may bring after its first surface.
    pub clamp: f32,
}

/// A path on its way.
struct Way {
    origin: Vec3,
    direction: Vec3,
    carried: Vec3,
    /// The density of the direction. The viewer's and glass' are not compared with any.
    density: f32,
    /// What glass around it takes away, if there is any.
    inside: Option<Vec3>,
    /// Where the last surface or fog was that looked for lights.
    bounce: u32,
}

impl Integrator<'_> {
    pub(super) fn path(&self, origin: Vec3, direction: Vec3, sampler: &mut Sampler) -> PathSample {
        let mut found = PathSample {
            opacity: 1.0,
            ..PathSample::default()
        };
        let mut way = Way {
            origin,
            direction,
            carried: Vec3::ONE,
            density: f32::INFINITY,
            inside: None,
            bounce: 0,
        };
        while way.bounce <= self.max_bounces {
            let goes_on = self.step(&mut way, &mut found, sampler);
            if !goes_on {
                break;
            }
            if way.bounce >= CERTAIN_BOUNCES {
                let chance = way.carried.max_element().min(0.95);
                if sampler.one() >= chance {
                    break;
                }
                way.carried /= chance;
            }
            way.bounce += 1;
        }
        found
    }

    /// Goes to the next surface or place in fog, and chooses how to go on from there. Returns whether the path goes on.
    fn step(&self, way: &mut Way, found: &mut PathSample, sampler: &mut Sampler) -> bool {
        let ray = (way.origin, way.direction);
        let hit = self.nearest(way);
        let mut reach = hit.map_or(f32::INFINITY, |(hit, _)| hit.distance);
        let turn = self
            .fog
            .filter(|_| way.inside.is_none())
            .and_then(|medium| {
                let depth = -(1.0 - sampler.one()).ln();
                let length = fog::length_of(&medium, way.origin, way.direction, depth)?;
                (length < reach.min(self.frame.far)).then_some((medium, length))
            });
        if let Some((_, length)) = turn {
            reach = length;
        }
        let passed = self
            .lights
            .passed(ray, reach, |of_light| shared(way.density, of_light));
        self.add(found, way.bounce, way.carried * passed);
        if let Some((fog, length)) = turn {
            if way.bounce == 0 {
                // A denoiser looks at the surface behind the fog, which is the same for all paths.
                found.albedo = Vec3::ONE;
                let behind = hit.map(|(hit, is_solid)| (hit.normal, hit.distance, is_solid));
                (found.normal, found.distance, found.is_covered) = behind.unwrap_or_default();
            }
            return self.turn_in_fog(&fog, length, way, found, sampler);
        }
        match hit {
            Some((hit, is_solid)) => self.meet(&hit, is_solid, way, found, sampler),
            None => {
                let sky = self
                    .lights
                    .sky(self.frame, ray, |of_light| shared(way.density, of_light));
                if way.bounce == 0 && self.fog.is_some() {
                    found.albedo = Vec3::ONE;
                }
                if way.bounce == 0 && self.is_transparent {
                    found.opacity = 0.0;
                } else {
                    self.add(found, way.bounce, way.carried * sky);
                }
                false
            }
        }
    }

    fn turn_in_fog(
        &self,
        medium: &Fog,
        length: f32,
        way: &mut Way,
        found: &mut PathSample,
        sampler: &mut Sampler,
    ) -> bool {
        way.carried *= Vec3::from(medium.albedo);
        if way.bounce == self.max_bounces {
            return false;
        }
        let at = way.origin + length * way.direction;
        let light = self.lights.sample(at, sampler.one(), sampler.pair());
        if let Some(light) = light {
            let share = fog::phase(medium.anisotropy, way.direction.dot(light.direction));
            let arrives = way.carried * light.light * share;
            if arrives.max_element() > 0.0 && !self.is_blocked(at, &light) {
                let arrives = arrives * shared(light.density, share) * self.clear(at, &light);
                self.add(found, way.bounce + 1, arrives);
            }
        }
        let (direction, density) = fog::scattered(medium.anisotropy, way.direction, sampler.pair());
        (way.origin, way.direction, way.density) = (at, direction, density);
        true
    }

    /// Adds the light of a surface, and chooses how a path goes on from it.
    fn meet(
        &self,
        hit: &PathHit,
        is_solid: bool,
        way: &mut Way,
        found: &mut PathSample,
        sampler: &mut Sampler,
    ) -> bool {
        let toward = -way.direction;
        if let Some(absorption) = way.inside {
            way.carried *= (-absorption * hit.distance).map(f32::exp);
        }
        if !is_solid {
            // The ground fades into the horizon.
            let haze = (hit.distance / self.frame.far * 2.2).clamp(0.0, 1.0);
            if way.bounce == 0 && self.is_transparent {
                found.opacity = 1.0 - haze;
            } else {
                let sky = self.lights.background(self.frame, way.direction);
                self.add(found, way.bounce, way.carried * sky * haze);
            }
            way.carried *= 1.0 - haze;
        }
        let rounding = 2.0 * f32::EPSILON * hit.point.abs().max_element();
        let lift = self.scene.lift().max(rounding);
        let glass = hit.material.glass();
        let is_glass = glass > 0.0 && (way.inside.is_some() || sampler.one() < glass);
        if is_glass {
            if way.bounce == 0 {
                found.albedo = Vec3::ONE;
                (found.normal, found.distance, found.is_covered) =
                    (hit.normal, hit.distance, is_solid);
            }
            return self.pass_glass(hit, lift, way, sampler);
        }
        let (normal, outward) = seen_normal(hit.shading_normal, hit.normal, toward);
        let [er, eg, eb, _] = hit.material.surface.emission_metallic;
        self.add(found, way.bounce, way.carried * Vec3::new(er, eg, eb));
        let bsdf = Bsdf::new(&hit.material.surface, normal, toward);
        if way.bounce == 0 {
            // Light from fog is not colored by the surface behind.
            found.albedo = self.fog.map_or(bsdf.albedo, |_| Vec3::ONE);
            (found.normal, found.distance, found.is_covered) = (normal, hit.distance, is_solid);
        }
        if way.bounce == self.max_bounces {
            return false;
        }
        let start = hit.point + outward * lift;
        // In wide scenes, rays begin far above the surface.
        let light = self.lights.sample(hit.point, sampler.one(), sampler.pair());
        // Normals that a texture turns must not let light through the surface.
        let is_turned = hit.shading_normal != hit.normal;
        let is_above = |direction: Vec3| !is_turned || direction.dot(outward) > 0.0;
        if let Some(light) = light.filter(|light| is_above(light.direction)) {
            let (reflected, of_surface) = bsdf.reflected(light.direction);
            let arrives = way.carried * reflected * light.light;
            if arrives.max_element() > 0.0 && !self.is_blocked(start, &light) {
                let share = shared(light.density, of_surface) * self.clear(start, &light);
                self.add(found, way.bounce + 1, arrives * share);
            }
        }
        let Some(next) = bsdf.sample(sampler.one(), sampler.pair()) else {
            return false;
        };
        if next.direction.dot(normal) <= 0.0 || !is_above(next.direction) {
            return false;
        }
        way.carried *= next.weight;
        (way.origin, way.direction, way.density) = (start, next.direction, next.density);
        // What something opaque inside of glass reflects stays inside.
        true
    }

    fn pass_glass(&self, hit: &PathHit, lift: f32, way: &mut Way, sampler: &mut Sampler) -> bool {
        let toward = -way.direction;
        let is_inside = way.inside.is_some();
        let side = if is_inside { -1.0 } else { 1.0 };
        let (normal, outward) = seen_normal(side * hit.shading_normal, side * hit.normal, toward);
        let index = hit.material.refractive_index.max(1.0);
        let ratio = if is_inside { index } else { 1.0 / index };
        let roughness = hit.material.surface.base_roughness[3];
        let (choice, point) = (sampler.one(), sampler.pair());
        let Some(next) = glass::sample(normal, toward, roughness, ratio, choice, point) else {
            return false;
        };
        way.carried *= next.weight;
        let mut away = outward;
        if next.is_through {
            away = -outward;
            if hit.material.attenuation <= 0.0 {
                // Half of the color at each of two surfaces.
                way.carried *= hit.material.base().map(f32::sqrt);
            }
            way.inside = (!is_inside).then(|| hit.material.absorption());
        }
        let turns_back = next.direction.dot(away) <= 0.0;
        if turns_back {
            return false;
        }
        way.origin = hit.point + away * lift;
        (way.direction, way.density) = (next.direction, f32::INFINITY);
        true
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
    fn nearest(&self, way: &Way) -> Option<(PathHit, bool)> {
        let (frame, origin, direction) = (self.frame, way.origin, way.direction);
        let mut reach = frame.far;
        let down = (frame.ground_y - origin.y) / direction.y;
        let is_ground = frame.has_ground != 0
            && way.inside.is_none()
            && direction.y <= -1e-6
            && down > 0.0
            && down < reach;
        if is_ground {
            reach = down;
        }
        let solid = self.scene.nearest(origin, direction, reach);
        let ground = is_ground.then(|| PathHit {
            distance: down,
            point: origin + down * direction,
            normal: Vec3::Y,
            shading_normal: Vec3::Y,
            material: GROUND.into(),
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
        let reach = frame.far.min(light.distance);
        let down = (frame.ground_y - origin.y) / light.direction.y;
        let is_under =
            frame.has_ground != 0 && light.direction.y < 0.0 && down > 0.0 && down < reach;
        is_under || self.scene.is_blocked(origin, light.direction, reach)
    }

    /// Returns the share of light that fog lets through.
    fn clear(&self, origin: Vec3, light: &LightSample) -> f32 {
        let length = self.frame.far.min(light.distance);
        self.fog.map_or(1.0, |medium| {
            fog::transmitted(&medium, origin, light.direction, length)
        })
    }
}

/// Returns a shading normal on the viewer's side, and in which direction rays leave the surface. At silhouettes and edges, normals
/// can point slightly away from the viewer. Those that point far away are of a solid that is seen from inside.
fn seen_normal(shading: Vec3, normal: Vec3, toward: Vec3) -> (Vec3, Vec3) {
    let (shading, normal) = if normal.dot(toward) < -0.5 {
        (-shading, -normal)
    } else {
        (shading, normal)
    };
    let facing = shading.dot(toward);
    if facing >= LEAST_FACING {
        return (shading, normal);
    }
    let bent = shading + (LEAST_FACING - facing) * toward;
    (bent.normalize(), normal)
}

/// The least cosine between a normal and the direction to the viewer.
const LEAST_FACING: f32 = 0.01;

/// Returns the share of a way that has the first density, if another way has the second (the power heuristic).
fn shared(density: f32, other: f32) -> f32 {
    if density.is_infinite() {
        return 1.0;
    }
    let ratio = other / density.max(1e-30);
    1.0 / (1.0 + ratio * ratio)
}
