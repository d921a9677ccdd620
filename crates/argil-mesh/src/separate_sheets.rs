//! Separates parts of a surface that share edges or vertices.
//!
//! *Theory.* Two closed sheets that touch along an edge give it four triangles. They become two pairs, between which the
//! surface runs on (Guéziec et al., "Converting sets of polygons to manifold surfaces by cutting and stitching", 1998).
//! Around a vertex, triangles that are joined by pairs share one copy of it. If both ends of such an edge keep one copy,
//! the pairs share the edge still: each gets a vertex in the middle.
//!
//! *Practice.* Around an edge, triangles are sorted by angle. A pair encloses a wedge of the solid, as brackets do.

use crate::Mesh;
use glam::Vec3;
use std::collections::HashMap;

/// A side of a triangle: the vertices at its ends, the lower first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HalfEdge {
    ends: [u32; 2],
    /// Three times the triangle, plus the corner at which it begins.
    corner: u32,
}

/// Returns the corner after one, in the same triangle.
fn next(corner: u32) -> u32 {
    corner - corner % 3 + (corner + 1) % 3
}

/// Returns a closed mesh whose edges have two triangles each, and whose vertices have one fan each. Vertices and
/// triangles are added where that was not so. Nothing moves.
pub(crate) fn separate_sheets(mesh: Mesh) -> Mesh {
    let mut sides: Vec<HalfEdge> = (0u32..)
        .zip(mesh.triangles.as_flattened())
        .map(|(corner, &a)| {
            let b = mesh.triangles.as_flattened()[next(corner) as usize];
            let ends = [a.min(b), a.max(b)];
            HalfEdge { ends, corner }
        })
        .collect();
    sides.sort_unstable();
    let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(sides.len() / 2);
    // The pairs of edges with several.
    let mut crowded = Vec::new();
    for edge in sides.chunk_by(|a, b| a.ends == b.ends) {
        let first = pairs.len();
        match edge {
            [a, b] => pairs.push([a.corner, b.corner]),
            _ => pair_by_angle(&mesh, edge, &mut pairs),
        }
        if pairs.len() > first + 1 {
            crowded.push(first..pairs.len());
        }
    }
    let mut out = with_fans(&mesh, &pairs);
    let mut middles = HashMap::new();
    for range in crowded {
        let corners = out.triangles.as_flattened();
        let ends = |&[a, _]: &[u32; 2]| {
            let (a, b) = (corners[a as usize], corners[next(a) as usize]);
            [a.min(b), a.max(b)]
        };
        let all = &pairs[range];
        for (i, pair) in all.iter().enumerate() {
            if all[..i].iter().any(|other| ends(other) == ends(pair)) {
                middles.insert(pair[0], pair[1]);
            }
        }
    }
    divide(&mut out, &middles);
    out
}

/// Pairs the sides at an edge, so that each pair encloses a part of the solid. What has no partner stays open.
fn pair_by_angle(mesh: &Mesh, edge: &[HalfEdge], pairs: &mut Vec<[u32; 2]>) {
    let corners = mesh.triangles.as_flattened();
    let place = |corner: u32| mesh.positions[corners[corner as usize] as usize];
    let [low, high] = edge[0].ends.map(|i| mesh.positions[i as usize]);
    let (u, v) = (high - low).normalize_or(Vec3::X).any_orthonormal_pair();
    let mut around: Vec<(f32, bool, u32)> = edge
        .iter()
        .map(|side| {
            let to_third = place(next(next(side.corner))) - low;
            let angle = f32::atan2(to_third.dot(v), to_third.dot(u));
            let is_forward = corners[side.corner as usize] == side.ends[0];
            (angle, is_forward, side.corner)
        })
        .collect();
    around.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    // Twice around, for pairs that begin before the first.
    let mut open: Vec<u32> = Vec::new();
    let mut is_paired = vec![false; around.len()];
    for i in (0..around.len()).chain(0..around.len()) {
        let (_, is_forward, corner) = around[i];
        if is_paired[i] || open.contains(&(i as u32)) {
            continue;
        }
        if !is_forward {
            open.push(i as u32);
        } else if let Some(begin) = open.pop() {
            is_paired[i] = true;
            is_paired[begin as usize] = true;
            pairs.push([around[begin as usize].2, corner]);
        }
    }
}

