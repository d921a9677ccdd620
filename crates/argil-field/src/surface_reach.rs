//! How far a surface reaches in a direction.
//!
//! *Theory.* A cube holds no surface if the distance at its center leaves a free ball around it. Of all cubes that may hold the
//! surface, the one that reaches farthest is cut first: the first small one is the answer (branch and bound: Land and Doig, "An
//! automatic method of solving discrete programming problems", 1960).
//!
//! *Practice.* A cube is cut into 4³, which are measured at once, with the program pruned for the cube. All directions share the
//! cubes.

use crate::{Program, Pruner};
use argil_abi::Instruction;
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;

/// Parts of a cube along each axis.
const SIDE: u32 = 4;
/// How often cubes are cut: to a 4096th of the box.
const DEPTH: u32 = 6;
/// The most cubes that are cut for a direction. What is left then counts as surface.
const MAX_CUTS: usize = 4096;
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
    around: Rc<[Instruction]>,
    /// Its parts that may hold the surface, once it is cut.
    parts: Option<Rc<[u32]>>,
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

    /// Returns the largest product of a direction and a point of the surface, or a little more: up to a 4096th of the box's longest
    /// side, and more where distances are much too short. Returns `None` if there is no surface.
    pub fn along(&mut self, direction: Vec3) -> Option<f32> {
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
            let best = open.pop()?;
            if best.depth == DEPTH {
                return Some(best.reach);
            }
            let parts = self.cut(best.cube);
            open.extend(parts.iter().map(|&part| candidate(&self.cubes, part)));
        }
        open.pop().map(|best| best.reach)
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
    fn cut(&mut self, cube: u32) -> Rc<[u32]> {
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
            list = pruned.into();
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
        let parts: Rc<[u32]> = (first..self.cubes.len() as u32).collect();
        self.cubes[cube as usize].parts = Some(parts.clone());
        parts
    }
}
