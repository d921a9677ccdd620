//! Signed distances to triangles.

mod block;
mod leaf;
mod sample;
mod tree;

use crate::nearest::NearestSearch;
use crate::repair::{RepairReport, repair};
use crate::{Mesh, MeshReadError};
use argil_math::Aabb;
use glam::Vec3;
use multiversion::multiversion;
use rayon::prelude::*;
use tree::Bvh;

/// Minimum of the longest side of a box: fourth powers of its triangles' sides must not underflow.
const MIN_SIZE: f32 = 1e-4;
const MAX_SIZE: f32 = 1e5;

/// Points that a thread measures at once.
const CHUNK: usize = 1024;

/// Signed distances to a triangle mesh.
///
/// *Theory.* A tree of boxes finds the nearest triangle. A point is inside if the surface winds around it
/// (Jacobson, Kavan, Sorkine-Hornung 2013), where distant triangles count as one small plate (Barill, Dickson,
/// Schmidt, Levin, Jacobson 2018). More than half a turn is inside, so parts may intersect.
///
/// *Practice.* Leaves contain up to eight triangles side by side, which are measured at once.
#[derive(Debug)]
#[doc(alias = "voxelize")]
#[doc(alias = "mesh to level set")]
pub struct MeshSdf {
    /// The triangles between inside and outside.
    surface: Bvh,
    /// All triangles, which determine the inside, if some are not part of the surface because they lie within
    /// others.
    all: Option<Bvh>,
    aabb: Aabb,
    repairs: RepairReport,
}

impl MeshSdf {
    /// Repairs triangles and prepares distances to them.
    ///
    /// # Errors
    /// If no triangle with an area is left, or their box is too small or too large for single precision.
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
                MeshReadError::NoTriangles
            });
        }
        // Vertices of dropped triangles do not count.
        let bounds =
            Aabb::around((0..mesh.triangles.len()).flat_map(|i| mesh.triangle_vertices(i)));
        let size = bounds.size().max_element();
        let away = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !(MIN_SIZE..=MAX_SIZE).contains(&size) || away > MAX_SIZE {
            return Err(MeshReadError::Extent { size, away });
        }
        let mut tree = Bvh::new(
            (0..mesh.triangles.len())
                .map(|i| mesh.triangle_vertices(i))
                .collect(),
        );
        let mut all = None;
        // Parts can lie within others, or intersect them.
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

    /// Returns the box of the triangles.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// Returns what was repaired.
    pub fn repairs(&self) -> &RepairReport {
        &self.repairs
    }

    /// Returns the number of triangles, including those that close holes.
    pub fn triangles(&self) -> usize {
        self.all.as_ref().unwrap_or(&self.surface).corners.len()
    }

    /// Returns the winding number of the surface around a point.
    pub fn winding_number(&self, p: Vec3) -> f64 {
        self.all.as_ref().unwrap_or(&self.surface).winding(p)
    }

    /// Returns the signed distance at a point.
    pub fn distance(&self, p: Vec3) -> f32 {
        let mut out = [0.0];
        self.distances(&[p], &mut out);
        out[0]
    }

    /// Computes the signed distances of points into `out`. It is faster if consecutive points are close together.
    ///
    /// # Panics
    /// If `points` and `out` differ in length.
    pub fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        assert_eq!(points.len(), out.len(), "a distance for each point");
        measure(self, points, out);
    }

    /// Returns the signed distances of many points, in parallel. It is faster if consecutive points are close together.
    pub fn distances_in_parallel(&self, points: &[Vec3]) -> Vec<f32> {
        let mut distances = vec![0.0; points.len()];
        let chunks = points
            .par_chunks(CHUNK)
            .zip(distances.par_chunks_mut(CHUNK));
        chunks.for_each(|(points, out)| self.distances(points, out));
        distances
    }

    #[inline(always)]
    fn measure(&self, points: &[Vec3], out: &mut [f32]) {
        let mut search = NearestSearch::new(&self.surface.nearest);
        let mut before: Option<(Vec3, f32)> = None;
        for (&p, out) in points.iter().zip(out) {
            *out = search.distance(p);
            let way = before.map_or(f32::INFINITY, |(q, _)| p.distance(q));
            let is_in = match before {
                // Both are in free spheres that touch.
                Some((_, last)) if last.abs() + *out > way * 1.0001 => last < 0.0,
                _ => self.winding_number(p) > 0.5,
            };
            if is_in {
                *out = -*out;
            }
            before = Some((p, *out));
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure(solid: &MeshSdf, points: &[Vec3], out: &mut [f32]) {
    solid.measure(points, out);
}
