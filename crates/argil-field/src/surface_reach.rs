//! How far a surface reaches in a direction.
//!
//! *Theory.* A cube holds no surface if the distance at its center leaves a free ball around it. Of all cubes that may hold the
//! surface, the one that reaches farthest is cut first: the first small one is the answer (branch and bound: Land and Doig, "An
//! automatic method of solving discrete programming problems", 1960).
//!
//! *Practice.* A cube is cut into 4³, which are measured at once, with the program pruned for the cube. All directions share the
//! cubes.

use crate::{Evaluator, Program, Pruner};
use argil_abi::Instruction;
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Parts of a cube along each axis.
const SIDE: u32 = 4;
/// How often cubes are cut: to a 4096th of the box.
const DEPTH: u32 = 6;
/// The most cubes that are cut in a search, then those that rays go through, and the steps of a ray.
const MAX_CUTS: usize = 1024;
const MAX_CROSSED: usize = 2048;
const MAX_STEPS: usize = 16;
/// Where rays go through a cube: how far from its middle, in halves of its edge.
const SIDEWAYS: [[f32; 2]; 5] = [
    [0.0, 0.0],
    [0.5, 0.5],
    [-0.5, 0.5],
    [0.5, -0.5],
    [-0.5, -0.5],
];
/// From this depth on, a second search leaves out cubes in which only a jump of the distance could hide a surface.
const NEAR_DEPTH: u32 = 2;
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
    /// Whether it may hold the surface even if no distance jumps.
    is_near: bool,
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
                is_near: true,
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

    /// Returns the largest product of a direction and a point of the surface, to about a thousandth of the box's longest side. Where
    /// the surface is nearly flat there, parts that stick out by less than a 64th of that side may be missed, and where distances
    /// are much too short, the result is larger. Returns `None` if there is no surface.
    pub fn along(&mut self, direction: Vec3) -> Option<f32> {
        let safe = self.search(direction, u32::MAX);
        let found = safe.or_else(|_| self.search(direction, NEAR_DEPTH));
        found.unwrap_or_else(|open| self.met(direction, open))
    }

    /// Returns how far the surface reaches, or, after too many cuts, the cubes that are left. From a depth on, only what is near
    /// counts.
    fn search(
        &mut self,
        direction: Vec3,
        near_depth: u32,
    ) -> Result<Option<f32>, BinaryHeap<Candidate>> {
        let end = direction.cmpge(Vec3::ZERO);
        let end = Vec3::select(end, self.within.max, self.within.min).dot(direction);
        let candidate = |cubes: &[Cube], cube: u32| {
            let own = &cubes[cube as usize];
            let reach = own.center.dot(direction) + own.half * direction.abs().element_sum();
            Candidate {
                reach: reach.min(end),
                depth: own.depth,
                cube,
            }
        };
        let mut open = BinaryHeap::new();
        open.extend((!self.cubes.is_empty()).then(|| candidate(&self.cubes, 0)));
        for _ in 0..MAX_CUTS {
            let Some(best) = open.pop() else {
                return Ok(None);
            };
            if best.depth == DEPTH {
                return Ok(Some(best.reach));
            }
            let parts = self.cut(best.cube);
            let counts = |part: &&u32| {
                let cube = &self.cubes[**part as usize];
                cube.is_near || cube.depth < near_depth
            };
            let parts = parts.iter().filter(counts);
            open.extend(parts.map(|&part| candidate(&self.cubes, part)));
        }
        Err(open)
    }

    /// Returns how far the surface reaches where rays meet it that go through cubes, some through each. A flat side crosses more cubes
    /// than can be cut.
    fn met(&self, direction: Vec3, mut open: BinaryHeap<Candidate>) -> Option<f32> {
        let last = open.peek().map(|best| best.reach);
        let mut evaluator = Evaluator::new(self.program);
        let mut farthest: Option<f32> = None;
        let way = direction.normalize_or_zero();
        let (x, y) = way
            .try_normalize()
            .unwrap_or(Vec3::X)
            .any_orthonormal_pair();
        for _ in 0..MAX_CROSSED {
            let Some(best) = open.pop() else { break };
            if farthest.is_some_and(|reach| best.reach <= reach) {
                break;
            }
            let cube = &self.cubes[best.cube as usize];
            let begin = cube.center + cube.half * way;
            for side in SIDEWAYS {
                let from = begin + cube.half * (side[0] * x + side[1] * y);
                let mut t = 0.0;
                for _ in 0..MAX_STEPS {
                    let p = from - t * way;
                    let mut d = [0.0];
                    evaluator.distances_with(&cube.around, &[p.x], &[p.y], &[p.z], &mut d);
                    if d[0] <= 1e-3 * cube.half {
                        let reach = p.dot(direction);
                        farthest = Some(farthest.map_or(reach, |other| other.max(reach)));
                        break;
                    }
                    t += d[0] / self.program.lipschitz();
                    if t > 2.0 * cube.half {
                        break;
                    }
                }
            }
        }
        // Without one that meets it, what is left counts as surface.
        farthest.or(last)
    }

    /// Returns the box of the surface. Empty if there is none.
    pub fn aabb(&mut self) -> Aabb {
        let mut own = Aabb::EMPTY;
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let (Some(high), Some(low)) = (self.along(axis), self.along(-axis)) else {
                return Aabb::EMPTY;
            };
            own.max = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(high), own.max);
            own.min = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(-low), own.min);
        }
        own
    }

    /// Returns the parts of a cube that may hold the surface.
    fn cut(&mut self, cube: u32) -> Arc<[u32]> {
        let Cube {
            center,
            half,
            depth,
            around,
            parts,
            ..
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
            let own = Aabb::new(center - part, center + part);
            if own.intersection(self.within).is_empty() {
                continue;
            }
            // The smallest cubes need not be safe: what jumps is not near all of them.
            let is_near = distance.abs() <= clear.steepness * radius;
            let may_hold = clear.radius(distance.abs()) <= radius;
            if is_near || may_hold && depth < DEPTH {
                self.cubes.push(Cube {
                    center,
                    half: part,
                    depth,
                    is_near,
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
