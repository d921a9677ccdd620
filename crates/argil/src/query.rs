//! Asking a world where its surface is.
//!
//! *Theory.* A distance that changes by at most L over a length of 1 leaves a ball of |d| / L around a point free: rays and
//! balls go from ball to ball (sphere tracing, Hart 1996), and boxes are halved until each is free, solid or as small as
//! was asked for (interval search, Duff 1992).

use crate::World;
use argil_field::{Evaluator, LANES, Program};
use argil_math::Aabb;
use argil_volume::Volume;
use glam::Vec3;

/// Steps of a cast, and of a walk to the surface.
const MOST_STEPS: usize = 4096;
const WALK_STEPS: usize = 64;
/// Boxes that a search for a closest point looks at, at most.
pub const MOST_BOXES: usize = 1 << 16;

/// Where a cast has met the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// How far the ray, or the ball's centre, has come.
    pub t: f32,
    /// The point of the surface.
    pub point: [f32; 3],
    /// The unit normal there, out of the solid; zero where the field has none.
    pub normal: [f32; 3],
}

/// A point of the surface that is near to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The point of the surface.
    pub point: [f32; 3],
    /// How far it is.
    pub distance: f32,
    /// Whether it is known that none is nearer by more than a hundredth of the distance. Otherwise it is the best that was found
    /// among [`MOST_BOXES`] boxes.
    pub is_nearest: bool,
}

/// How a box lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// No part of it is solid.
    Outside,
    /// The surface goes through it, or so near to it that the tolerance does not tell.
    Touching,
    /// All of it is solid.
    Inside,
}

/// What is asked.
#[derive(Clone, Copy)]
enum Source<'a> {
    Field(&'a Program),
    Volume(&'a Volume),
}

/// Questions about the surface of a world, of its exact field or of the volume that is kept of it. Cheap to make, and to be
/// used from any number of threads at once; an edit waits until they are done.
///
/// ```
/// # use argil::{Brush, Engine, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let world = Engine::cpu().build(&scene)?;
/// let hit = world.query().ray_cast([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0).expect("the ball");
/// assert!((hit.t - 1.5).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Query<'a> {
    source: Source<'a>,
    program: &'a Program,
    /// Nearer than this is on the surface.
    epsilon: f32,
}

impl World {
    /// Questions to the exact field.
    pub fn query(&self) -> Query<'_> {
        Query {
            source: Source::Field(self.program()),
            program: self.program(),
            epsilon: 1e-5 * self.focus().half_diagonal().max(1e-3),
        }
    }

    /// Questions to the dense volume or the sparse bricks that are kept on the CPU: what they tell between their samples, and
    /// of what is beyond their band or box that it is not nearer. Nothing of a world that is kept in another way.
    pub fn query_volume(&self) -> Option<Query<'_>> {
        let volume = self.volume_on_cpu()?;
        if matches!(volume, Volume::Octree(_)) {
            return None;
        }
        Some(Query {
            source: Source::Volume(volume),
            program: self.program(),
            epsilon: 0.01 * volume.lattice().voxel,
        })
    }
}

