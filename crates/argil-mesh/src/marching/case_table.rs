//! The triangles of a cell, for each of the 256 ways in which its corners can be inside or outside.
//!
//! *Theory.* On a face, one segment cuts off each run of inside corners. Two opposite inside corners stay apart. A
//! face's segments follow from its own four corners, so both cells that share it have the same ones, in opposite
//! directions. So the surface is closed and consistently oriented, and the ambiguity of Lorensen and Cline's table
//! of 1987 (Dürst 1988) cannot arise. Segments form loops. Each loop is cut into triangles by diagonals that do not
//! lie in a face, so that an edge is never in more than two triangles.
//!
//! *Practice.* The table is generated when first needed, and tests prove these claims for every case. Corner `c` is
//! at `(c & 1, c >> 1 & 1, c >> 2)`. Edges 0 to 3 run along x, 4 to 7 along y, and 8 to 11 along z. Of each four,
//! the lower bit is the position along the first of the other axes, and the higher bit along the second.

use std::sync::OnceLock;

/// Maximum triangles of a cell.
pub const MAX_TRIANGLES: usize = 5;

/// The triangles of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MarchingCase {
    /// Number of triangles.
    pub count: u8,
    /// The edges of each triangle's vertices.
    pub triangles: [[u8; 3]; MAX_TRIANGLES],
}

impl MarchingCase {
    /// Returns the triangles.
    #[inline]
    pub fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles[..usize::from(self.count)]
    }
}

/// Returns the cases. Bit `c` of a case's index tells whether corner `c` is inside.
pub fn cases() -> &'static [MarchingCase; 256] {
    static CASES: OnceLock<[MarchingCase; 256]> = OnceLock::new();
    CASES.get_or_init(|| std::array::from_fn(|case| make(case as u8)))
}

/// Returns the loops of each case: the edges that each passes through, in order.
pub fn case_loops() -> &'static [Vec<Vec<u8>>; 256] {
    static CASE_LOOPS: OnceLock<[Vec<Vec<u8>>; 256]> = OnceLock::new();
    CASE_LOOPS.get_or_init(|| std::array::from_fn(|case| loops(case as u8)))
}

/// Returns the two corners of an edge, the lower first.
pub fn corners(edge: u8) -> [u8; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let (low, high) = (place & 1, place >> 1);
    let first = match axis {
        0 => low << 1 | high << 2,
        1 => low | high << 2,
        _ => low | high << 1,
    };
    [first, first | 1 << axis]
}

/// Returns the edge between two corners that differ in one bit.
fn edge(a: u8, b: u8) -> u8 {
    let (axis, first) = ((a ^ b).trailing_zeros() as u8, a & b);
    let place = match axis {
        0 => first >> 1,
        1 => (first & 1) | (first >> 1 & 2),
        _ => first & 3,
    };
    axis * 4 + place
}

/// Returns the corners of a cell's faces, counterclockwise as seen from outside.
fn faces() -> [[u8; 4]; 6] {
    std::array::from_fn(|face| {
        let (axis, side) = (face / 2, face as u8 % 2);
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let base = side << axis;
        if side == 1 {
            [base, base | u, base | u | v, base | v]
        } else {
            [base, base | v, base | u | v, base | u]
        }
    })
}

/// Returns the loops of edges of a case, clockwise as seen from outside.
fn loops(case: u8) -> Vec<Vec<u8>> {
    let is_in = |corner: u8| case >> corner & 1 != 0;
    let mut next = [None; 12];
    for face in faces() {
        for i in 0..4 {
            let at = |k: usize| face[(i + k) % 4];
            if is_in(at(0)) || !is_in(at(1)) {
                continue;
            }
            // The run of inside corners that begins here.
            let end = (1..4).find(|&k| is_in(at(k)) && !is_in(at(k + 1)));
            let Some(end) = end else { continue };
            next[usize::from(edge(at(end), at(end + 1)))] = Some(edge(at(0), at(1)));
        }
    }
    let mut loops = Vec::new();
    for begin in 0..12u8 {
        let mut ring = Vec::new();
        let mut at = begin;
        while let Some(to) = next[usize::from(at)].take() {
            ring.push(at);
            at = to;
        }
        if !ring.is_empty() {
            loops.push(ring);
        }
    }
    loops
}

/// Whether two edges are on one face.
fn share_a_face(a: u8, b: u8) -> bool {
    let on = |edge: u8, face: &[u8; 4]| corners(edge).iter().all(|c| face.contains(c));
    faces().iter().any(|face| on(a, face) && on(b, face))
}

