//! Dual contouring: a vertex in each cell for each loop of the surface through it, where the planes at its edges
//! meet. So edges and corners of a solid stay sharp.
//!
//! *Theory.* On each crossed edge of the grid, the exact field gives the point and the normal (Hermite data). The
//! vertex minimizes the sum of squared distances to those planes (Ju, Losasso, Schaefer, Warren 2002), without
//! directions in which they are not informative, and within its cell. A cell that the surface crosses several times
//! has several vertices (Nielson 2004; Schaefer, Ju, Warren 2007). Around each crossed edge, the vertices of four
//! cells make two triangles.
//!
//! *Practice.* Loops and points come from marching cubes over bricks. Unlike in the literature, a direction is
//! uninformative if its eigenvalue is below a tenth of the largest, and a vertex whose planes meet elsewhere moves
//! to its cell's side.

use crate::Mesh;
use crate::marching::bricks::{CellLoops, MarchedMesh};
use argil_volume::VoxelGrid;
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// Eigenvalues below this fraction of the largest are not informative.
const SINGULAR: f64 = 0.1;

/// Minimum distance of a vertex from its cell's sides, in voxels. A little outside does no harm where an edge of
/// the solid leaves the cell through a corner.
const RIM: f32 = -0.1;

/// Returns the dual mesh of a surface whose vertices were [projected](crate::project_to_field::project_to_field),
/// without normals.
pub fn contour(voxel_grid: &VoxelGrid, surface: &MarchedMesh, loops: &CellLoops) -> Mesh {
    let MarchedMesh {
        mesh,
        groups,
        edge_distances: spans,
    } = surface;
    let mut positions: Vec<Vec3> = (0..loops.cells.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|ring| {
            let planes = loops
                .of(ring)
                .iter()
                .map(|&v| (mesh.positions[v as usize], mesh.normals[v as usize]));
            let met = meet(planes);
            let first = loops.cells[ring].as_vec3();
            let low = voxel_grid.corner + voxel_grid.voxel_size * (first + RIM);
            let high = voxel_grid.corner + voxel_grid.voxel_size * (first + 1.0 - RIM);
            met.clamp(low, high)
        })
        .collect();
    let mut triangles = Vec::with_capacity(2 * mesh.positions.len());
    for group in groups {
        let mut begin = group.begin;
        for (axis, &end) in group.ends.iter().enumerate() {
            let range = begin as usize..end as usize;
            let vertices = loops.loops_around_edge[range.clone()]
                .iter()
                .zip(&spans[range.clone()]);
            for (([a, b, c, d], span), normal) in vertices.zip(&mesh.normals[range]) {
                let [a, b, c, d] = [*a, *b, *c, *d];
                // At the sides of the box, a surface is open.
                if [a, b, c, d].contains(&u32::MAX) {
                    continue;
                }
                // Once around the edge, counterclockwise as seen from outside.
                let is_out = span[0] < 0.0;
                let quad = if is_out == (axis == 1) {
                    [a, c, d, b]
                } else {
                    [a, b, d, c]
                };
                cut(&positions, quad, *normal, &mut triangles);
            }
            begin = end;
        }
    }
    edge_crossing(voxel_grid, loops, &triangles, &mut positions);
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// How far vertices at one place move toward the centers of their cells, as a fraction of the way.
const PARTING: f32 = 1e-3;

/// Moves the vertices of degenerate triangles apart, because cells that share a corner of the solid can have their
/// vertices at one place.
fn edge_crossing(
    voxel_grid: &VoxelGrid,
    loops: &CellLoops,
    triangles: &[[u32; 3]],
    positions: &mut [Vec3],
) {
    let area = |positions: &[Vec3], t: &[u32; 3]| {
        let [p, q, r] = t.map(|i| positions[i as usize]);
        (q - p).cross(r - p).length_squared()
    };
    let flat = triangles.iter().filter(|t| area(positions, t) == 0.0);
    let mut corners: Vec<u32> = flat.flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    for corner in corners {
        let cell = loops.cells[corner as usize].as_vec3() + 0.5;
        let middle = voxel_grid.corner + voxel_grid.voxel_size * cell;
        let place = &mut positions[corner as usize];
        *place = place.lerp(middle, PARTING);
    }
}

/// Cuts a quadrilateral where both triangles face as the surface does, and along an edge of the solid if there is
/// one.
fn cut(positions: &[Vec3], [a, b, c, d]: [u32; 4], normal: Vec3, out: &mut Vec<[u32; 3]>) {
    let facing = |t: [u32; 3]| {
        let [p, q, r] = t.map(|i| positions[i as usize]);
        (q - p).cross(r - p).normalize_or_zero().dot(normal)
    };
    let (one, other) = ([[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]);
    let least = |pair: [[u32; 3]; 2]| facing(pair[0]).min(facing(pair[1]));
    out.extend(if least(one) >= least(other) {
        one
    } else {
        other
    });
}

/// Returns the point nearest to some planes, and among several, the one nearest to the mean of their points.
fn meet(planes: impl Iterator<Item = (Vec3, Vec3)> + Clone) -> Vec3 {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for (p, _) in planes.clone() {
        sum += p.as_dvec3();
        count += 1.0;
    }
    let middle = sum / f64::max(count, 1.0);
    let (mut a, mut b) = (DMat3::ZERO, DVec3::ZERO);
    for (p, n) in planes {
        let n = n.as_dvec3();
        a += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        b += n * n.dot(p.as_dvec3() - middle);
    }
    let (values, vectors) = eigen(a);
    let greatest = values.max_element();
    let mut way = DVec3::ZERO;
    for k in 0..3 {
        if values[k] > SINGULAR * greatest {
            let v = vectors.col(k);
            way += v * (v.dot(b) / values[k]);
        }
    }
    (middle + way).as_vec3()
}

/// Returns eigenvalues and eigenvectors of a symmetric matrix by Jacobi rotations.
fn eigen(mut a: DMat3) -> (DVec3, DMat3) {
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a.col(q)[p];
            if off.abs() < 1e-14 {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = c;
            rotation.col_mut(q)[q] = c;
            rotation.col_mut(q)[p] = s;
            rotation.col_mut(p)[q] = -s;
            a = rotation.transpose() * a * rotation;
            vectors *= rotation;
        }
    }
    (DVec3::new(a.col(0).x, a.col(1).y, a.col(2).z), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_where_they_should() {
        let corner = Vec3::new(0.3, -0.2, 0.7);
        let planes = [Vec3::X, Vec3::Y, Vec3::new(0.0, 0.6, 0.8)];
        let crossings = planes.map(|n| (corner + n.any_orthonormal_vector() * 0.2, n));
        assert!(meet(crossings.into_iter()).distance(corner) < 1e-6);
        // Of two planes, the point on their line that is nearest to the middle; of one, its point.
        let two = [
            (Vec3::new(0.5, 0.1, 0.0), Vec3::X),
            (Vec3::new(0.1, 0.5, 0.4), Vec3::Y),
        ];
        assert!(meet(two.into_iter()).distance(Vec3::new(0.5, 0.5, 0.2)) < 1e-6);
        let one = [(Vec3::ONE, Vec3::Z), (Vec3::new(0.0, 0.0, 1.0), Vec3::Z)];
        assert!(meet(one.into_iter()).distance(Vec3::new(0.5, 0.5, 1.0)) < 1e-6);
    }
}
