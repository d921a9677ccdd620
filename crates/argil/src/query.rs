//! Queries about a world's surface.
//!
//! *Theory.* A distance d with Lipschitz constant L leaves a sphere of radius |d| / L around a point free. Rays and
//! moving spheres step from free sphere to free sphere (sphere tracing, Hart 1996). Boxes are halved until each is
//! free, solid, or as small as the tolerance (interval search, Duff 1992).

mod closest;

use crate::World;
use crate::probe::{Probe, material_of};
use argil_abi::{Instruction, WORLD_LIMIT};
use argil_field::{Evaluator, LANES, Program};
use argil_math::Aabb;
use argil_scene::Material;
use argil_volume::Volume;
use glam::Vec3;

/// Maximum steps of a projection to the surface.
const WALK_STEPS: usize = 64;
/// Maximum boxes that a search for the closest point examines.
pub const MAX_BOXES: usize = 1 << 16;

/// A point of the surface near another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The point on the surface.
    pub point: [f32; 3],
    /// Its distance in the scene's unit.
    pub distance: f32,
    /// Whether no surface point is closer by more than 1 % of the distance. Otherwise, this is the best point found
    /// in [`MAX_BOXES`] boxes.
    pub is_nearest: bool,
}

/// The position of a box relative to the solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxPosition {
    /// No part of the box is solid.
    Outside,
    /// The surface passes through the box, or too near to tell within the tolerance.
    Intersecting,
    /// All of the box is solid.
    Inside,
}

/// What a query reads.
#[derive(Clone, Copy, Debug)]
pub(crate) enum QuerySource<'a> {
    Field,
    Volume(&'a Volume),
}

/// Queries about a world's surface, from its exact field or its stored volume.
///
/// [`World::query`] is exact. [`World::query_volume`] reads sparse bricks or a dense volume: its casts are about ten
/// times as fast, and accurate to a fraction of a voxel. Games use it for rays and moving spheres. Closest points
/// are faster in the field. A query borrows its world: other threads share it through `std::thread::scope` or an
/// `RwLock<World>`.
///
/// Creating one is free, and many threads may use it at once. In a scene of many brushes, the first query near a
/// place costs some tenths of a millisecond, and prepares a pruned program there. Up to 32 MiB of such programs are
/// kept.
///
/// ```
/// # use argil::prelude::*;
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let world = Engine::cpu().build(&scene)?.field();
/// let hit = world.query().cast_ray([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 10.0).expect("the ball");
/// assert!((hit.distance - 1.5).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Query<'a> {
    pub(crate) source: QuerySource<'a>,
    pub(crate) world: &'a World,
    /// Points nearer than this lie on the surface.
    pub(crate) epsilon: f32,
}

impl World {
    /// Returns queries that read the exact field.
    pub fn query(&self) -> Query<'_> {
        Query {
            source: QuerySource::Field,
            world: self,
            epsilon: 1e-5 * self.rough_bounds().half_diagonal().max(1e-3),
        }
    }

    /// Returns queries that read the dense volume or the sparse bricks on the CPU, or `None` if there are none.
    /// Distances are interpolated between samples. Beyond the stored band or box, they are lower bounds.
    pub fn query_volume(&self) -> Option<Query<'_>> {
        let volume = self.volume_on_cpu()?;
        volume.distance_in(volume.voxel_grid().aabb().center())?;
        Some(Query {
            source: QuerySource::Volume(volume),
            world: self,
            epsilon: Query::epsilon_of_voxel(volume.voxel_grid().voxel_size),
        })
    }
}

impl<'a> Query<'a> {
    /// Returns how near to the surface of a volume a point lies on it.
    pub(crate) fn epsilon_of_voxel(voxel_size: f32) -> f32 {
        0.01 * voxel_size
    }

