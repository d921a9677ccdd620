//! Distances to eight triangles at once.

use crate::nearest::{Leaf, WIDE, Wide3};
use glam::Vec3;

/// A leaf's triangles: a vertex, and the vectors to the other two. Missing ones repeat the first.
#[derive(Clone, Debug)]
pub(super) struct TriangleLeaf {
    a: Wide3,
    ab: Wide3,
    ac: Wide3,
}

impl TriangleLeaf {
    pub(super) fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut leaf = Self {
            a: [[0.0; WIDE]; 3],
            ab: [[0.0; WIDE]; 3],
            ac: [[0.0; WIDE]; 3],
        };
        for i in 0..WIDE {
            let Some([a, b, c]) = triangles.get(i).or(triangles.first()) else {
                return leaf;
            };
            for axis in 0..3 {
                leaf.a[axis][i] = a[axis];
                leaf.ab[axis][i] = b[axis] - a[axis];
                leaf.ac[axis][i] = c[axis] - a[axis];
            }
        }
        leaf
    }
}

impl Leaf for TriangleLeaf {
    /// To the plane where the foot lies within, else to the sides.
    #[inline(always)]
    fn square(&self, p: Vec3) -> f32 {
        let Self { a, ab, ac } = self;
        let mut least = [f32::INFINITY; WIDE];
        for i in 0..WIDE {
            let dot = |u: [f32; 3], v: [f32; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
            let ab = [ab[0][i], ab[1][i], ab[2][i]];
            let ac = [ac[0][i], ac[1][i], ac[2][i]];
            let ap = [p.x - a[0][i], p.y - a[1][i], p.z - a[2][i]];
            let (d00, d01, d11) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
            let (d20, d21) = (dot(ap, ab), dot(ap, ac));
            let area = d00 * d11 - d01 * d01;
            let v = d11 * d20 - d01 * d21;
            let w = d00 * d21 - d01 * d20;
            let is_within = v >= 0.0 && w >= 0.0 && v + w <= area;
            // The nearest point of each side.
            let along = |from: [f32; 3], side: [f32; 3], square: f32| {
                let t = (dot(from, side) / square.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                let way = [
                    from[0] - t * side[0],
                    from[1] - t * side[1],
                    from[2] - t * side[2],
                ];
                dot(way, way)
            };
            let bp = [ap[0] - ab[0], ap[1] - ab[1], ap[2] - ab[2]];
            let bc = [ac[0] - ab[0], ac[1] - ab[1], ac[2] - ab[2]];
            let sides = along(ap, ab, d00)
                .min(along(ap, ac, d11))
                .min(along(bp, bc, dot(bc, bc)));
            let reciprocal = 1.0 / area.max(f32::MIN_POSITIVE);
            let (s, t) = (v * reciprocal, w * reciprocal);
            let way = [
                ap[0] - s * ab[0] - t * ac[0],
                ap[1] - s * ab[1] - t * ac[1],
                ap[2] - s * ab[2] - t * ac[2],
            ];
            least[i] = if is_within {
                dot(way, way).min(sides)
            } else {
                sides
            };
        }
        least.into_iter().fold(f32::INFINITY, f32::min)
    }
}
