//! Turns sheets into walls.

use crate::repair::{OPEN, SEVERAL, drop_doubles, drop_flat, edges, neighbors, orient, weld};
use crate::{Mesh, RepairReport};
use glam::Vec3;
use std::collections::HashMap;

/// Returns the triangles with parts that have open edges turned into walls of a thickness: each triangle twice,
/// offset by half to either side, and joined along the edges. Also returns the number of those parts.
pub fn thicken(mesh: &Mesh, thickness: f32) -> (Mesh, u64) {
    let (mut mesh, _) = weld(mesh);
    drop_flat(&mut mesh);
    drop_doubles(&mut mesh);
    let mut beside = neighbors(&mesh.triangles);
    let mut repairs = RepairReport::default();
    let part_of = orient(&mut mesh, &mut beside, &mut repairs);
    let mut is_open = vec![false; repairs.parts as usize];
    for (across, &part) in beside.iter().zip(&part_of) {
        is_open[part as usize] |= across.contains(&OPEN);
    }
    // A vertex moves along the mean normal of its part's triangles, weighted by area.
    let mut normals: HashMap<(u32, u32), Vec3> = HashMap::new();
    let open = |part: u32| is_open[part as usize];
    for (triangle, &part) in mesh
        .triangles
        .iter()
        .zip(&part_of)
        .filter(|(_, p)| open(**p))
    {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        for corner in triangle {
            *normals.entry((part, *corner)).or_default() += (b - a).cross(c - a);
        }
    }
    let mut out = Mesh {
        positions: mesh.positions.clone(),
        ..Mesh::default()
    };
    let mut corners: Vec<((u32, u32), Vec3)> = normals.into_iter().collect();
    corners.sort_unstable_by_key(|(corner, _)| *corner);
    let mut moved: HashMap<(u32, u32), [u32; 2]> = HashMap::with_capacity(corners.len());
    for ((part, corner), normal) in corners {
        let by = 0.5 * thickness * normal.normalize_or_zero();
        let at = out.positions.len() as u32;
        let from = mesh.positions[corner as usize];
        out.positions.extend([from + by, from - by]);
        moved.insert((part, corner), [at, at + 1]);
    }
    for ((triangle, across), &part) in mesh.triangles.iter().zip(&beside).zip(&part_of) {
        if !open(part) {
            out.triangles.push(*triangle);
            continue;
        }
        let [a, b, c] = triangle.map(|corner| moved[&(part, corner)]);
        out.triangles
            .extend([[a[0], b[0], c[0]], [a[1], c[1], b[1]]]);
        for ((from, to), other) in edges(*triangle).into_iter().zip(across) {
            if [OPEN, SEVERAL].contains(other) {
                let [from, to] = [from, to].map(|corner| moved[&(part, corner)]);
                out.triangles
                    .extend([[to[0], from[0], from[1]], [to[0], from[1], to[1]]]);
            }
        }
    }
    let parts = is_open.into_iter().filter(|open| *open).count() as u64;
    (out, parts)
}
