//! Casts rays and spheres against the surface.
//! *Practice.* A cast evaluates only the operands near it, which a [`Probe`] finds.

use crate::probe::{AHEAD, Probe, material_of};
use crate::query::{Query, QuerySource};
use argil_abi::GpuMaterial;
use argil_scene::Material;
use glam::Vec3;

/// Maximum steps of a cast.
const MAX_STEPS: usize = 4096;
/// Fraction of the largest over-relaxed step to take, because surfaces are not planes.
const RELAXATION: f32 = argil_abi::RELAXATION;

/// Where a cast met the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct RayHit {
    /// Distance traveled along the ray, in the scene's unit.
    pub distance: f32,
    /// The point on the surface.
    pub point: [f32; 3],
    /// The unit normal, pointing out of the solid. Zero where the field has none.
    pub normal: [f32; 3],
    /// The material of the surface at that point.
    pub material: Material,
}

/// Plans the steps of a cast. A step goes beyond the free sphere by as much as distances have shrunk along the way,
/// and returns if the next free sphere does not reach back (auto-relaxed sphere tracing, Bán and Valasek 2023).
#[derive(Default)]
struct StepPlanner {
    /// The ray is known to be free up to this distance.
    free: f32,
    /// The last place with an exact distance: where it was, how far it was free, and how fast that shrinks.
    last: Option<(f32, f32, f32)>,
}

impl StepPlanner {
    /// Fills in the next places to sample, as if distances keep shrinking at the same rate. Returns their number.
    fn plan(&self, max_distance: f32, epsilon: f32, out: &mut [f32; AHEAD]) -> usize {
        out[0] = self.free.min(max_distance);
        let Some((mut t, mut free, slope)) = self.last else {
            return 1;
        };
        // In front of a plane, the free sphere of the next point then reaches back exactly.
        let step = 1.0 + RELAXATION * (1.0 - slope) / (1.0 + slope);
        for (place, out) in out.iter_mut().enumerate() {
            if t >= max_distance || place > 0 && free < epsilon {
                return place;
            }
            t += step * free;
            free -= slope * step * free;
            *out = t.min(max_distance);
        }
        AHEAD
    }

    /// Records that a sphere of radius `free` around `t` is free. `is_exact` tells whether that is the distance or
    /// a lower bound.
    fn advance(&mut self, t: f32, free: f32, is_exact: bool) {
        let slope = match self.last {
            Some((before, was_free, _)) if t > before => {
                ((was_free - free) / (t - before)).clamp(0.0, 1.0)
            }
            _ => 1.0,
        };
        self.free = self.free.max(t + free);
        self.last = is_exact.then_some((t, free, slope));
    }

    /// Forgets the rate, because a step skipped a part of the ray that must be sampled.
    fn reset(&mut self) {
        self.last = None;
    }
}

