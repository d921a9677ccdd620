//! A bounding-volume hierarchy over triangles, for nearest triangles and winding numbers.

use super::leaf::TriangleLeaf;
use crate::nearest::{BvhNode, WIDE, WideTree};
use crate::repair::solid_angle;
use argil_math::Aabb;
use glam::Vec3;
use std::f64::consts::TAU;

/// A node counts as one plate for points farther than this many of its radii.
const FAR_RADII: f32 = 2.3;

/// A bounding-volume hierarchy.
#[derive(Debug)]
pub(super) struct Bvh {
    nodes: Vec<BvhNode>,
    pub(super) nearest: WideTree<TriangleLeaf>,
    pub(super) corners: Vec<[Vec3; 3]>,
    /// The index of each leaf's first triangle.
    begins: Vec<(u32, u32)>,
}

impl Bvh {
    pub(super) fn new(mut corners: Vec<[Vec3; 3]>) -> Self {
        let mut nodes = vec![BvhNode::placeholder()];
        let (mut leaves, mut begins) = (Vec::new(), Vec::new());
        let mut todo = vec![(0usize, 0usize, corners.len())];
        while let Some((at, begin, end)) = todo.pop() {
            let triangles = &mut corners[begin..end];
            let mut node = BvhNode::of(triangles);
            if triangles.len() <= WIDE {
                node.is_leaf = true;
                node.first = leaves.len() as u32;
                leaves.push(TriangleLeaf::new(triangles));
                begins.push((begin as u32, end as u32));
            } else {
                let middles = Aabb::around(triangles.iter().map(|c| c[0] + c[1] + c[2]));
                let size = middles.size().to_array();
                let axis = (0..3)
                    .max_by(|&a, &b| size[a].total_cmp(&size[b]))
                    .unwrap_or(0);
                // A whole number of leaves on the left.
                let half = (triangles.len() / 2)
                    .next_multiple_of(WIDE)
                    .min(triangles.len() - 1);
                let key = |c: &[Vec3; 3]| c[0][axis] + c[1][axis] + c[2][axis];
                triangles.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
                let first = nodes.len();
                node.first = first as u32;
                nodes.extend([BvhNode::placeholder(), BvhNode::placeholder()]);
                todo.push((first, begin, begin + half));
                todo.push((first + 1, begin + half, end));
            }
            nodes[at] = node;
        }
        Self {
            nearest: WideTree::new(&nodes, leaves),
            nodes,
            corners,
            begins,
        }
    }

    /// Whether a triangle may be between inside and outside. It is not if both of its sides are inside or outside,
    /// at its center and near its vertices.
    pub(super) fn is_surface(&self, corners: &[Vec3; 3], reach: f32) -> bool {
        let [a, b, c] = *corners;
        let middle = (a + b + c) / 3.0;
        let normal = reach * (b - a).cross(c - a).normalize_or_zero();
        let places = [middle, a, b, c].map(|corner| corner.lerp(middle, 0.1));
        places.into_iter().any(|p| {
            let is_in = |p: Vec3| self.winding(p) > 0.5;
            is_in(p - normal) != is_in(p + normal)
        })
    }

    /// Returns the winding number of the triangles around a point.
    pub(super) fn winding(&self, p: Vec3) -> f64 {
        let mut turns = 0.0;
        let mut stack = [0u32; 96];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let node = &self.nodes[stack[top] as usize];
            let way = node.middle - p;
            let square = way.length_squared();
            let far = FAR_RADII * node.radius;
            if square > far * far {
                turns += f64::from(node.plate.dot(way) / (square * square.sqrt()));
            } else if node.is_leaf {
                let (begin, end) = self.begins[node.first as usize];
                for corners in &self.corners[begin as usize..end as usize] {
                    let [a, b, c] = corners.map(|c| c - p);
                    let middle = (a + b + c) / 3.0;
                    let reach = (a - middle)
                        .length_squared()
                        .max((b - middle).length_squared());
                    let square = middle.length_squared();
                    // A distant triangle also counts as a plate.
                    turns += if square > 16.0 * reach.max((c - middle).length_squared()) {
                        let plate = 0.5 * (b - a).cross(c - a);
                        f64::from(plate.dot(middle) / (square * square.sqrt()))
                    } else {
                        solid_angle([a, b, c].map(|c| c.as_dvec3()))
                    };
                }
            } else {
                stack[top] = node.first;
                stack[top + 1] = node.first + 1;
                top += 2;
            }
        }
        turns / (2.0 * TAU)
    }
}
