//! Rays and spheres that move until they meet the surface.
//!
//! *Practice.* A cast evaluates the field by the operands that are near, which a [`Probe`] finds: in the lists of edits where those
//! are followed, else in an index over the program's operands. Both tell distances as far as their parts are long; what is
//! farther is at least that far, which is how far a cast then goes.

use crate::query::{Query, Source};
use crate::{Material, World};
use argil_abi::{Instr, MaterialWords};
use argil_field::{Evaluator, LiveProgram, OperandIndex, Program};
use glam::{IVec3, Vec3};

/// Steps of a cast.
const MOST_STEPS: usize = 4096;

/// Where a cast has met the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// How far the ray, or the sphere's centre, has come.
    pub t: f32,
    /// The point of the surface.
    pub point: [f32; 3],
    /// The unit normal there, out of the solid; zero where the field has none.
    pub normal: [f32; 3],
    /// What the surface is made of there.
    pub material: Material,
}

/// A material as the interpreter has it.
pub(crate) fn material_of(words: &MaterialWords) -> Material {
    let [r, g, b, roughness] = words.base_roughness;
    let [er, eg, eb, metallic] = words.emission_metallic;
    Material {
        base_color: [r, g, b],
        roughness,
        metallic,
        emission: [er, eg, eb],
    }
}

/// Where lists of what is near come from.
#[derive(Clone, Copy)]
enum Lists<'a> {
    Live(&'a LiveProgram),
    Index(&'a OperandIndex),
    /// All of the program.
    Whole,
}

/// Evaluates the field at one point after the other.
pub(crate) struct Probe<'a> {
    world: &'a World,
    lists: Lists<'a>,
    evaluator: Option<Evaluator<'a>>,
    /// The part that `list` is of.
    part: Option<IVec3>,
    list: Vec<Instr>,
    /// Instructions that were run, and how often.
    pub counts: [u64; 2],
}

impl<'a> Probe<'a> {
    /// For distances that matter up to `reach`.
    pub fn new(query: &Query<'a>, reach: f32) -> Self {
        let world = query.world;
        let fits = |far: f32| reach <= 0.8 * far;
        let lists = match world.live_program() {
            Some(live) if fits(live.parts().far) => Lists::Live(live),
            _ => match world.operand_index() {
                Some(index) if fits(index.parts().far) => Lists::Index(index),
                _ => Lists::Whole,
            },
        };
        Self {
            world,
            lists,
            evaluator: None,
            part: None,
            list: Vec::new(),
            counts: [0; 2],
        }
    }

    fn program(&self) -> &'a Program {
        match self.lists {
            Lists::Live(live) => live.program(),
            Lists::Index(_) | Lists::Whole => self.world.program(),
        }
    }

    /// The distance beyond which nothing is told.
    fn far(&self) -> f32 {
        match self.lists {
            Lists::Live(live) => live.parts().far,
            Lists::Index(index) => index.parts().far,
            Lists::Whole => f32::MAX,
        }
    }

    /// Have the list for a point at hand; an evaluator to run it.
    fn prepare(&mut self, p: Vec3) -> (&mut Evaluator<'a>, &[Instr]) {
        let program = self.program();
        let part = match self.lists {
            Lists::Live(live) => live.parts().part_of(p),
            Lists::Index(index) => index.parts().part_of(p),
            Lists::Whole => IVec3::ZERO,
        };
        if self.part != Some(part) {
            self.part = Some(part);
            self.list.clear();
            match self.lists {
                Lists::Live(live) => live.list(part, &mut self.list),
                Lists::Index(index) => index.list(program, part, &mut self.list),
                Lists::Whole => {}
            }
        }
        let list = match self.lists {
            Lists::Whole => program.instrs(),
            _ => &self.list,
        };
        self.counts[0] += list.len() as u64;
        self.counts[1] += 1;
        let evaluator = self
            .evaluator
            .get_or_insert_with(|| Evaluator::new(program));
        (evaluator, list)
    }

    /// The distance at a point, as far as it is told.
    pub fn distance(&mut self, p: Vec3) -> f32 {
        let far = self.far();
        let (evaluator, list) = self.prepare(p);
        let mut d = [0.0];
        evaluator.distances_by(list, &[p.x], &[p.y], &[p.z], &mut d);
        d[0].clamp(-far, far)
    }

    /// The distance and its gradient at a point near the surface.
    pub fn gradient(&mut self, p: Vec3) -> (f32, Vec3) {
        let (evaluator, list) = self.prepare(p);
        let (mut d, mut g) = ([0.0], [[0.0]; 3]);
        let [x, y, z] = &mut g;
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.gradients_by(list, point, &mut d, [x, y, z]);
        (d[0], Vec3::new(g[0][0], g[1][0], g[2][0]))
    }

    /// What a point near the surface is made of.
    pub fn material(&mut self, p: Vec3) -> MaterialWords {
        let (evaluator, list) = self.prepare(p);
        let (mut d, mut material) = ([0.0], [MaterialWords::default()]);
        let point: [&[f32]; 3] = [&[p.x], &[p.y], &[p.z]];
        evaluator.materials_by(list, point, &mut d, &mut material);
        material[0]
    }
}

