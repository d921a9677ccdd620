//! Repairs triangles so that they enclose a solid.

use crate::Mesh;
use argil_math::Aabb;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// What was repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RepairReport {
    /// Vertices that were merged with another at the same place.
    pub welded: u64,
    /// Triangles that were dropped: without an area, with a vertex that is not finite, or duplicates.
    pub dropped: u64,
    /// Triangles that were reversed to agree with their neighbors.
    pub flipped: u64,
    /// Parts that were turned inside out.
    pub parts_flipped: u64,
    /// Holes that were closed.
    pub holes: u64,
    /// Connected parts.
    pub parts: u64,
    /// Triangles that were dropped because a vertex is not finite. They also count in `dropped`.
    pub not_finite: u64,
    /// Parts that were dropped because they are flat and enclose nothing.
    pub sheets: u64,
    /// Minimum and maximum corner of a box around those, or zeros.
    pub sheet_box: [f32; 6],
    /// Minimum and maximum corner of a box around the closed holes, or zeros.
    pub hole_box: [f32; 6],
}

/// Formats a number of things.
fn counted(count: u64, one: &str) -> String {
    format!("{count} {one}{}", if count == 1 { "" } else { "s" })
}

impl RepairReport {
    /// Describes what a user should know: what was dropped or filled, and where. One sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let held = |[a, b, c, d, e, f]: [f32; 6]| format!("[{a}, {b}, {c}] to [{d}, {e}, {f}]");
        let mut all = Vec::new();
        if self.not_finite > 0 {
            all.push(format!(
                "dropped {} with vertices that are not finite",
                counted(self.not_finite, "triangle")
            ));
        }
        if self.sheets > 0 {
            all.push(format!(
                "dropped {} without a volume, within {}: use a thickness to keep such parts",
                counted(self.sheets, "flat part"),
                held(self.sheet_box)
            ));
        }
        if self.holes > 0 {
            all.push(format!(
                "closed {}, within {}: if thin walls are open there, use a thickness",
                counted(self.holes, "hole"),
                held(self.hole_box)
            ));
        }
        all
    }
}

/// Returns the union of two boxes, where zeros mean none.
fn joined(known: [f32; 6], held: Aabb, is_first: bool) -> [f32; 6] {
    let known = if is_first {
        Aabb::EMPTY
    } else {
        Aabb::new(Vec3::from_slice(&known), Vec3::from_slice(&known[3..]))
    };
    let all = known.union(held);
    let [a, b, c] = all.min.to_array();
    let [d, e, f] = all.max.to_array();
    [a, b, c, d, e, f]
}

/// Returns triangles that form the surface of a solid, and what was repaired.
///
/// *Practice.* Vertices at one place are merged. From the first triangle of each part, neighbors are reversed to
/// agree. Where more than two triangles meet, each stays as it is. Rings of open edges are closed by triangles over
/// half of them, a quarter, and so on. A part with negative volume is reversed, unless it lies in another, where it
/// is a cavity.
pub fn repair(mesh: &Mesh) -> (Mesh, RepairReport) {
    let mut repairs = RepairReport::default();
    let count = mesh.triangles.len();
    let (mut mesh, welded) = weld(mesh);
    repairs.not_finite = (count - mesh.triangles.len()) as u64;
    drop_flat(&mut mesh);
    drop_doubles(&mut mesh);
    repairs.welded = welded;
    repairs.dropped = (count - mesh.triangles.len()) as u64;
    let mut beside = neighbors(&mesh.triangles);
    let part_of = orient(&mut mesh, &mut beside, &mut repairs);
    let part_of = close(&mut mesh, &beside, part_of, &mut repairs);
    let part_of = drop_sheets(&mut mesh, part_of, &mut repairs);
    turn_parts(&mut mesh, &part_of, &mut repairs);
    (mesh, repairs)
}

/// Merges vertices at one place. Returns how many were merged. Triangles without an area stay, and those with a
/// vertex that is not finite are dropped.
pub(crate) fn weld(mesh: &Mesh) -> (Mesh, u64) {
    let mut places: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut out = Mesh::default();
    let mut welded = 0;
    let index: Vec<Option<u32>> = mesh
        .positions
        .iter()
        .map(|p| {
            // −0 and 0 are one place.
            let p = *p + Vec3::ZERO;
            if !p.is_finite() {
                return None;
            }
            let new = out.positions.len() as u32;
            let place = *places.entry(p.to_array().map(f32::to_bits)).or_insert(new);
            if place == new {
                out.positions.push(p);
            } else {
                welded += 1;
            }
            Some(place)
        })
        .collect();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| index.get(i as usize).copied().flatten());
        if let [Some(a), Some(b), Some(c)] = corners {
            out.triangles.push([a, b, c]);
        }
    }
    (out, welded)
}

/// Drops triangles without an area.
pub(super) fn drop_flat(mesh: &mut Mesh) {
    let Mesh {
        positions,
        triangles,
        ..
    } = mesh;
    triangles.retain(|&[a, b, c]| {
        let [p, q, r] = [a, b, c].map(|i| positions[i as usize].as_dvec3());
        a != b && b != c && c != a && (q - p).cross(r - p).length_squared() > 0.0
    });
}

