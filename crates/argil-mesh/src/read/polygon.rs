//! Cuts polygons into triangles.
//!
//! *Practice.* A convex polygon becomes a fan. Others are projected to the plane that their area vector is normal to
//! (Newell), and cut by ears.

use super::error::ReadFault;
use crate::Mesh;
use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};
use std::collections::HashMap;

/// Maximum sum of squares of the numbers of corners, which the time to cut concave polygons grows with: for each file, and
/// per corner.
const MAX_WORK: (u64, u64) = (2_000_000_000, 1000);
/// Maximum distance of a flat polygon's corners from its plane, in its diameter.
const FLATNESS: f64 = 0.05;
/// Maximum area that triangles may have more than their polygon, in its area.
const EXCESS: f64 = 1e-3;

/// How many polygons have something in common, and where the first is.
#[derive(Clone, Copy, Default)]
struct Count {
    count: u64,
    first: usize,
}

impl Count {
    fn add(&mut self, place: usize) {
        if self.count == 0 {
            self.first = place;
        }
        self.count += 1;
    }
}

/// Cuts polygons, and counts those that are not simple and flat.
#[derive(Default)]
pub(super) struct Polygons {
    ears: Option<Earcut<f64>>,
    flat: Vec<DVec2>,
    cut: Vec<u32>,
    work: u64,
    corners: u64,
    crossing: Count,
    uneven: Count,
    empty: Count,
    short: Count,
}

impl Polygons {
    /// Adds a polygon's triangles to a mesh that has its vertices. `place` is a line's or a face's number, for messages.
    ///
    /// # Errors
    /// If the polygon has too many corners, or one that does not exist.
    pub(super) fn add(
        &mut self,
        corners: &[u32],
        mesh: &mut Mesh,
        place: usize,
    ) -> Result<(), ReadFault> {
        match *corners {
            [] | [_] | [_, _] => {
                self.short.add(place);
                return Ok(());
            }
            [a, b, c] => {
                mesh.triangles.push([a, b, c]);
                return Ok(());
            }
            _ => {}
        }
        let position = |&i: &u32| mesh.positions.get(i as usize).copied();
        let places: Option<Vec<Vec3>> = corners.iter().map(position).collect();
        let places =
            places.ok_or_else(|| ReadFault::from("a polygon refers to a missing vertex"))?;
        // Repeated corners have no edge between them.
        let mut kept: Vec<usize> = (0..corners.len()).collect();
        kept.dedup_by_key(|i| places[*i].to_array());
        while kept.len() > 1 && places[kept[0]] == places[kept[kept.len() - 1]] {
            kept.pop();
        }
        let places: Vec<Vec3> = kept.iter().map(|&i| places[i]).collect();
        let corners: Vec<u32> = kept.iter().map(|&i| corners[i]).collect();
        self.split(&places, place)?;
        let (triangles, _) = self.cut.as_chunks::<3>();
        mesh.triangles
            .extend(triangles.iter().map(|t| t.map(|i| corners[i as usize])));
        Ok(())
    }

    /// Cuts a polygon without repeated corners into `cut`.
    fn split(&mut self, places: &[Vec3], place: usize) -> Result<(), ReadFault> {
        let count = places.len() as u32;
        self.cut.clear();
        let fan = |cut: &mut Vec<u32>| cut.extend((2..count).flat_map(|i| [0, i - 1, i]));
        let first = places.first().copied().unwrap_or_default().as_dvec3();
        let corners: Vec<DVec3> = places.iter().map(|p| p.as_dvec3() - first).collect();
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let area: DVec3 = (0..corners.len()).map(|i| corners[i].cross(next(i))).sum();
        let size = corners.iter().map(|p| p.length()).fold(0.0, f64::max);
        // A vertex that is not finite, or opposite loops of one area.
        let Some(normal) = area
            .try_normalize()
            .filter(|_| area.length() > 1e-9 * size * size)
        else {
            if count > 2 {
                self.empty.add(place);
                fan(&mut self.cut);
            }
            return Ok(());
        };
        let height = corners.iter().map(|p| p.dot(normal));
        let (low, high) = height.fold((0f64, 0f64), |(low, high), h| (low.min(h), high.max(h)));
        if high - low > FLATNESS * size {
            self.uneven.add(place);
        }
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        self.flat.clear();
        self.flat
            .extend(corners.iter().map(|p| DVec2::new(p.dot(x), p.dot(y))));
        if is_convex(&self.flat) {
            fan(&mut self.cut);
            return Ok(());
        }
        self.corners += corners.len() as u64;
        self.work = self.work.saturating_add((corners.len() as u64).pow(2));
        let (each, per_corner) = MAX_WORK;
        if self.work > each + per_corner * self.corners {
            return Err(ReadFault::TooLarge(format!(
                "its concave polygons have too many corners to be cut, the last one {}: cut it into triangles",
                corners.len()
            )));
        }
        let ears = self.ears.get_or_insert_default();
        let flat: &[[f64; 2]] = bytemuck::cast_slice(&self.flat);
        ears.earcut_slice(flat, &[], &mut self.cut);
        orient(&mut self.cut, &self.flat);
        restore(&mut self.cut, &self.flat);
        let (triangles, _) = self.cut.as_chunks();
        let sum: f64 = triangles.iter().map(|t| area_of(t, &self.flat).abs()).sum();
        let whole = area.length();
        if (sum - whole).abs() > EXCESS * whole {
            self.crossing.add(place);
        }
        Ok(())
    }