/// Returns the representative of a corner in a union-find structure.
fn root(parents: &mut [u32], mut corner: u32) -> u32 {
    while parents[corner as usize] != corner {
        let above = parents[parents[corner as usize] as usize];
        parents[corner as usize] = above;
        corner = above;
    }
    corner
}

/// Gives each fan of triangles its copies of vertices. Returns the mesh with the same triangles in the same order.
fn with_fans(mesh: &Mesh, pairs: &[[u32; 2]]) -> Mesh {
    let corners = mesh.triangles.as_flattened();
    let count = corners.len() as u32;
    let mut parents: Vec<u32> = (0..count).collect();
    for &[a, b] in pairs {
        let is_turned = corners[a as usize] == corners[b as usize];
        let [c, d] = if is_turned {
            [b, next(b)]
        } else {
            [next(b), b]
        };
        for (a, b) in [(a, c), (next(a), d)] {
            let (a, b) = (root(&mut parents, a), root(&mut parents, b));
            parents[a.max(b) as usize] = a.min(b);
        }
    }
    let mut out = Mesh::default();
    let mut vertex_of = vec![u32::MAX; count as usize];
    for corner in 0..count {
        let first = root(&mut parents, corner) as usize;
        if vertex_of[first] == u32::MAX {
            vertex_of[first] = out.positions.len() as u32;
            let vertex = corners[corner as usize] as usize;
            out.positions.push(mesh.positions[vertex]);
            out.normals.extend(mesh.normals.get(vertex));
            out.materials.extend(mesh.materials.get(vertex));
        }
        vertex_of[corner as usize] = vertex_of[first];
    }
    out.triangles = vertex_of.as_chunks::<3>().0.to_vec();
    out
}

/// Puts a vertex into the middle of sides, which are given with their partners, and one into triangles at them.
fn divide(mesh: &mut Mesh, middles: &HashMap<u32, u32>) {
    let mut vertex_of: HashMap<u32, u32> = HashMap::new();
    let mut sides: Vec<[u32; 2]> = middles.iter().map(|(&a, &b)| [a, b]).collect();
    sides.sort_unstable();
    for [a, b] in sides {
        let corners = mesh.triangles.as_flattened();
        let ends = [corners[a as usize], corners[next(a) as usize]];
        let middle = mean(mesh, &ends);
        vertex_of.extend([(a, middle), (b, middle)]);
    }
    let mut triangles: Vec<u32> = vertex_of.keys().map(|corner| corner / 3).collect();
    triangles.sort_unstable();
    triangles.dedup();
    for triangle in triangles {
        let corners = mesh.triangles[triangle as usize];
        let center = mean(mesh, &corners);
        let border = (0u32..).zip(corners).flat_map(|(k, corner)| {
            let middle = vertex_of.get(&(3 * triangle + k)).copied();
            [Some(corner), middle].into_iter().flatten()
        });
        let border: Vec<u32> = border.collect();
        mesh.triangles[triangle as usize] = [border[border.len() - 1], border[0], center];
        for ends in border.windows(2) {
            mesh.triangles.push([ends[0], ends[1], center]);
        }
    }
}