/// Keeps the first of several triangles on the same three vertices, in either orientation. Files contain two-sided
/// surfaces, and a solid has one side.
pub(super) fn drop_doubles(mesh: &mut Mesh) {
    let mut all: Vec<([u32; 3], u32)> = (0..)
        .zip(&mesh.triangles)
        .map(|(i, &triangle)| {
            let mut corners = triangle;
            corners.sort_unstable();
            (corners, i)
        })
        .collect();
    all.par_sort_unstable();
    let mut keep = vec![true; mesh.triangles.len()];
    for pair in all.windows(2) {
        if pair[0].0 == pair[1].0 {
            keep[pair[1].1 as usize] = false;
        }
    }
    let mut kept = keep.into_iter();
    mesh.triangles.retain(|_| kept.next().unwrap_or(true));
}

pub(super) fn edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

fn undirected((a, b): (u32, u32)) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// No other triangle is across the edge.
pub(super) const OPEN: u32 = u32::MAX;
/// Several triangles are across the edge.
pub(super) const SEVERAL: u32 = u32::MAX - 1;

/// Returns the triangle across each edge of each triangle.
pub(super) fn neighbors(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut all: Vec<((u32, u32), u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (i, triangle) in (0..).zip(triangles) {
        for (k, edge) in (0..).zip(edges(*triangle)) {
            all.push((undirected(edge), i, k));
        }
    }
    all.par_sort_unstable();
    let mut beside = vec![[OPEN; 3]; triangles.len()];
    for run in all.chunk_by(|a, b| a.0 == b.0) {
        let mut set = |at: usize, other: u32| {
            let (_, i, k) = run[at];
            beside[i as usize][usize::from(k)] = other;
        };
        match run {
            [_] => {}
            [one, other] => {
                set(0, other.1);
                set(1, one.1);
            }
            _ => (0..run.len()).for_each(|at| set(at, SEVERAL)),
        }
    }
    beside
}

/// Makes neighbors agree. Returns the part of each triangle.
pub(super) fn orient(
    mesh: &mut Mesh,
    beside: &mut [[u32; 3]],
    repairs: &mut RepairReport,
) -> Vec<u32> {
    let mut part_of = vec![u32::MAX; mesh.triangles.len()];
    let mut parts = 0;
    for first in 0..mesh.triangles.len() {
        if part_of[first] != u32::MAX {
            continue;
        }
        part_of[first] = parts;
        let (mut todo, mut size, mut turned) = (vec![first as u32], 0u64, Vec::new());
        while let Some(i) = todo.pop() {
            size += 1;
            let across = beside[i as usize];
            for (edge, next) in edges(mesh.triangles[i as usize]).into_iter().zip(across) {
                if next == OPEN || next == SEVERAL || part_of[next as usize] != u32::MAX {
                    continue;
                }
                part_of[next as usize] = parts;
                let triangle = &mut mesh.triangles[next as usize];
                if edges(*triangle).contains(&edge) {
                    triangle.swap(1, 2);
                    beside[next as usize].swap(0, 2);
                    turned.push(next);
                }
                todo.push(next);
            }
        }
        // The smaller group was wrong.
        repairs.flipped += (turned.len() as u64).min(size - turned.len() as u64);
        parts += 1;
    }
    repairs.parts = u64::from(parts);
    part_of
}

/// Closes rings of open edges.
fn close(
    mesh: &mut Mesh,
    beside: &[[u32; 3]],
    mut part_of: Vec<u32>,
    repairs: &mut RepairReport,
) -> Vec<u32> {
    // Along a hole, the reverse of each open edge. Sorted, so that the result is reproducible.
    let mut next: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    let mut open: Vec<(u32, u32, u32)> = Vec::new();
    for ((triangle, across), &part) in mesh.triangles.iter().zip(beside).zip(&part_of) {
        for ((a, b), other) in edges(*triangle).into_iter().zip(*across) {
            if other == OPEN {
                next.entry((b, part)).or_default().push(a);
                open.push((b, a, part));
            }
        }
    }
    open.sort_unstable();
    for (from, to, part) in open {
        let mut take = |at: u32, wanted: Option<u32>| -> Option<u32> {
            let ways = next.get_mut(&(at, part))?;
            let place = ways
                .iter()
                .position(|&to| wanted.is_none_or(|wanted| wanted == to))?;
            Some(ways.swap_remove(place))
        };
        // An edge of a ring that is already closed is gone.
        let Some(mut at) = take(from, Some(to)) else {
            continue;
        };
        let mut ring = vec![from];
        while at != from {
            ring.push(at);
            match take(at, None) {
                Some(to) => at = to,
                None => break,
            }
        }
        if at == from && ring.len() > 2 {
            cap(mesh, &ring);
            let held = Aabb::around(ring.iter().map(|&i| mesh.positions[i as usize]));
            repairs.hole_box = joined(repairs.hole_box, held, repairs.holes == 0);
            part_of.resize(mesh.triangles.len(), part);
            repairs.holes += 1;
        }
    }
    part_of
}

/// Closes a ring: a triangle over its first, last and middle vertex, and so on in both halves. Few triangles are
/// long, and no vertices are added.
fn cap(mesh: &mut Mesh, ring: &[u32]) {
    let mut todo = vec![(0, ring.len() - 1)];
    while let Some((first, last)) = todo.pop() {
        if last - first < 2 {
            continue;
        }
        let middle = first.midpoint(last);
        mesh.triangles.push([ring[first], ring[middle], ring[last]]);
        todo.extend([(first, middle), (middle, last)]);
    }
}

/// Parts are flat if twice the volume over the area, the thickness of a plate, is below this fraction of their
/// size.
const FLAT: f64 = 1e-5;

/// Drops parts that enclose nothing, closed or not. Returns the part of each remaining triangle.
fn drop_sheets(mesh: &mut Mesh, part_of: Vec<u32>, repairs: &mut RepairReport) -> Vec<u32> {
    let count = repairs.parts as usize;
    let (mut volumes, mut areas) = (vec![0.0f64; count], vec![0.0f64; count]);
    let mut boxes = vec![Aabb::EMPTY; count];
    let mut origins: Vec<Option<DVec3>> = vec![None; count];
    for (triangle, &part) in mesh.triangles.iter().zip(&part_of) {
        let part = part as usize;
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        let origin = *origins[part].get_or_insert(corners[0].as_dvec3());
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
        volumes[part] += a.dot(b.cross(c)) / 6.0;
        areas[part] += 0.5 * (b - a).cross(c - a).length();
        boxes[part] = boxes[part].union(Aabb::around(corners));
    }
    let is_flat = |part: usize| {
        let size = f64::from(boxes[part].size().max_element());
        areas[part] > 0.0 && 2.0 * volumes[part].abs() < FLAT * size * areas[part]
    };
    let flat: Vec<bool> = (0..count).map(is_flat).collect();
    for (part, _) in flat.iter().enumerate().filter(|(_, is_flat)| **is_flat) {
        repairs.sheet_box = joined(repairs.sheet_box, boxes[part], repairs.sheets == 0);
        repairs.sheets += 1;
    }
    if repairs.sheets == 0 {
        return part_of;
    }
    let mut parts = part_of.iter();
    mesh.triangles
        .retain(|_| parts.next().is_none_or(|&part| !flat[part as usize]));
    let kept = part_of.into_iter().filter(|&part| !flat[part as usize]);
    kept.collect()
}

/// Reverses parts that are inside out.
fn turn_parts(mesh: &mut Mesh, part_of: &[u32], repairs: &mut RepairReport) {
    let count = repairs.parts as usize;
    let mut volumes = vec![0.0; count];
    let mut a_corner = vec![Vec3::ZERO; count];
    let mut boxes = vec![Aabb::EMPTY; count];
    let mut sizes = vec![0; count];
    let origin = mesh.aabb().center().as_dvec3();
    for (triangle, &part) in mesh.triangles.iter().zip(part_of) {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3() - origin);
        volumes[part as usize] += a.dot(b.cross(c));
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        a_corner[part as usize] = corners[0];
        boxes[part as usize] = boxes[part as usize].union(Aabb::around(corners));
        sizes[part as usize] += 1;
    }
    let mut turn = vec![false; count];
    let negative: Vec<usize> = (0..count).filter(|&part| volumes[part] < 0.0).collect();
    // Whether a part lies in others is tested one by one, but not for a mesh of very many scraps.
    let few = negative.len().saturating_mul(mesh.triangles.len()) < 1 << 28;
    let mut work = 1 << 26;
    for &part in &negative {
        let mut around = 0.0;
        // A part whose box does not hold a point is not around it.
        let can_hold = |other: usize| other != part && boxes[other].contains(a_corner[part]);
        let holds: Vec<bool> = (0..if few { count } else { 0 }).map(can_hold).collect();
        let held = holds.iter().zip(&sizes).filter(|(holds, _)| **holds);
        let triangles: usize = held.map(|(_, size)| size).sum();
        if (1..=work).contains(&triangles) {
            work -= triangles;
            let p = a_corner[part].as_dvec3();
            for (triangle, &other) in mesh.triangles.iter().zip(part_of) {
                if holds[other as usize] {
                    let corners = triangle.map(|i| mesh.positions[i as usize].as_dvec3() - p);
                    let sign = volumes[other as usize].signum();
                    around += sign * solid_angle(corners);
                }
            }
        }
        turn[part] = around < std::f64::consts::TAU;
        repairs.parts_flipped += u64::from(turn[part]);
    }
    for (triangle, &part) in mesh.triangles.iter_mut().zip(part_of) {
        if turn[part as usize] {
            triangle.swap(1, 2);
        }
    }
}

/// Returns the signed solid angle of a triangle as seen from the origin (van Oosterom and Strackee 1983).
pub(crate) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let over = a.dot(b.cross(c));
    let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * over.atan2(under)
}

impl Mesh {
    /// Returns the triangles with vertices at one place merged, without normals, materials, and triangles whose
    /// vertices are not finite.
    pub fn welded(&self) -> Self {
        weld(self).0
    }
}
