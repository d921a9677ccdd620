//! How far a surface reaches in a direction.
//!
//! *Theory.* A cube holds no surface if the distance at its center leaves a free ball around it. Of all cubes that may hold the
//! surface, the one that reaches farthest is cut first (branch and bound: Land and Doig, "An automatic method of solving discrete
//! programming problems", 1960).
//!
//! *Practice.* A cube is cut into 4³, which are measured at once, with the program pruned for the cube. All directions share the
//! cubes. Small ones are crossed by rays, until none reaches farther than what rays have met.

use crate::{Evaluator, Program, Pruner};
use argil_abi::Instruction;
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Parts of a cube along each axis.
const SIDE: u32 = 4;
/// How often cubes are cut: to a 64th of the box.
const DEPTH: u32 = 3;
/// The most cubes that are cut for a direction, then those that rays go through, and the steps of a ray.
const MAX_CUTS: usize = 4096;
const MAX_CROSSED: usize = 4096;
const MAX_STEPS: usize = 16;
/// Where rays go, relative to the one in the middle.
const SIDEWAYS: [[f32; 2]; 5] = [
    [0.0, 0.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [1.0, -1.0],
    [-1.0, -1.0],
];
/// How often rays come closer to the farthest point.
const ROUNDS: i32 = 4;
/// Shorter programs are not pruned.
const SHORT: usize = 6;

/// Finds how far the surface of a program reaches within a box.
///
/// ```
/// use argil_field::{Program, SurfaceReach};
/// use argil_math::Aabb;
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// // The box of a turned box is larger than what is in it.
/// scene.push(Brush::new(Shape::sphere(0.5)).rotated([0.0, 0.0, 1.0], 45.0).at([0.0, 1.0, 0.0]))?;
/// let program = Program::lower(&scene)?;
/// let mut reach = SurfaceReach::new(&program, program.aabb());
/// let top = reach.along([0.0, 1.0, 0.0].into()).expect("a surface");
/// assert!((top - 1.5).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SurfaceReach<'a> {
    program: &'a Program,
    pruner: Pruner<'a>,
    within: Aabb,
    cubes: Vec<Cube>,
}

/// A cube that may hold the surface.
#[derive(Debug)]
struct Cube {
    center: Vec3,
    half: f32,
    depth: u32,
    /// The program of the cube around it.
    around: Arc<[Instruction]>,
    /// Its parts that may hold the surface, once it is cut.
    parts: Option<Arc<[u32]>>,
}

/// A cube and how far it reaches.
struct Candidate {
    reach: f32,
    depth: u32,
    cube: u32,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        // Of two that reach as far, the smaller one.
        let by_reach = self.reach.total_cmp(&other.reach);
        by_reach.then(self.depth.cmp(&other.depth))
    }
}

/// A point where a ray meets the surface.
#[derive(Clone, Copy)]
struct Meeting {
    /// The cube whose program gave the distances there.
    cube: u32,
    point: Vec3,
    reach: f32,
}

/// Returns where five rays begin against a direction: around a point, so far apart, and so far ahead of it.
fn starts(around: Vec3, [apart, ahead]: [f32; 2], direction: Vec3) -> [Vec3; 5] {
    let way = direction.normalize_or_zero();
    let (x, y) = way
        .try_normalize()
        .unwrap_or(Vec3::X)
        .any_orthonormal_pair();
    SIDEWAYS.map(|side| around + ahead * way + apart * (side[0] * x + side[1] * y))
}

impl<'a> SurfaceReach<'a> {
    /// Prepares to search a box. An infinite or empty one has no surface.
    pub fn new(program: &'a Program, within: Aabb) -> Self {
        let half = 0.5 * within.size().max_element();
        let mut cubes = Vec::new();
        if half > 0.0 && half.is_finite() {
            cubes.push(Cube {
                center: within.center(),
                half,
                depth: 0,
                around: program.instructions().into(),
                parts: None,
            });
        }
        Self {
            program,
            pruner: Pruner::new(program),
            within,
            cubes,
        }
    }

    /// Returns the largest product of a direction and a point of the surface, to about a thousandth of the box's longest side where
    /// the surface is smooth. Parts thinner than a 64th of that side may be missed. Returns `None` if there is no surface.
    pub fn along(&mut self, direction: Vec3) -> Option<f32> {
        let mut open = BinaryHeap::new();
        open.extend((!self.cubes.is_empty()).then(|| self.candidate(0, direction)));
        let mut evaluator = Evaluator::new(self.program);
        let mut farthest: Option<Meeting> = None;
        // Where no ray meets anything, the farthest cube counts as surface.
        let mut last = None;
        let (mut cuts, mut crossed) = (0, 0);
        while crossed < MAX_CROSSED {
            let Some(best) = open.pop() else { break };
            if farthest.is_some_and(|met| best.reach <= met.reach) {
                break;
            }
            if best.depth < DEPTH && cuts < MAX_CUTS {
                cuts += 1;
                let parts = self.cut(best.cube);
                open.extend(parts.iter().map(|&part| self.candidate(part, direction)));
                continue;
            }
            crossed += 1;
            last = last.or(Some(best.reach));
            let cube = &self.cubes[best.cube as usize];
            for from in starts(cube.center, [0.5 * cube.half, cube.half], direction) {
                farthest = self.meet(&mut evaluator, best.cube, (from, direction), farthest);
            }
        }
        // Around the farthest point, closer and closer.
        for round in 1..=ROUNDS {
            let Some(met) = farthest else { break };
            let half = self.cubes[met.cube as usize].half;
            let apart = 0.5 * half * 0.5f32.powi(round);
            for from in starts(met.point, [apart, 0.5 * half], direction) {
                farthest = self.meet(&mut evaluator, met.cube, (from, direction), farthest);
            }
        }
        farthest.map(|met| met.reach).or(last)
    }

