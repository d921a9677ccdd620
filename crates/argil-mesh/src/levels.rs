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
use edges::active_edges;
use glam::DVec3;
use sheets::Sheets;

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

/// Extracts the surface of all leaves of levels. At the sides of a clipped world the mesh is open.
pub fn mesh_levels(levels: &Levels) -> LevelsMesh {
    let edges = active_edges(levels);
    let mut sheets = Sheets::new(levels, &edges);
    let mut out = LevelsMesh::default();
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    let mut vertex_of = vec![u32::MAX; 4 * edges.len()];
    for (nth, edge) in edges.iter().enumerate() {
        for (k, voxel) in edge.around.iter().enumerate() {
            let root = sheets.root(4 * nth + k);
            if vertex_of[root] == u32::MAX {
                vertex_of[root] = sums.len() as u32;
                sums.push((DVec3::ZERO, 0.0));
                out.cells.push(voxel.cell());
                let scale = f64::from(1u32 << voxel.level());
                let finest = f64::from(levels.layout().finest_grid().voxel_size);
                out.voxel_sizes.push((finest * scale) as f32);
            }
            let (sum, count) = &mut sums[vertex_of[root] as usize];
            *sum += edge.crossing();
            *count += 1.0;
        }
    }
    out.mesh.positions = sums
        .iter()
        .map(|(sum, count)| levels.point_at(*sum / *count))
        .collect();
    for (nth, edge) in edges.iter().enumerate() {
        let mut polygon: Vec<u32> = (0..4)
            .map(|k| vertex_of[sheets.root(4 * nth + k)])
            .collect();
        polygon.dedup();
        if polygon.len() > 1 && polygon.first() == polygon.last() {
            polygon.pop();
        }
        if !edge.begins_inside {
            polygon.reverse();
        }
        let at = |i: usize| out.mesh.positions[polygon[i] as usize];
        match polygon[..] {
            [a, b, c] => out.mesh.triangles.push([a, b, c]),
            [a, b, c, d] => {
                // The shorter diagonal.
                let is_first = at(0).distance_squared(at(2)) <= at(1).distance_squared(at(3));
                let both = if is_first {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                };
                out.mesh.triangles.extend(both);
            }
            _ => {}
        }
    }
    out
}