    /// Returns the signed distance at a point, in the scene's unit, negative inside.
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        self.sample(&mut self.probe(), point.into()).0
    }

    /// Computes the signed distances at points into `out`.
    ///
    /// # Panics
    /// If `points` and `out` differ in length.
    pub fn distances(&self, points: &[[f32; 3]], out: &mut [f32]) {
        assert_eq!(points.len(), out.len(), "a distance for each point");
        match self.source {
            QuerySource::Field => {
                let mut evaluator = Evaluator::new(self.world.program());
                let mut d = [0.0f32; LANES];
                self.each_list(points, |list, [x, y, z], nths| {
                    let d = &mut d[..nths.len()];
                    evaluator.distances_with(list, x, y, z, d);
                    for (d, &index) in d.iter().zip(nths) {
                        out[index as usize] = *d;
                    }
                });
            }
            QuerySource::Volume(volume) => {
                for (point, out) in points.iter().zip(out) {
                    *out = stored(volume, (*point).into());
                }
            }
        }
    }

    /// Returns the distance and its gradient at a point. A volume's gradient is a difference over one voxel.
    pub fn gradient(&self, point: [f32; 3]) -> (f32, [f32; 3]) {
        let (d, g) = self.distance_and_gradient(&mut self.probe(), point.into());
        (d, g.to_array())
    }

    /// Computes the distances and gradients at points into `out`.
    ///
    /// # Panics
    /// If `points` and `out` differ in length.
    pub fn gradients(&self, points: &[[f32; 3]], out: &mut [(f32, [f32; 3])]) {
        assert_eq!(points.len(), out.len(), "a gradient for each point");
        let QuerySource::Field = self.source else {
            for (point, out) in points.iter().zip(out) {
                *out = self.gradient(*point);
            }
            return;
        };
        let mut evaluator = Evaluator::new(self.world.program());
        let (mut d, mut g) = ([0.0f32; LANES], [[0.0f32; LANES]; 3]);
        self.each_list(points, |list, points, nths| {
            let n = nths.len();
            let gradients = g.each_mut().map(|g| &mut g[..n]);
            evaluator.gradients_with(list, points, &mut d[..n], gradients);
            for (i, &index) in nths.iter().enumerate() {
                out[index as usize] = (d[i], [g[0][i], g[1][i], g[2][i]]);
            }
        });
    }

    /// Calls `visit` with groups of points that share a pruned program, and with their indices.
    fn each_list(
        &self,
        points: &[[f32; 3]],
        mut visit: impl FnMut(&[Instruction], [&[f32]; 3], &[u32]),
    ) {
        let program = self.world.program();
        let mut lanes = [[0.0f32; LANES]; 3];
        let mut visit = |list: Option<&[Instruction]>, nths: &[u32]| {
            for (i, &index) in nths.iter().enumerate() {
                for (lanes, coordinate) in lanes.iter_mut().zip(points[index as usize]) {
                    lanes[i] = coordinate;
                }
            }
            let list = list.unwrap_or(program.instructions());
            visit(list, lanes.each_ref().map(|axis| &axis[..nths.len()]), nths);
        };
        match self.world.list_tree() {
            Some(tree) => tree.each_list(program, points, visit),
            None => {
                let all: Vec<u32> = (0..points.len() as u32).collect();
                all.chunks(LANES).for_each(|nths| visit(None, nths));
            }
        }
    }

    /// Returns the data that holds for the whole scene.
    pub(crate) fn tables(&self) -> &'a Program {
        self.world.tables()
    }

    /// Returns the same queries on the exact field.
    pub(crate) fn of_field(&self) -> Self {
        Self {
            source: QuerySource::Field,
            ..*self
        }
    }

    /// Returns the material at a point of the surface, including blends. Bricks return their stored material, and
    /// other sources the field's.
    pub fn material(&self, point: [f32; 3]) -> Material {
        let p = Vec3::from(point);
        let words = match self.source {
            QuerySource::Volume(volume) => {
                let (_, outward) = self.gradient(point);
                volume.material_at(p, outward.into(), self.tables().materials())
            }
            QuerySource::Field => None,
        };
        let words = words.unwrap_or_else(|| Probe::new(self.world, 0.0).material(p));
        material_of(&words)
    }

    /// Returns a probe for distances of any length.
    fn probe(&self) -> Probe<'a> {
        Probe::new(self.world, f32::MAX)
    }

    /// Returns the distance and its gradient at a point.
    pub(crate) fn distance_and_gradient(&self, probe: &mut Probe<'_>, p: Vec3) -> (f32, Vec3) {
        match self.source {
            QuerySource::Field => probe.gradient(p),
            QuerySource::Volume(volume) => {
                let h = 0.5 * volume.voxel_grid().voxel_size;
                let along =
                    |axis: Vec3| stored(volume, p + h * axis) - stored(volume, p - h * axis);
                let g = Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * h);
                (stored(volume, p), g)
            }
        }
    }

    /// Returns the distance at a point, and whether it is exact or a lower bound.
    pub(crate) fn sample(&self, probe: &mut Probe<'_>, point: Vec3) -> (f32, bool) {
        match self.source {
            QuerySource::Field => (probe.distance(point), true),
            QuerySource::Volume(volume) => {
                let d = stored(volume, point);
                (d, Self::is_sampled(volume, point, d))
            }
        }
    }

    /// Whether a volume's value at a point is a sampled distance, and not a lower bound.
    fn is_sampled(volume: &Volume, point: Vec3, d: f32) -> bool {
        let has_samples = volume
            .distance_in(point)
            .is_some_and(|(_, is_kept)| is_kept);
        let range = volume.encoding().band_width(volume.voxel_grid(), 0);
        volume.voxel_grid().aabb().contains(point) && has_samples && d.abs() < 0.99 * range
    }

    pub(crate) fn voxel(&self) -> f32 {
        match self.source {
            QuerySource::Field => 0.0,
            QuerySource::Volume(volume) => volume.voxel_grid().voxel_size,
        }
    }

    /// Returns the error bound of distances in a box.
    fn slack(&self, held: Aabb) -> f32 {
        let between = match self.source {
            QuerySource::Field => 0.0,
            QuerySource::Volume(volume) => {
                0.87 * volume.voxel_grid().voxel_size * self.tables().lipschitz()
            }
        };
        self.tables().bound_error(held) + between
    }

    /// Follows the gradient to the surface.
    pub(crate) fn project_to_surface(&self, probe: &mut Probe<'_>, from: Vec3) -> Option<Vec3> {
        let mut p = from;
        for _ in 0..WALK_STEPS {
            let (d, g) = self.distance_and_gradient(probe, p);
            if let QuerySource::Volume(volume) = self.source
                && !Self::is_sampled(volume, p, d)
            {
                return None;
            }
            if d.abs() < self.epsilon {
                return Some(p);
            }
            let squared = g.length_squared();
            if squared < 1e-6 || !p.is_finite() {
                return None;
            }
            p -= g * (d / squared.max(0.25));
        }
        None
    }

    /// Classifies a box as outside, inside or intersecting the solid, within a tolerance in the scene's unit. If
    /// [`MAX_BOXES`] parts of it do not suffice, the result is [`BoxPosition::Intersecting`].
    #[doc(alias = "overlap")]
    #[doc(alias = "intersection test")]
    pub fn classify_box(&self, min: [f32; 3], max: [f32; 3], tolerance: f32) -> BoxPosition {
        let whole = Aabb::new(min.into(), max.into());
        // A box with NaN lies nowhere.
        if whole.is_empty() || min.iter().chain(&max).any(|c| c.is_nan()) {
            return BoxPosition::Outside;
        }
        // Only infinite solids reach beyond the world's limit.
        let whole = whole.intersection(Aabb::centered(Vec3::splat(WORLD_LIMIT)));
        if whole.is_empty() {
            return BoxPosition::Outside;
        }
        let tolerance = tolerance.max(self.epsilon);
        let mut looked_at = 0;
        let lipschitz = self.tables().lipschitz();
        let mut probe = self.probe();
        let mut open = vec![whole];
        let (mut solid, mut free) = (false, false);
        while let Some(held) = open.pop() {
            looked_at += 1;
            if looked_at > MAX_BOXES {
                return BoxPosition::Intersecting;
            }
            let center = held.center();
            let half = held.half_diagonal();
            let d = self.sample(&mut probe, center).0;
            if d.abs() > lipschitz * half + self.slack(held) {
                solid |= d < 0.0;
                free |= d >= 0.0;
            } else if half <= tolerance {
                let (d, is_told) = self.sample(&mut probe, center);
                if is_told {
                    return BoxPosition::Intersecting;
                }
                solid |= d < 0.0;
                free |= d >= 0.0;
            } else {
                let corners = held.corners().into_iter();
                open.extend(corners.map(|c| Aabb::new(c.min(center), c.max(center))));
            }
            if solid && free {
                return BoxPosition::Intersecting;
            }
        }
        if solid {
            BoxPosition::Inside
        } else {
            BoxPosition::Outside
        }
    }
}

/// Returns a volume's distance at a point. Outside its box, it is a lower bound from the nearest side.
fn stored(volume: &Volume, point: Vec3) -> f32 {
    let held = volume.voxel_grid().aabb();
    let inside = point.clamp(held.min, held.max);
    let d = volume.distance_in(inside).map_or(0.0, |(d, _)| d);
    let beside = inside.distance(point);
    if beside > 0.0 {
        beside.max(d - beside)
    } else {
        d
    }
}
