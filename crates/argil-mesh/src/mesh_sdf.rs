//! Signed distances to triangles.
//!
//! *Theory.* The nearest triangle is found in a tree of boxes; whether a point is inside, by how often the surface winds
//! around it (Jacobson, Kavan, Sorkine-Hornung 2013), where what is far counts as one small plate in the middle of its
//! triangles (Barill, Dickson, Schmidt, Levin, Jacobson 2018). More than half of a turn is inside, so that parts may cross one
//! another.
//!
//! *Practice.* Leaves hold up to [`tree::WIDE`] triangles side by side, so that all are measured at once.

mod block;
mod sample;
mod tree;

use crate::repair::{RepairReport, repair};
use crate::{Mesh, MeshReadError};
use argil_math::Aabb;
use glam::Vec3;
use multiversion::multiversion;
use rayon::prelude::*;
use tree::Bvh;

/// The longest side of a solid's box: squares of squares of its triangles' sides are numbers still.
const SHORTEST: f32 = 1e-4;
const LONGEST: f32 = 1e5;

/// A solid whose surface is made of triangles.
#[derive(Debug)]
pub struct MeshSdf {
    /// The triangles that are between inside and outside.
    surface: Bvh,
    /// All of them, which tell what is inside, where some are not of the surface: parts that lie within others.
    all: Option<Bvh>,
    aabb: Aabb,
    repairs: RepairReport,
}

impl MeshSdf {
    /// Of triangles, which are repaired first.
    ///
    /// # Errors
    /// If none is left that has an area, or their box is too small or large to be measured in single precision.
    pub fn new(mesh: &Mesh) -> Result<Self, MeshReadError> {
        let (mesh, repairs) = repair(mesh);
        if mesh.triangles.is_empty() {
            let held = Aabb::around([
                Vec3::from_slice(&repairs.sheet_box),
                Vec3::from_slice(&repairs.sheet_box[3..]),
            ]);
            return Err(if repairs.sheets > 0 {
                MeshReadError::Sheets {
                    size: held.size().max_element(),
                }
            } else {
                MeshReadError::Nothing
            });
        }
        // Corners of what was left out do not count.
        let bounds =
            Aabb::around((0..mesh.triangles.len()).flat_map(|i| mesh.triangle_vertices(i)));
        let size = bounds.size().max_element();
        let away = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !(SHORTEST..=LONGEST).contains(&size) || away > LONGEST {
            return Err(MeshReadError::Extent { size, away });
        }
        let mut tree = Bvh::new(
            (0..mesh.triangles.len())
                .map(|i| mesh.triangle_vertices(i))
                .collect(),
        );
        let mut all = None;
        // Parts can lie within others, or reach into them.
        if repairs.parts > 1 {
            let reach = 1e-5 * size;
            let outer: Vec<[Vec3; 3]> = tree
                .corners
                .par_iter()
                .filter(|corners| tree.is_surface(corners, reach))
                .copied()
                .collect();
            if !outer.is_empty() && outer.len() < tree.corners.len() {
                all = Some(std::mem::replace(&mut tree, Bvh::new(outer)));
            }
        }
        Ok(Self {
            surface: tree,
            all,
            aabb: bounds,
            repairs,
        })
    }

    /// The box around it.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// What was done to its triangles.
    pub fn repairs(&self) -> &RepairReport {
        &self.repairs
    }

    /// Triangles, those that close holes included.
    pub fn triangles(&self) -> usize {
        self.all.as_ref().unwrap_or(&self.surface).corners.len()
    }

    /// How often the surface winds around a point.
    pub fn winding_number(&self, p: Vec3) -> f64 {
        self.all.as_ref().unwrap_or(&self.surface).winding(p)
    }

    /// The signed distance at a point.
    pub fn distance(&self, p: Vec3) -> f32 {
        let mut out = [0.0];
        self.distances(&[p], &mut out);
        out[0]
    }

    /// The signed distances of points; the nearer each is to the one before, the faster.
    ///
    /// # Panics
    /// If there is no place for each.
    pub fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        assert_eq!(points.len(), out.len(), "a distance for each point");
        measure(self, points, out);
    }

    #[inline(always)]
    fn measure(&self, points: &[Vec3], out: &mut [f32]) {
        let mut stack = Vec::with_capacity(64);
        let mut before: Option<(Vec3, f32)> = None;
        let mut leaf = 0;
        for (&p, out) in points.iter().zip(out) {
            let way = before.map_or(f32::INFINITY, |(q, _)| p.distance(q));
            let (d, near) = self.surface.nearest(p, leaf, &mut stack);
            leaf = near;
            let is_in = match before {
                // Both lie in balls that no surface is in, and those touch.
                Some((_, last)) if last.abs() + d > way * 1.0001 => last < 0.0,
                _ => self.winding_number(p) > 0.5,
            };
            *out = if is_in { -d } else { d };
            before = Some((p, *out));
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure(solid: &MeshSdf, points: &[Vec3], out: &mut [f32]) {
    solid.measure(points, out);
}