impl Query<'_> {
    /// Where a ray meets the surface first, within a length; from inside of a solid, where it leaves it. The direction need
    /// not be a unit vector, lengths are the world's. Nothing for a direction of no length, or what is not finite.
    pub fn ray_cast(&self, origin: [f32; 3], direction: [f32; 3], most: f32) -> Option<CastHit> {
        self.cast(origin.into(), direction.into(), 0.0, most).0
    }

    /// Where a sphere of a radius that moves along a ray meets the surface from outside; `t` is 0 where it touches it already.
    ///
    /// Its work is bounded: steps are as long as what is free, and each looks at the operands that are near.
    pub fn sphere_cast(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        radius: f32,
        most: f32,
    ) -> Option<CastHit> {
        let is_sphere = radius.is_finite() && radius >= 0.0;
        is_sphere
            .then(|| self.cast(origin.into(), direction.into(), radius, most).0)
            .flatten()
    }

    /// [`Query::ray_cast`] of many rays, on rayon's threads.
    ///
    /// # Panics
    /// If there are not as many directions as origins.
    pub fn ray_casts(
        &self,
        origins: &[[f32; 3]],
        directions: &[[f32; 3]],
        most: f32,
    ) -> Vec<Option<CastHit>> {
        use rayon::prelude::*;
        assert_eq!(origins.len(), directions.len(), "a direction for each ray");
        let rays = origins.par_iter().zip(directions);
        rays.map(|(&origin, &direction)| self.ray_cast(origin, direction, most))
            .collect()
    }

    /// What a cast meets, and the instructions that it has run, with how often.
    fn cast(
        &self,
        origin: Vec3,
        direction: Vec3,
        radius: f32,
        most: f32,
    ) -> (Option<CastHit>, [u64; 2]) {
        let Some(direction) = direction.try_normalize() else {
            return (None, [0; 2]);
        };
        if !origin.is_finite() || most.is_nan() {
            return (None, [0; 2]);
        }
        let is_field = matches!(self.source, Source::Field);
        let scale = 1.0 / self.tables().lipschitz();
        let mut probe = Probe::new(self, radius + self.epsilon);
        let tell = |probe: &mut Probe<'_>, p: Vec3| match is_field {
            true => (probe.distance(p), true),
            false => self.tell(p),
        };
        let first = tell(&mut probe, origin).0;
        let side = if first < 0.0 && radius == 0.0 {
            -1.0
        } else {
            1.0
        };
        let mut t = 0.0f32;
        for _ in 0..MOST_STEPS {
            let p = origin + t * direction;
            let (d, is_told) = tell(&mut probe, p);
            let mut gap = side * d - radius;
            if !is_told && radius == 0.0 {
                // No surface is here, however little is known of where it is.
                t += (gap * scale).max(0.5 * self.voxel());
                if t > most {
                    return (None, probe.counts);
                }
                continue;
            }
            // The sphere reaches farther than what is stored: the field knows more.
            let asks = !is_told && gap < radius;
            if asks {
                gap = probe.distance(p) - radius;
            }
            if gap < self.epsilon.max(2.0 * f32::EPSILON * t) {
                let hit = self.hit(&mut probe, (p, t), asks || is_field);
                return (Some(hit), probe.counts);
            }
            t += gap * scale;
            if t > most {
                return (None, probe.counts);
            }
        }
        (None, probe.counts)
    }

    /// What a sphere at a point meets.
    fn hit(&self, probe: &mut Probe<'_>, (p, t): (Vec3, f32), by_field: bool) -> CastHit {
        let (d, g) = if by_field {
            probe.gradient(p)
        } else {
            let (d, g) = self.gradient(p.to_array());
            (d, g.into())
        };
        let normal = g.normalize_or_zero();
        // Where distances fall short of the real ones the surface is some way on.
        let walked = if by_field {
            self.of_field().walk_by(p, |q| {
                let (d, g) = probe.gradient(q);
                (d, g, true)
            })
        } else {
            self.walk(p)
        };
        let point = walked.unwrap_or(p - d * normal);
        let kept = match self.source {
            Source::Volume(argil_volume::Volume::Bricks(bricks)) if !by_field => {
                bricks.material(point, normal, self.tables().materials())
            }
            _ => None,
        };
        let material = kept.unwrap_or_else(|| probe.material(point));
        CastHit {
            t,
            point: point.to_array(),
            normal: normal.to_array(),
            material: material_of(&material),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BricksOptions, Brush, Edit, Engine, Modifier, Scene, Shape};

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
                .blend(0.02 * (i % 2) as f32);
            scene.push(brush).expect("a brush");
        }
        scene
    }

    /// Casts of spheres look at what is near, however many brushes there are, and stop where the field says.
    #[test]
    fn the_work_of_sphere_casts_is_bounded() {
        for (count, is_edited) in [(60, false), (1_000, false), (1_000, true)] {
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
            let (mut hits, mut most) = (0, [0u64; 2]);
            for i in 0..400 {
                let along = |k: u32| 6.0 * ((i * k) % 397) as f32 / 397.0 - 3.0;
                let origin = Vec3::new(along(31), 2.0, along(83));
                let turn = i as f32;
                let direction = Vec3::new(turn.cos(), -0.8, turn.sin()).normalize();
                let radius = [0.05, 0.3, 0.5][i as usize % 3];
                let (hit, counts) = query.cast(origin, direction, radius, 10.0);
                most = [0, 1].map(|k| most[k].max(counts[k]));
                let Some(hit) = hit else { continue };
                hits += 1;
                let at = |t: f32| world.distance((origin + t * direction).to_array());
                // Bricks and the field differ by a fraction of a voxel.
                let voxel = 8.0 / 192.0;
                assert!((at(hit.t) - radius).abs() < 0.6 * voxel, "{i}: {hit:?}");
                for k in 0..50 {
                    let before = at(hit.t * k as f32 / 50.0);
                    assert!(before > radius - 0.6 * voxel, "{i}: {before} {hit:?}");
                }
            }
            assert!(hits > 300, "{hits}");
            // All of it at each step would be a thousand each.
            assert!(most[1] < 300 && most[0] < 20_000, "{count}: {most:?}");
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
        scene.set_material("red", red).expect("a material");
        let solid = Brush::new(Shape::sphere(0.5)).at([1.0, 0.0, 0.0]);
        scene.push(solid.material("red")).expect("a brush");
        scene
            .push(Brush::new(Shape::sphere(0.5)).at([-1.0, 0.0, 0.0]))
            .expect("a brush");
        let world = Engine::cpu().build(&scene);
        let world = world.and_then(|world| world.bricks(256)).expect("a world");
        let near = |a: Material, b: Material| {
            let apart = |k: usize| (a.base_color[k] - b.base_color[k]).abs();
            (0..3).all(|k| apart(k) < 0.02)
        };
        for query in [world.query(), world.query_volume().expect("bricks")] {
            for (x, expected) in [(1.0, red), (-1.0, Material::default())] {
                let down = [0.0, -1.0, 0.0];
                let ray = query.ray_cast([x, 2.0, 0.0], down, 5.0).expect("a hit");
                assert!(near(ray.material, expected), "{ray:?}");
                assert!(near(query.material(ray.point), expected));
                let sphere = query
                    .sphere_cast([x, 2.0, 0.0], down, 0.2, 5.0)
                    .expect("a hit");
                assert!(near(sphere.material, expected), "{sphere:?}");
            }
        }
    }
}
