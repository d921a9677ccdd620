//! The nearest of many points of a surface.

use super::node::BvhNode;
use super::wide::{Leaf, NearestSearch, WideTree};
use glam::Vec3;
use multiversion::multiversion;

/// Points per leaf.
const POINTS: usize = 64;

/// The points of a leaf, an axis each. Missing ones repeat the first.
#[derive(Clone, Debug)]
struct PointLeaf([[f32; POINTS]; 3]);

impl PointLeaf {
    fn new(points: &[[Vec3; 2]]) -> Self {
        let of =
            |axis: usize, i: usize| points.get(i).or(points.first()).map_or(0.0, |p| p[0][axis]);
        Self([0, 1, 2].map(|axis| std::array::from_fn(|i| of(axis, i))))
    }
}

impl Leaf for PointLeaf {
    #[inline(always)]
    fn square(&self, p: Vec3) -> f32 {
        let Self([x, y, z]) = self;
        let mut squares = [0.0; POINTS];
        for (i, square) in squares.iter_mut().enumerate() {
            let (x, y, z) = (x[i] - p.x, y[i] - p.y, z[i] - p.z);
            *square = x * x + y * y + z * z;
        }
        let mut half = POINTS / 2;
        while half > 0 {
            for i in 0..half {
                squares[i] = if squares[i + half] < squares[i] {
                    squares[i + half]
                } else {
                    squares[i]
                };
            }
            half /= 2;
        }
        squares[0]
    }
}

/// Points of a surface, which lie about as far apart everywhere, and the distances to them.
///
/// ```
/// use argil_mesh::SurfacePoints;
/// use glam::Vec3;
/// let points = [[Vec3::X, Vec3::X], [Vec3::Y, Vec3::Y]];
/// let surface = SurfacePoints::new(points.to_vec());
/// let mut out = [0.0; 2];
/// surface.distances(&[Vec3::new(3.0, 0.0, 0.0), Vec3::Y], &mut out);
/// assert_eq!(out, [2.0, 0.0]);
/// ```
#[derive(Debug)]
pub struct SurfacePoints {
    tree: WideTree<PointLeaf>,
}

impl SurfacePoints {
    /// Prepares distances to points, each with a normal of the surface. Normals of any length only make searches faster.
    ///
    /// # Panics
    /// If there are no points.
    pub fn new(mut points: Vec<[Vec3; 2]>) -> Self {
        assert!(!points.is_empty(), "no points");
        let mut nodes = vec![BvhNode::placeholder()];
        let mut leaves = Vec::new();
        let mut todo = vec![(0, 0, points.len())];
        while let Some((at, begin, end)) = todo.pop() {
            let held = &mut points[begin..end];
            let mut node = BvhNode::of_points(held);
            if held.len() <= POINTS {
                node.is_leaf = true;
                node.first = leaves.len() as u32;
                leaves.push(PointLeaf::new(held));
            } else {
                let size = node.high - node.low;
                let axis = size.max_position();
                let half = (held.len() / 2)
                    .next_multiple_of(POINTS)
                    .min(held.len() - 1);
                held.select_nth_unstable_by(half, |a, b| a[0][axis].total_cmp(&b[0][axis]));
                let first = nodes.len();
                node.first = first as u32;
                nodes.extend([BvhNode::placeholder(), BvhNode::placeholder()]);
                todo.push((first, begin, begin + half));
                todo.push((first + 1, begin + half, end));
            }
            nodes[at] = node;
        }
        Self {
            tree: WideTree::new(&nodes, leaves),
        }
    }

    /// Computes the distances of positions to the nearest point into `out`. It is faster if consecutive positions are close
    /// together.
    pub fn distances(&self, positions: &[Vec3], out: &mut [f32]) {
        measure(&self.tree, positions, out);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure(tree: &WideTree<PointLeaf>, positions: &[Vec3], out: &mut [f32]) {
    let mut search = NearestSearch::new(tree);
    for (&p, out) in positions.iter().zip(out) {
        *out = search.distance(p);
    }
}