impl Query<'_> {
    /// The signed distance at a point, negative inside.
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        let mut out = [0.0];
        self.distances(&[point], &mut out);
        out[0]
    }

    /// The signed distances at points.
    ///
    /// # Panics
    /// If there are not as many places in `out`.
    pub fn distances(&self, points: &[[f32; 3]], out: &mut [f32]) {
        assert_eq!(points.len(), out.len(), "a distance for each point");
        match self.source {
            Source::Field(program) => {
                let mut evaluator = Evaluator::new(program);
                let mut lanes = [[0.0f32; LANES]; 3];
                for (points, out) in points.chunks(LANES).zip(out.chunks_mut(LANES)) {
                    for (i, point) in points.iter().enumerate() {
                        for axis in 0..3 {
                            lanes[axis][i] = point[axis];
                        }
                    }
                    let n = points.len();
                    let [x, y, z] = &lanes;
                    evaluator.distances(&x[..n], &y[..n], &z[..n], out);
                }
            }
            Source::Volume(volume) => {
                for (point, out) in points.iter().zip(out) {
                    *out = stored(volume, (*point).into());
                }
            }
        }
    }

    /// The distance and its gradient at a point; of a volume by differences over a voxel.
    pub fn gradient(&self, point: [f32; 3]) -> (f32, [f32; 3]) {
        match self.source {
            Source::Field(program) => {
                let (d, g) = program.gradient(point.into());
                (d, g.to_array())
            }
            Source::Volume(volume) => {
                let (p, h) = (Vec3::from(point), 0.5 * volume.lattice().voxel);
                let along =
                    |axis: Vec3| stored(volume, p + h * axis) - stored(volume, p - h * axis);
                let g = Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * h);
                (stored(volume, p), g.to_array())
            }
        }
    }

    /// The distances and gradients at points.
    ///
    /// # Panics
    /// If there are not as many places in `out`.
    pub fn gradients(&self, points: &[[f32; 3]], out: &mut [(f32, [f32; 3])]) {
        assert_eq!(points.len(), out.len(), "a gradient for each point");
        let Source::Field(program) = self.source else {
            for (point, out) in points.iter().zip(out) {
                *out = self.gradient(*point);
            }
            return;
        };
        let mut evaluator = Evaluator::new(program);
        let mut lanes = [[0.0f32; LANES]; 3];
        let (mut d, mut g) = ([0.0f32; LANES], [[0.0f32; LANES]; 3]);
        for (points, out) in points.chunks(LANES).zip(out.chunks_mut(LANES)) {
            let n = points.len();
            for (i, point) in points.iter().enumerate() {
                for axis in 0..3 {
                    lanes[axis][i] = point[axis];
                }
            }
            let [x, y, z] = &lanes;
            let [gx, gy, gz] = &mut g;
            let gradients = [&mut gx[..n], &mut gy[..n], &mut gz[..n]];
            evaluator.gradients(&x[..n], &y[..n], &z[..n], &mut d[..n], gradients);
            for (i, out) in out.iter_mut().enumerate() {
                *out = (d[i], [g[0][i], g[1][i], g[2][i]]);
            }
        }
    }

    /// Where a ray meets the surface first, within a length; from inside of a solid, where it leaves it. The direction need
    /// not be a unit vector, lengths are the world's. Nothing for a direction of no length, or what is not finite.
    pub fn ray_cast(&self, origin: [f32; 3], direction: [f32; 3], most: f32) -> Option<CastHit> {
        self.cast(origin.into(), direction.into(), 0.0, most)
    }

    /// Where a ball of a radius that moves along a ray meets the surface from outside; `t` is 0 where it touches it already.
    pub fn sphere_cast(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        radius: f32,
        most: f32,
    ) -> Option<CastHit> {
        let is_ball = radius.is_finite() && radius >= 0.0;
        is_ball
            .then(|| self.cast(origin.into(), direction.into(), radius, most))
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

    fn cast(&self, origin: Vec3, direction: Vec3, radius: f32, most: f32) -> Option<CastHit> {
        let direction = direction.try_normalize()?;
        if !origin.is_finite() || most.is_nan() {
            return None;
        }
        let scale = 1.0 / self.program.lipschitz();
        let first = self.tell(origin).0;
        let side = if first < 0.0 && radius == 0.0 {
            -1.0
        } else {
            1.0
        };
        let mut t = 0.0f32;
        for _ in 0..MOST_STEPS {
            let p = origin + t * direction;
            let (d, is_told) = self.tell(p);
            let mut gap = side * d - radius;
            if !is_told && radius == 0.0 {
                // No surface is here, however little is known of where it is.
                t += (gap * scale).max(0.5 * self.voxel());
                if t > most {
                    return None;
                }
                continue;
            }
            // The ball reaches farther than what is stored: the field knows more.
            let asks = !is_told && gap < radius;
            let told = if asks { self.of_field() } else { *self };
            if asks {
                gap = told.distance(p.to_array()) - radius;
            }
            if gap < self.epsilon.max(2.0 * f32::EPSILON * t) {
                let (d, g) = told.gradient(p.to_array());
                let normal = Vec3::from(g).normalize_or_zero();
                // Where distances fall short of the real ones the surface is some way on.
                let point = told.walk(p).unwrap_or(p - d * normal);
                return Some(CastHit {
                    t,
                    point: point.to_array(),
                    normal: normal.to_array(),
                });
            }
            t += gap * scale;
            if t > most {
                return None;
            }
        }
        None
    }

    /// The nearest point of the surface, or the best that is found among [`MOST_BOXES`] boxes, and which of the two it is;
    /// nothing where none is found within `most`.
    pub fn closest_point(&self, point: [f32; 3], most: f32) -> Option<Closest> {
        let p = Vec3::from(point);
        if !p.is_finite() || most.is_nan() {
            return None;
        }
        let d = self.distance(point);
        let lipschitz = self.program.lipschitz();
        // The surface is not in the ball that is free; how far it is at most a walk tells, or the search goes to `most`.
        let free = d.abs() / lipschitz;
        let mut best = self.walk(p).filter(|q| q.distance(p) <= most);
        let mut reach = best.map_or(most, |q| q.distance(p));
        let bounds = self.program.aabb().grown(self.epsilon);
        if best.is_none() {
            // No farther than what there is.
            let farthest = bounds.corners().map(|c| c.distance(p));
            reach = reach.min(farthest.into_iter().fold(0.0, f32::max));
        }
        let found = |best: Option<Vec3>, is_nearest: bool| {
            best.map(|q| Closest {
                point: q.to_array(),
                distance: q.distance(p),
                is_nearest,
            })
        };
        if !reach.is_finite() || reach <= free || bounds.is_empty() {
            return found(best, reach.is_finite());
        }
        // The nearest boxes first.
        let whole = Aabb::new(p - reach, p + reach);
        let mut open = std::collections::BinaryHeap::new();
        open.push(Open(0.0, whole));
        let mut looked_at = 0;
        let mut is_nearest = true;
        while let Some(Open(nearest, held)) = open.pop() {
            if nearest >= 0.99 * reach {
                break;
            }
            if looked_at >= MOST_BOXES {
                is_nearest = false;
                break;
            }
            looked_at += 1;
            let center = held.center();
            let half = held.half_diagonal();
            let d = self.distance(center.to_array());
            if d.abs() > lipschitz * half + self.slack(held) {
                continue;
            }
            if half < 0.25 * free.max(self.epsilon)
                && let Some(q) = self.walk(center)
                && q.distance(p) < reach
            {
                reach = q.distance(p);
                best = Some(q);
            }
            if half < 0.005 * reach.max(self.epsilon) {
                continue;
            }
            for corner in held.corners() {
                let part = Aabb::new(corner.min(center), corner.max(center));
                let nearest = p.distance(p.clamp(part.min, part.max)).max(free);
                if nearest < 0.99 * reach {
                    open.push(Open(nearest, part));
                }
            }
        }
        found(best, is_nearest)
    }

    /// [`Query::closest_point`] of many points, on rayon's threads.
    pub fn closest_points(&self, points: &[[f32; 3]], most: f32) -> Vec<Option<Closest>> {
        use rayon::prelude::*;
        points
            .par_iter()
            .map(|&point| self.closest_point(point, most))
            .collect()
    }

    /// The same questions to the exact field.
    fn of_field(&self) -> Self {
        Self {
            source: Source::Field(self.program),
            ..*self
        }
    }

    /// The distance at a point, and whether that is its distance or only one that it does not fall short of.
    fn tell(&self, point: Vec3) -> (f32, bool) {
        match self.source {
            Source::Field(_) => (self.distance(point.to_array()), true),
            Source::Volume(volume) => {
                let d = stored(volume, point);
                let held = volume.lattice().aabb();
                let is_sampled = match volume {
                    Volume::Bricks(bricks) => bricks.has_brick(point),
                    _ => true,
                };
                let range = volume.encoding().range_length(volume.lattice(), 0);
                (
                    d,
                    held.contains(point) && is_sampled && d.abs() < 0.99 * range,
                )
            }
        }
    }

    fn voxel(&self) -> f32 {
        match self.source {
            Source::Field(_) => 0.0,
            Source::Volume(volume) => volume.lattice().voxel,
        }
    }

    /// What distances in a box can be off by.
    fn slack(&self, held: Aabb) -> f32 {
        let between = match self.source {
            Source::Field(_) => 0.0,
            Source::Volume(volume) => 0.87 * volume.lattice().voxel * self.program.lipschitz(),
        };
        self.program.bounds_slack(held) + between
    }

    /// Down the gradient to the surface.
    fn walk(&self, from: Vec3) -> Option<Vec3> {
        let mut p = from;
        for _ in 0..WALK_STEPS {
            if !self.tell(p).1 {
                return None;
            }
            let (d, g) = self.gradient(p.to_array());
            if d.abs() < self.epsilon {
                return Some(p);
            }
            let g = Vec3::from(g);
            let squared = g.length_squared();
            if squared < 1e-6 || !p.is_finite() {
                return None;
            }
            p -= g * (d / squared.max(0.25));
        }
        None
    }

    /// How a box lies, told to a tolerance in the world's unit.
    pub fn box_overlap(&self, min: [f32; 3], max: [f32; 3], tolerance: f32) -> Overlap {
        let whole = Aabb::new(min.into(), max.into());
        if whole.is_empty() {
            return Overlap::Outside;
        }
        let tolerance = tolerance.max(self.epsilon);
        let lipschitz = self.program.lipschitz();
        let mut open = vec![whole];
        let (mut solid, mut free) = (false, false);
        while let Some(held) = open.pop() {
            let center = held.center();
            let half = held.half_diagonal();
            let d = self.distance(center.to_array());
            if d.abs() > lipschitz * half + self.slack(held) {
                solid |= d < 0.0;
                free |= d >= 0.0;
            } else if half <= tolerance {
                let (d, is_told) = self.tell(center);
                if is_told {
                    return Overlap::Touching;
                }
                solid |= d < 0.0;
                free |= d >= 0.0;
            } else {
                let corners = held.corners().into_iter();
                open.extend(corners.map(|c| Aabb::new(c.min(center), c.max(center))));
            }
            if solid && free {
                return Overlap::Touching;
            }
        }
        if solid {
            Overlap::Inside
        } else {
            Overlap::Outside
        }
    }
}

/// A box to be looked at, by how near it is.
struct Open(f32, Aabb);

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        // The nearest is the greatest.
        other.0.total_cmp(&self.0)
    }
}

/// What a volume tells of a point; outside of its box at least what the box's side tells.
fn stored(volume: &Volume, point: Vec3) -> f32 {
    let held = volume.lattice().aabb();
    let inside = point.clamp(held.min, held.max);
    let d = match volume {
        Volume::Dense(dense) => dense.distance(0, inside).unwrap_or_default(),
        Volume::Bricks(bricks) => bricks.distance(inside),
        Volume::Octree(_) => 0.0,
    };
    let beside = inside.distance(point);
    if beside > 0.0 {
        beside.max(d - beside)
    } else {
        d
    }
}