    /// Describes the polygons that can be cut in several ways. `unit` is what their places count.
    pub(super) fn warnings(&self, unit: &str) -> Vec<String> {
        let describe = |of: Count, what: &str, result: &str| {
            let (count, first) = (of.count, of.first);
            (count > 0).then(|| {
                format!("polygons that {what}: {count}, first at {unit} {first}; {result}")
            })
        };
        let guess = "their triangles are a guess";
        [
            describe(self.crossing, "cross or touch themselves", guess),
            describe(
                self.uneven,
                "are not flat",
                "their triangles are one of several surfaces",
            ),
            describe(self.empty, "enclose no area", guess),
            describe(
                self.short,
                "have fewer than three corners",
                "they are left out",
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// Returns twice the area of a triangle, negative if it is clockwise.
fn area_of(&[a, b, c]: &[u32; 3], flat: &[DVec2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|i| flat[i as usize]);
    (b - a).perp_dot(c - a)
}

/// Whether a polygon turns left at each corner, and once in all.
fn is_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    let turns = (0..count).all(|i| {
        let [a, b, c] = [i, (i + 1) % count, (i + 2) % count].map(|i| flat[i]);
        (b - a).perp_dot(c - b) > 0.0
    });
    // A star turns left, too, but more than once: its fan then has clockwise triangles.
    turns && (2..count as u32).all(|i| area_of(&[0, i - 1, i], flat) > 0.0)
}

/// Makes triangles counterclockwise.
fn orient(cut: &mut [u32], flat: &[DVec2]) {
    let (triangles, _) = cut.as_chunks_mut::<3>();
    for triangle in triangles {
        if area_of(triangle, flat) < 0.0 {
            triangle.swap(1, 2);
        }
    }
}

/// Puts corners back that lie on a straight edge and were left out: a neighbor may have them.
fn restore(cut: &mut Vec<u32>, flat: &[DVec2]) {
    let count = flat.len() as u32;
    let mut is_used = vec![false; flat.len()];
    for &i in cut.iter() {
        is_used[i as usize] = true;
    }
    let used: Vec<u32> = (0..count).filter(|&i| is_used[i as usize]).collect();
    if used.len() == flat.len() {
        return;
    }
    // The triangle at each edge, as the place of its first corner.
    let mut at_edge = HashMap::new();
    for (at, t) in cut.as_chunks::<3>().0.iter().enumerate() {
        for i in 0..3 {
            at_edge.insert([t[i], t[(i + 1) % 3]], 3 * at);
        }
    }
    for (index, &from) in used.iter().enumerate() {
        let to = used[(index + 1) % used.len()];
        let chain = (from + 1..from + count)
            .map(|i| i % count)
            .take_while(|&i| i != to);
        let chain: Vec<u32> = chain.collect();
        let Some(&at) = at_edge.get(&[from, to]).filter(|_| !chain.is_empty()) else {
            continue;
        };
        // Cut that triangle into a fan around its other corner.
        let corners = &mut cut[at..at + 3];
        let Some(&tip) = corners.iter().find(|&&i| i != from && i != to) else {
            continue;
        };
        corners.copy_from_slice(&[from, chain[0], tip]);
        for (index, &corner) in chain.iter().enumerate() {
            let next = chain.get(index + 1).copied().unwrap_or(to);
            cut.extend([corner, next, tip]);
        }
        at_edge.insert([to, tip], cut.len() - 3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the triangles of a flat polygon, and the warnings.
    fn cut(corners: &[[f32; 2]]) -> (Mesh, Vec<String>) {
        let mut mesh = Mesh {
            positions: corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect(),
            ..Mesh::default()
        };
        let all: Vec<u32> = (0..corners.len() as u32).collect();
        let mut polygons = Polygons::default();
        polygons.add(&all, &mut mesh, 7).expect("triangles");
        (mesh, polygons.warnings("line"))
    }

    /// Returns the area of triangles, negative where they are clockwise.
    fn area(mesh: &Mesh) -> f32 {
        let doubled = (0..mesh.triangles.len()).map(|i| {
            let [a, b, c] = mesh.triangle_vertices(i);
            (b - a).cross(c - a).z
        });
        let doubled: Vec<f32> = doubled.collect();
        assert!(doubled.iter().all(|&area| area >= 0.0), "{doubled:?}");
        0.5 * doubled.iter().sum::<f32>()
    }

    #[test]
    fn concave_polygons_keep_their_notches() {
        let notched = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        let dart = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        for (corners, expected) in [(&notched[..], 7.0), (&dart[..], 1.0)] {
            for shift in 0..corners.len() {
                let mut corners = corners.to_vec();
                corners.rotate_left(shift);
                let (mesh, warnings) = cut(&corners);
                assert!((area(&mesh) - expected).abs() < 1e-5, "{shift} {mesh:?}");
                assert_eq!(mesh.triangles.len(), corners.len() - 2);
                assert!(warnings.is_empty(), "{warnings:?}");
            }
        }
    }

    /// A corner on a straight edge is a neighbor's corner, too: without it there would be a gap.
    #[test]
    fn corners_on_straight_edges_stay() {
        let square = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.5, 0.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
        ];
        for shift in 0..square.len() {
            let mut corners = square.to_vec();
            corners.rotate_left(shift);
            let (mesh, warnings) = cut(&corners);
            assert!((area(&mesh) - 4.0).abs() < 1e-5);
            let mut used: Vec<u32> = mesh.triangles.concat();
            used.sort_unstable();
            used.dedup();
            assert_eq!(used.len(), 8, "{:?}", mesh.triangles);
            assert!(warnings.is_empty(), "{warnings:?}");
        }
    }

    #[test]
    fn polygons_that_are_not_simple_are_named() {
        let says = |corners: &[[f32; 2]], part: &str| {
            let (_, warnings) = cut(corners);
            assert!(
                warnings
                    .iter()
                    .any(|w| w.contains(part) && w.contains("line 7")),
                "{warnings:?}"
            );
        };
        says(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]], "cross");
        says(
            &[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
            "enclose no area",
        );
        says(
            &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]],
            "enclose no area",
        );
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.5), Vec3::Y],
            ..Mesh::default()
        };
        let mut polygons = Polygons::default();
        polygons
            .add(&[0, 1, 2, 3], &mut mesh, 1)
            .expect("triangles");
        polygons.add(&[0, 1], &mut mesh, 2).expect("nothing");
        let warnings = polygons.warnings("face");
        assert!(warnings[0].contains("not flat") && warnings[1].contains("fewer than three"));
        assert_eq!(mesh.triangles.len(), 2);
        assert!(polygons.add(&[0, 1, 2, 9], &mut mesh, 3).is_err());
        let zigzag = |i: u32| Vec3::new(i as f32, (i % 2) as f32 - 2e5 * (i % 99_999) as f32, 0.0);
        mesh.positions = (0..100_000).map(zigzag).collect();
        let long: Vec<u32> = (0..100_000).collect();
        let error = polygons.add(&long, &mut mesh, 4);
        assert!(matches!(error, Err(ReadFault::TooLarge(_))));
    }

    /// A polygon around a hole, joined by a bridge that is passed twice.
    #[test]
    fn bridged_holes_stay_open() {
        let ring = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let (mesh, warnings) = cut(&ring);
        assert!((area(&mesh) - 12.0).abs() < 1e-5, "{mesh:?}");
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}