/// Adds a vertex at the mean of others.
fn mean(mesh: &mut Mesh, vertices: &[u32]) -> u32 {
    let sum: Vec3 = vertices.iter().map(|&i| mesh.positions[i as usize]).sum();
    mesh.positions.push(sum / vertices.len() as f32);
    if !mesh.normals.is_empty() {
        let sum: Vec3 = vertices.iter().map(|&i| mesh.normals[i as usize]).sum();
        mesh.normals.push(sum.normalize_or_zero());
    }
    if !mesh.materials.is_empty() {
        mesh.materials.push(mesh.materials[vertices[0] as usize]);
    }
    mesh.positions.len() as u32 - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshReport;

    /// Returns a tetrahedron, turned to enclose a positive volume.
    fn tetrahedron(mesh: &mut Mesh, [a, b, c, d]: [u32; 4]) {
        let [p, q, r, s] = [a, b, c, d].map(|i| mesh.positions[i as usize]);
        let [b, c] = if (q - p).cross(r - p).dot(s - p) > 0.0 {
            [c, b]
        } else {
            [b, c]
        };
        mesh.triangles
            .extend([[a, b, c], [a, c, d], [a, d, b], [b, d, c]]);
    }

    /// Solids that share an edge, a vertex or two edges fall apart, and enclose what they did.
    #[test]
    fn solids_that_touch_are_separated() {
        let positions = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.1, 0.0],
            [1.0, 0.9, 0.5],
            [-1.0, 0.1, 0.0],
            [-1.0, -0.8, 0.4],
            [0.1, -1.0, 0.2],
            [-0.1, -1.2, 0.9],
        ];
        let mut edge = Mesh {
            positions: positions.map(Vec3::from).to_vec(),
            ..Mesh::default()
        };
        tetrahedron(&mut edge, [0, 1, 2, 3]);
        tetrahedron(&mut edge, [0, 1, 4, 5]);
        let mut three = edge.clone();
        tetrahedron(&mut three, [0, 1, 6, 7]);
        let mut vertex = edge.clone();
        vertex.triangles.truncate(4);
        tetrahedron(&mut vertex, [0, 4, 5, 6]);
        for (mesh, parts) in [(edge, 2), (three, 3), (vertex, 2)] {
            let before = MeshReport::of(&mesh);
            let after = MeshReport::of(&separate_sheets(mesh));
            assert!(after.is_watertight(), "{after:?}");
            assert_eq!(after.euler_characteristic, 2 * parts, "{after:?}");
            assert!((after.volume - before.volume).abs() < 1e-6);
        }
    }

    /// Around both ends of an edge, the surface is whole: the edge is divided.
    #[test]
    fn an_edge_whose_ends_stay_whole_is_divided() {
        let mut mesh = Mesh {
            positions: [
                [0.0, 0.0, -1.0],
                [0.0, 0.0, 1.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [-1.0, 0.0, 0.0],
                [0.0, -1.0, 0.0],
                [0.0, 0.0, -2.0],
                [0.0, 0.0, 2.0],
            ]
            .map(Vec3::from)
            .to_vec(),
            ..Mesh::default()
        };
        // Two opposite wedges share the axis. Caps above and below join them around both ends.
        let mut solids = vec![[0, 1, 2, 3], [0, 1, 4, 5]];
        for (end, tip) in [(0, 6), (1, 7)] {
            solids.extend([
                [end, tip, 2, 3],
                [end, tip, 3, 4],
                [end, tip, 4, 5],
                [end, tip, 5, 2],
            ]);
        }
        for solid in solids {
            tetrahedron(&mut mesh, solid);
        }
        // Faces between two of the solids are inside.
        let key = |triangle: &[u32; 3]| {
            let mut key = *triangle;
            key.sort_unstable();
            key
        };
        let all = mesh.triangles.clone();
        let is_outside =
            |one: &[u32; 3]| all.iter().filter(|&other| key(other) == key(one)).count() == 1;
        mesh.triangles.retain(is_outside);
        let before = MeshReport::of(&mesh);
        // The axis, and twice where the caps touch.
        assert_eq!(before.non_manifold_edges, 3, "{before:?}");
        let after = MeshReport::of(&separate_sheets(mesh));
        assert!(after.is_watertight(), "{after:?}");
        assert!(after.triangles > before.triangles, "{after:?}");
        assert!((after.volume - before.volume).abs() < 1e-6);
    }
}
