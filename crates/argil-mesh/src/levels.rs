//! Triangles from levels of detail, without cracks where voxel sizes change.
//!
//! *Theory.* The mesh is dual to the voxels (Ju et al., "Dual contouring of Hermite data", 2002): for each edge on which
//! the sign changes, a polygon joins the voxels around it, which are four of one size, or fewer and larger. Only minimal
//! edges count, those that no finer voxel divides. Two voxels that touch share the face of the smaller one. Along the
//! face's sides the sign changes an even number of times, so the polygons around it close. A voxel has one vertex for
//! each sheet of the surface (after Schaefer et al., "Manifold dual contouring", 2007): on each face, sign changes at the
//! two ends of an inside interval belong to the same sheet, for both voxels.
//!
//! *Practice.* Samples come from the field on each level, so neighbors agree about signs, whatever their size. Edges,
//! and the pairs of voxels around them, are lists that are sorted. A union-find structure joins the sheets (`sheets.rs`).
//! Vertices begin at the mean of the crossings, and move to the exact surface (`vertices.rs`).

mod edges;
mod sheets;
mod vertices;

pub use vertices::project_levels;

use crate::Mesh;
use argil_volume::Levels;
use edges::{ActiveEdge, Voxel, active_edges};
use glam::DVec3;
use sheets::Sheets;
use std::collections::HashMap;

/// A mesh of levels.
#[derive(Clone, Debug, Default)]
pub struct LevelsMesh {
    /// Positions and triangles.
    pub mesh: Mesh,
    /// The cell of each vertex: see [`argil_volume::LeafCell::cell`].
    pub cells: Vec<u32>,
    /// The edge of each vertex's voxel, in the scene's unit.
    pub voxel_sizes: Vec<f32>,
}

/// Extracts the surface of all leaves of levels. At the sides of a clipped world the mesh is open. Everywhere else each
/// edge of the mesh has two triangles.
pub fn mesh_levels(levels: &Levels) -> LevelsMesh {
    let edges = active_edges(levels);
    let mut sheets = Sheets::new(levels, &edges);
    let mut vertices = Vertices::default();
    let mut vertex_of = vec![u32::MAX; 4 * edges.len()];
    for (i, edge) in edges.iter().enumerate() {
        for (k, &voxel) in edge.around.iter().enumerate() {
            let root = sheets.root(4 * i + k);
            if vertex_of[root] == u32::MAX {
                vertex_of[root] = vertices.add(voxel);
            }
            vertices.sum(vertex_of[root], edge.crossing());
        }
    }
    // Vertices between two others, for polygons that would share an edge with two more.
    let mut between = HashMap::new();
    for seam in sheets.double_seams() {
        let [one, other] = seam.edges.map(|i| &edges[i as usize]);
        let voxels = seam.places[0].map(|place| one.around[usize::from(place)]);
        let vertex = vertices.add(voxels[usize::from(voxels[1].level() < voxels[0].level())]);
        vertices.sum(vertex, one.crossing());
        vertices.sum(vertex, other.crossing());
        for (edge, [a, b]) in seam.edges.into_iter().zip(seam.places) {
            let side = if (a + 1) % 4 == b { a } else { b };
            between.insert(4 * edge + u32::from(side), vertex);
        }
    }
    let mut triangles = Vec::new();
    let mut polygon = Vec::new();
    for (i, edge) in edges.iter().enumerate() {
        polygon.clear();
        let mut is_divided = false;
        for k in 0..4 {
            let corner = vertex_of[sheets.root(4 * i + k)];
            if polygon.last() != Some(&corner) {
                polygon.push(corner);
            }
            if let Some(&vertex) = between.get(&((4 * i + k) as u32)) {
                is_divided = true;
                polygon.push(vertex);
            }
        }
        if polygon.first() == polygon.last() {
            polygon.pop();
        }
        if !edge.begins_inside {
            polygon.reverse();
        }
        triangulate(edge, &polygon, is_divided, &mut vertices, &mut triangles);
    }
    vertices.finish(levels, triangles)
}

/// Divides a polygon into triangles. No edge between them belongs to another polygon. `is_divided`: whether it has
/// vertices between those of voxels.
fn triangulate(
    edge: &ActiveEdge,
    polygon: &[u32],
    is_divided: bool,
    vertices: &mut Vertices,
    triangles: &mut Vec<[u32; 3]>,
) {
    match *polygon {
        [a, b, c] => triangles.push([a, b, c]),
        [a, b, c, d] if !is_divided => {
            // Two voxels that are both larger than the edge touch along others, too.
            let [unique_ac, unique_bd] = [[a, c], [b, d]]
                .map(|ends| ends.iter().any(|&end| vertices.level(end) == edge.level));
            let is_shorter = vertices.distance(a, c) <= vertices.distance(b, d);
            triangles.extend(if unique_ac && (is_shorter || !unique_bd) {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
        _ => {
            let middle = vertices.add(edge.voxel());
            vertices.sum(middle, edge.crossing());
            for (i, &corner) in polygon.iter().enumerate() {
                triangles.push([corner, polygon[(i + 1) % polygon.len()], middle]);
            }
        }
    }
}

/// Vertices at means of points.
#[derive(Default)]
struct Vertices {
    voxels: Vec<Voxel>,
    sums: Vec<(DVec3, f64)>,
}

impl Vertices {
    fn add(&mut self, voxel: Voxel) -> u32 {
        self.voxels.push(voxel);
        self.sums.push((DVec3::ZERO, 0.0));
        self.voxels.len() as u32 - 1
    }

    fn sum(&mut self, vertex: u32, point: DVec3) {
        let (sum, count) = &mut self.sums[vertex as usize];
        *sum += point;
        *count += 1.0;
    }

    fn level(&self, vertex: u32) -> u32 {
        self.voxels[vertex as usize].level()
    }

    /// Returns a point in voxels of level 0.
    fn mean(&self, vertex: u32) -> DVec3 {
        let (sum, count) = self.sums[vertex as usize];
        sum / count
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        self.mean(a).distance_squared(self.mean(b))
    }

    fn finish(self, levels: &Levels, triangles: Vec<[u32; 3]>) -> LevelsMesh {
        let finest = f64::from(levels.layout().finest_grid().voxel_size);
        let size = |voxel: &Voxel| (finest * f64::from(1u32 << voxel.level())) as f32;
        let all = 0..self.sums.len() as u32;
        LevelsMesh {
            cells: self.voxels.iter().map(|voxel| voxel.cell()).collect(),
            voxel_sizes: self.voxels.iter().map(size).collect(),
            mesh: Mesh {
                positions: all.map(|i| levels.point_at(self.mean(i))).collect(),
                triangles,
                ..Mesh::default()
            },
        }
    }
}