    /// Follows a ray through a cube. Returns where it meets the surface, if that is farther than what was met before.
    fn meet(
        &self,
        evaluator: &mut Evaluator<'_>,
        cube: u32,
        (from, direction): (Vec3, Vec3),
        before: Option<Meeting>,
    ) -> Option<Meeting> {
        let crossed = &self.cubes[cube as usize];
        let way = direction.normalize_or_zero();
        let mut t = 0.0;
        for _ in 0..MAX_STEPS {
            let point = from - t * way;
            let mut d = [0.0];
            evaluator.distances_with(&crossed.around, &[point.x], &[point.y], &[point.z], &mut d);
            if d[0] <= 1e-3 * crossed.half {
                let reach = point.dot(direction);
                let met = Meeting { cube, point, reach };
                return Some(before.filter(|other| other.reach >= reach).unwrap_or(met));
            }
            t += d[0] / self.program.lipschitz();
            if t > 2.0 * crossed.half {
                break;
            }
        }
        before
    }

    fn candidate(&self, cube: u32, direction: Vec3) -> Candidate {
        let end = direction.cmpge(Vec3::ZERO);
        let end = Vec3::select(end, self.within.max, self.within.min).dot(direction);
        let Cube {
            center,
            half,
            depth,
            ..
        } = self.cubes[cube as usize];
        let reach = center.dot(direction) + half * direction.abs().element_sum();
        Candidate {
            reach: reach.min(end),
            depth,
            cube,
        }
    }

    /// Returns the box of the surface. Empty if there is none.
    pub fn aabb(&mut self) -> Aabb {
        let mut surface = Aabb::EMPTY;
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let (Some(high), Some(low)) = (self.along(axis), self.along(-axis)) else {
                return Aabb::EMPTY;
            };
            surface.max = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(high), surface.max);
            surface.min = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(-low), surface.min);
        }
        surface
    }

    /// Returns the parts of a cube that may hold the surface.
    fn cut(&mut self, cube: u32) -> Arc<[u32]> {
        let Cube {
            center,
            half,
            depth,
            around,
            parts,
        } = &self.cubes[cube as usize];
        if let Some(parts) = parts {
            return parts.clone();
        }
        let (center, half, depth) = (*center, *half, *depth + 1);
        let mut list = around.clone();
        if list.len() > SHORT && depth > 1 {
            let radius = half * 3f32.sqrt();
            let mut pruned = Vec::new();
            self.pruner
                .classify_cells(&list, &[center], radius, &mut [0.0]);
            self.pruner.prune_into(&list, 0, &mut pruned);
            if pruned.len() < list.len() {
                list = pruned.into();
            }
        }
        let part = half / SIDE as f32;
        let corner = center - half + part;
        let centers: [Vec3; (SIDE * SIDE * SIDE) as usize] = std::array::from_fn(|index| {
            let index = index as u32;
            let place = UVec3::new(index, index / SIDE, index / (SIDE * SIDE)) % SIDE;
            corner + 2.0 * part * place.as_vec3()
        });
        let mut distances = [0.0; (SIDE * SIDE * SIDE) as usize];
        let radius = part * 3f32.sqrt();
        self.pruner
            .classify_cells(&list, &centers, radius, &mut distances);
        let region = Aabb::new(center - half, center + half);
        let clear = self.program.clearance_model(region);
        let first = self.cubes.len() as u32;
        for (center, distance) in centers.into_iter().zip(distances) {
            let bounds = Aabb::new(center - part, center + part);
            if bounds.intersection(self.within).is_empty() {
                continue;
            }
            // The smallest cubes need not be safe: what jumps is not near all of them.
            let may_hold = if depth == DEPTH {
                distance.abs() <= clear.steepness * radius
            } else {
                clear.radius(distance.abs()) <= radius
            };
            if may_hold {
                self.cubes.push(Cube {
                    center,
                    half: part,
                    depth,
                    around: list.clone(),
                    parts: None,
                });
            }
        }
        let parts: Arc<[u32]> = (first..self.cubes.len() as u32).collect();
        self.cubes[cube as usize].parts = Some(parts.clone());
        parts
    }
}