impl Query<'_> {
    /// Casts a ray, and returns the first point where it meets the surface within `max_distance`. A ray that starts
    /// inside a solid hits where it leaves; [`Query::distance`] tells whether a point is inside.
    /// `direction` need not be a unit vector. Distances are in the scene's unit. Returns `None` for a direction of
    /// length 0, and for values that are not finite.
    #[doc(alias = "raycast")]
    #[doc(alias = "raymarch")]
    #[doc(alias = "sphere tracing")]
    #[doc(alias = "ray_intersect")]
    pub fn cast_ray(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        max_distance: f32,
    ) -> Option<RayHit> {
        self.cast(origin.into(), direction.into(), 0.0, max_distance)
            .0
    }

    /// Casts a sphere of a radius along a ray, and returns where it touches the surface from outside. If it touches
    /// or overlaps the solid at the start, it hits at distance 0, whatever the direction. A character controller
    /// keeps a small gap to the surface, and ignores a hit if it moves away from it:
    /// `direction.dot(normal) >= 0`.
    ///
    /// The work is bounded: each step is as long as the free distance, and evaluates only operands near it.
    #[doc(alias = "shape cast")]
    #[doc(alias = "sweep")]
    pub fn cast_sphere(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        radius: f32,
        max_distance: f32,
    ) -> Option<RayHit> {
        let is_sphere = radius.is_finite() && radius >= 0.0;
        is_sphere
            .then(|| {
                self.cast(origin.into(), direction.into(), radius, max_distance)
                    .0
            })
            .flatten()
    }

    /// Casts many rays on rayon's threads: see [`Query::cast_ray`]. All rays have the same maximum distance.
    ///
    /// # Panics
    /// If `origins` and `directions` differ in length.
    pub fn cast_rays(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        max_distance: f32,
    ) -> Vec<Option<RayHit>> {
        use rayon::prelude::*;
        assert_eq!(origins.len(), directions.len(), "a direction for each ray");
        let rays = origins.par_iter().zip(directions);
        rays.map(|(&origin, &direction)| self.cast_ray(origin, direction, max_distance))
            .collect()
    }

    /// Returns what a cast meets, and how many instructions it ran in how many evaluations.
    fn cast(
        &self,
        origin: Vec3,
        direction: Vec3,
        radius: f32,
        max_distance: f32,
    ) -> (Option<RayHit>, [u64; 2]) {
        let Some(direction) = direction.try_normalize() else {
            return (None, [0; 2]);
        };
        if !origin.is_finite() || max_distance.is_nan() {
            return (None, [0; 2]);
        }
        let mut probe = Probe::new(self.world, radius + self.epsilon);
        let met = self.march(&mut probe, (origin, direction), radius, max_distance);
        let hit =
            met.map(|(t, by_field)| self.hit(&mut probe, (origin + t * direction, t), by_field));
        (hit, probe.counts)
    }

    /// Returns how far a ray or a sphere goes until it meets the surface, and whether that came from the field.
    pub(crate) fn march(
        &self,
        probe: &mut Probe<'_>,
        (origin, direction): (Vec3, Vec3),
        radius: f32,
        max_distance: f32,
    ) -> Option<(f32, bool)> {
        let is_field = matches!(self.source, QuerySource::Field);
        let scale = 1.0 / self.tables().lipschitz();
        let first = self.sample(probe, origin).0;
        let side = if first < 0.0 && radius == 0.0 {
            -1.0
        } else {
            1.0
        };
        let ray = (origin, direction);
        let mut pace = StepPlanner::default();
        let (mut ahead, mut found) = ([0.0; AHEAD], [0.0; AHEAD]);
        for _ in 0..MAX_STEPS {
            let planned = pace.plan(max_distance, self.epsilon, &mut ahead);
            let p = origin + ahead[0] * direction;
            let mut count = 1;
            let mut is_told = true;
            let mut asks = is_field;
            if !is_field {
                (found[0], is_told) = self.sample(probe, p);
                // The sphere reaches beyond the stored band, where the field knows more.
                asks = !is_told && radius > 0.0 && found[0] < 2.0 * radius;
            }
            if asks {
                count = probe.distances_along(ray, &ahead[..planned], &mut found);
            }
            for (&t, &d) in ahead[..count].iter().zip(&found) {
                let gap = side * d - radius;
                let mut free = gap * scale;
                if !is_told && radius == 0.0 {
                    // The sample proves that no surface is near, but not how far it is.
                    free = free.max(0.5 * self.voxel());
                }
                if t > pace.free && t - free > pace.free {
                    pace.reset();
                    break;
                }
                let is_near = gap < self.epsilon.max(2.0 * f32::EPSILON * t);
                if is_near && (is_told || radius > 0.0) {
                    return Some((t, asks));
                }
                pace.advance(t, free, is_told || asks);
                if pace.free > max_distance {
                    return None;
                }
            }
        }
        None
    }

    /// Returns the direction in which distances grow around a point, by central differences.
    fn difference(&self, probe: &mut Probe<'_>, p: Vec3) -> Vec3 {
        let step = 16.0 * self.epsilon;
        Vec3::from(Vec3::AXES.map(|axis| {
            let up = self.sample(probe, p + step * axis).0;
            up - self.sample(probe, p - step * axis).0
        }))
    }

    /// Describes the surface at the point where a cast ended.
    pub(crate) fn hit(&self, probe: &mut Probe<'_>, (p, t): (Vec3, f32), by_field: bool) -> RayHit {
        let (point, normal) = self.surface(probe, p, by_field);
        let kept = self.stored_material(point, normal, by_field);
        let material = kept.unwrap_or_else(|| probe.material(point));
        RayHit {
            distance: t,
            point: point.to_array(),
            normal: normal.to_array(),
            material: material_of(&material),
        }
    }

    /// Returns the point of the surface near the end of a cast, and its normal.
    pub(crate) fn surface(&self, probe: &mut Probe<'_>, p: Vec3, by_field: bool) -> (Vec3, Vec3) {
        let asked = if by_field { self.of_field() } else { *self };
        let (d, g) = asked.distance_and_gradient(probe, p);
        // Right on the surface of some shapes, the gradient is none.
        let normal = g
            .try_normalize()
            .unwrap_or_else(|| asked.difference(probe, p).normalize_or_zero());
        // Where distances are underestimates, the surface lies farther along.
        let point = asked.project_to_surface(probe, p).unwrap_or(p - d * normal);
        (point, normal)
    }

    /// Returns the material that a volume stores at a point of its surface.
    pub(crate) fn stored_material(
        &self,
        point: Vec3,
        normal: Vec3,
        by_field: bool,
    ) -> Option<GpuMaterial> {
        match self.source {
            QuerySource::Volume(volume) if !by_field => {
                volume.material_at(point, normal, self.tables().materials())
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BricksOptions, Engine};
    use argil_scene::{Brush, Edit, Modifier, Scene, Shape};

    /// A level of many brushes over a floor.
    fn level(count: u32) -> Scene {
        let mut scene = Scene::new();
        let floor = Brush::new(Shape::cuboid([4.0, 0.2, 4.0])).at([0.0, -0.2, 0.0]);
        scene.push(floor).expect("a brush");
        for i in 0..count {
            let along = |k: u32| 8.0 * ((i * k) % 1009) as f32 / 1009.0 - 4.0;
            let brush = match i % 3 {
                0 => Brush::new(Shape::sphere(0.12)),
                1 => Brush::new(Shape::cuboid([0.1, 0.3, 0.1])),
                _ => Brush::new(Shape::torus(0.15, 0.05)),
            };
            let brush = brush
                .at([along(101), 0.1, along(57)])
                .smooth(0.02 * (i % 2) as f32);
            scene.push(brush).expect("a brush");
        }
        scene
    }

    /// Casts of spheres look at what is near, however many brushes there are, and stop where the field says.
    #[test]
    fn the_work_of_sphere_casts_is_bounded() {
        for (count, is_edited, instructions) in [
            (60, false, 400),
            (1_000, false, 1_500),
            (1_000, true, 12_000),
        ] {
            let mut scene = level(count);
            let options = BricksOptions {
                resolution: 192,
                ..BricksOptions::default()
            };
            let world = Engine::cpu().build(&scene);
            let world = world.and_then(|world| world.bricks(options));
            let mut world = world.expect("a world");
            if is_edited {
                let node = scene.node(Scene::ROOT).children()[9];
                let by = Modifier::Translate {
                    by: [0.1, 0.0, 0.0],
                };
                scene.apply(Edit::Transform { node, by }).expect("an edit");
                assert!(!world.apply(&scene).expect("an edit").rebuilt);
            }
            let query = world.query_volume().expect("bricks");
            let (mut hits, mut max_distance) = (0, [0u64; 2]);
            for i in 0..400 {
                let along = |k: u32| 6.0 * ((i * k) % 397) as f32 / 397.0 - 3.0;
                let origin = Vec3::new(along(31), 2.0, along(83));
                let turn = i as f32;
                let direction = Vec3::new(turn.cos(), -0.8, turn.sin()).normalize();
                let radius = [0.05, 0.3, 0.5][i as usize % 3];
                let (hit, counts) = query.cast(origin, direction, radius, 10.0);
                max_distance = [0, 1].map(|k| max_distance[k].max(counts[k]));
                let Some(hit) = hit else { continue };
                hits += 1;
                let at = |t: f32| world.distance((origin + t * direction).to_array());
                // Bricks and the field differ by a fraction of a voxel.
                let voxel = 8.0 / 192.0;
                assert!(
                    (at(hit.distance) - radius).abs() < 0.6 * voxel,
                    "{i}: {hit:?}"
                );
                for k in 0..50 {
                    let before = at(hit.distance * k as f32 / 50.0);
                    assert!(before > radius - 0.6 * voxel, "{i}: {before} {hit:?}");
                }
            }
            assert!(hits > 300, "{hits}");
            // All of it at each step would be a thousand each.
            assert!(
                max_distance[1] < 40 && max_distance[0] < instructions,
                "{count}: {max_distance:?}"
            );
        }
    }

    /// What is hit says what it is made of.
    #[test]
    fn hits_tell_materials() {
        let mut scene = Scene::new();
        let red = Material {
            base_color: [0.8, 0.1, 0.1],
            ..Material::default()
        };
        scene.set_material("red", red.clone()).expect("a material");
        let solid = Brush::new(Shape::sphere(0.5)).at([1.0, 0.0, 0.0]);
        scene.push(solid.with_material("red")).expect("a brush");
        scene
            .push(Brush::new(Shape::sphere(0.5)).at([-1.0, 0.0, 0.0]))
            .expect("a brush");
        let world = Engine::cpu().build(&scene);
        let world = world.and_then(|world| world.bricks(256)).expect("a world");
        let near = |a: &Material, b: &Material| {
            let apart = |k: usize| (a.base_color[k] - b.base_color[k]).abs();
            (0..3).all(|k| apart(k) < 0.02)
        };
        for query in [world.query(), world.query_volume().expect("bricks")] {
            for (x, expected) in [(1.0, red.clone()), (-1.0, Material::default())] {
                let down = [0.0, -1.0, 0.0];
                let ray = query.cast_ray([x, 2.0, 0.0], down, 5.0).expect("a hit");
                assert!(near(&ray.material, &expected), "{ray:?}");
                assert!(near(&query.material(ray.point), &expected));
                let sphere = query
                    .cast_sphere([x, 2.0, 0.0], down, 0.2, 5.0)
                    .expect("a hit");
                assert!(near(&sphere.material, &expected), "{sphere:?}");
            }
        }
    }
}