/// Cuts the part `ring[i..=j]` of a loop into triangles. Returns whether that is possible without a diagonal in a
/// face.
fn cut(ring: &[u8], i: usize, j: usize, out: &mut Vec<[u8; 3]>) -> bool {
    if j - i < 2 {
        return true;
    }
    let fits = |a: usize, b: usize| b - a == 1 || !share_a_face(ring[a], ring[b]);
    for k in i + 1..j {
        let before = out.len();
        if fits(i, k) && fits(k, j) && cut(ring, i, k, out) && cut(ring, k, j, out) {
            out.push([ring[i], ring[j], ring[k]]);
            return true;
        }
        out.truncate(before);
    }
    false
}

fn make(case: u8) -> MarchingCase {
    let mut all = Vec::new();
    for ring in loops(case) {
        let is_cut = cut(&ring, 0, ring.len() - 1, &mut all);
        debug_assert!(is_cut, "a loop of case {case} cannot be cut");
    }
    let mut made = MarchingCase {
        count: all.len() as u8,
        ..MarchingCase::default()
    };
    made.triangles[..all.len()].copy_from_slice(&all);
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// How often each directed edge between two vertices occurs in a case.
    fn directed(case: &MarchingCase) -> HashMap<(u8, u8), u32> {
        let mut all = HashMap::new();
        for &[a, b, c] in case.triangles() {
            for pair in [(a, b), (b, c), (c, a)] {
                *all.entry(pair).or_default() += 1;
            }
        }
        all
    }

    #[test]
    fn vertices_are_where_the_sign_changes() {
        for (number, case) in cases().iter().enumerate() {
            let mut used = [false; 12];
            for &edge in case.triangles().iter().flatten() {
                used[usize::from(edge)] = true;
            }
            for (edge, used) in (0..).zip(used) {
                let [a, b] = corners(edge);
                assert_eq!(
                    used,
                    (number >> a ^ number >> b) & 1 != 0,
                    "case {number}, edge {edge}"
                );
            }
        }
    }

    #[test]
    fn what_is_inside_a_cell_is_closed_and_what_is_not_lies_in_faces() {
        for (number, case) in cases().iter().enumerate() {
            let all = directed(case);
            for (&(a, b), &count) in &all {
                assert_eq!(count, 1, "case {number}: {a} to {b} more than once");
                // Either the way back is there, or it is a segment in a face.
                let is_inner = all.contains_key(&(b, a));
                assert!(is_inner != share_a_face(a, b), "case {number}: {a} to {b}");
            }
        }
    }

    #[test]
    fn neighbors_have_the_same_segments_the_other_way_round() {
        // Segments in the face x = 1 of one cell against those in x = 0 of the next.
        for axis in 0..3u8 {
            for number in 0..=255u8 {
                for other in 0..=255u8 {
                    let high = (0..8u8).filter(|c| c >> axis & 1 == 1);
                    let same = |c: u8| (number >> c ^ other >> (c ^ (1 << axis))) & 1 == 0;
                    if !high.clone().all(same) {
                        continue;
                    }
                    let segments = |case: u8, side: u8| {
                        let inside = |e: u8| corners(e).iter().all(|c| c >> axis & 1 == side);
                        // Edges by the corners of the high side.
                        let name = |e: u8| {
                            let [a, b] = corners(e).map(|c| c | 1 << axis);
                            edge(a, b)
                        };
                        let all = directed(&cases()[usize::from(case)]);
                        let mut pairs: Vec<(u8, u8)> = all
                            .keys()
                            .filter(|(a, b)| inside(*a) && inside(*b))
                            .map(|&(a, b)| (name(a), name(b)))
                            .collect();
                        pairs.sort_unstable();
                        pairs
                    };
                    let mut back: Vec<_> =
                        segments(other, 0).iter().map(|&(a, b)| (b, a)).collect();
                    back.sort_unstable();
                    assert_eq!(
                        segments(number, 1),
                        back,
                        "cases {number} and {other}, axis {axis}"
                    );
                }
            }
        }
    }

    #[test]
    fn one_corner_inside_faces_away_from_it() {
        // Corner 0: the normal of its triangle points to where all coordinates grow.
        let case = &cases()[1];
        assert_eq!(case.count, 1);
        let place = |edge: u8| {
            let [a, b] = corners(edge);
            glam::Vec3::from_array([0, 1, 2].map(|k| 0.5 * f32::from((a >> k & 1) + (b >> k & 1))))
        };
        let [a, b, c] = case.triangles[0].map(place);
        assert!((b - a).cross(c - a).dot(glam::Vec3::ONE) > 0.0);
    }

    #[test]
    fn the_whole_inside_and_outside_have_nothing() {
        assert_eq!((cases()[0].count, cases()[255].count), (0, 0));
        assert_eq!(
            cases().iter().map(|c| c.count).max(),
            Some(MAX_TRIANGLES as u8)
        );
    }
}
