//! Distances of points that lie close together.
//!
//! *Theory.* A point is no farther from the surface than the center of a box around it, plus half of the diagonal. So only leaves
//! that are as near to the box can hold the nearest triangle. One search finds them for all points.

use super::tree::{Bvh, WIDE, leaf_square};
use argil_math::Aabb;
use glam::Vec3;

/// Leaves of more packets than this are not worth listing.
const MAX_LEAVES: usize = 160;

/// Numbers of the boxes of eight leaves, along one axis.
type WideAxis = [f32; WIDE];

/// The boxes of eight leaves.
#[derive(Clone, Copy)]
struct WideBox {
    low: [WideAxis; 3],
    high: [WideAxis; 3],
}

impl WideBox {
    /// Boxes that no point is near to.
    const FAR: Self = Self {
        low: [[f32::MAX; WIDE]; 3],
        high: [[f32::MAX; WIDE]; 3],
    };

    /// Returns the squared distances from a point.
    #[inline(always)]
    fn squares(&self, p: Vec3) -> WideAxis {
        let mut squares = [0.0; WIDE];
        for axis in 0..3 {
            let sides = self.low[axis].iter().zip(&self.high[axis]);
            for (square, (low, high)) in squares.iter_mut().zip(sides) {
                let gap = (low - p[axis]).max(p[axis] - high).max(0.0);
                *square += gap * gap;
            }
        }
        squares
    }
}

/// Searches a tree for points that lie close together.
pub(super) struct PacketSearch<'a> {
    tree: &'a Bvh,
    stack: Vec<(f32, u32)>,
    leaves: Vec<u32>,
    boxes: Vec<WideBox>,
    /// The leaf that was nearest last.
    hint: u32,
}

impl<'a> PacketSearch<'a> {
    pub(super) fn new(tree: &'a Bvh) -> Self {
        Self {
            tree,
            stack: Vec::with_capacity(64),
            leaves: Vec::with_capacity(MAX_LEAVES),
            boxes: Vec::with_capacity(MAX_LEAVES / WIDE + 1),
            hint: 0,
        }
    }

    /// Computes the unsigned distances of points. It is fast if they lie close together.
    #[inline(always)]
    pub(super) fn distances(&mut self, points: &[Vec3], out: &mut [f32]) {
        let bounds = Aabb::around(points.iter().copied());
        let is_packet = points.len() > 4 && bounds.is_finite();
        let center = bounds.center();
        if is_packet {
            self.hint = self.tree.nearest(center, self.hint, &mut self.stack).1;
            let square = leaf_square(&self.tree.leaves[self.hint as usize], center);
            let reach = 1.000_01 * (square.sqrt() + bounds.half_diagonal());
            if self.list(bounds, reach) {
                for (&p, out) in points.iter().zip(out) {
                    *out = self.nearest_of_list(p).sqrt();
                }
                return;
            }
        }
        for (&p, out) in points.iter().zip(out) {
            (*out, self.hint) = self.tree.nearest(p, self.hint, &mut self.stack);
        }
    }

    /// Lists the leaves that are within reach of a box. Returns whether there are few.
    #[inline(always)]
    fn list(&mut self, bounds: Aabb, reach: f32) -> bool {
        let square = reach * reach;
        self.leaves.clear();
        self.boxes.clear();
        self.stack.clear();
        self.stack.push((0.0, 0));
        while let Some((_, at)) = self.stack.pop() {
            let node = &self.tree.nodes[at as usize];
            let gap = (node.low - bounds.max)
                .max(bounds.min - node.high)
                .max(Vec3::ZERO);
            if gap.length_squared() > square {
                continue;
            }
            if !node.is_leaf {
                self.stack
                    .extend([(0.0, node.first), (0.0, node.first + 1)]);
                continue;
            }
            let lane = self.leaves.len() % WIDE;
            if lane == 0 {
                if self.leaves.len() >= MAX_LEAVES {
                    return false;
                }
                self.boxes.push(WideBox::FAR);
            }
            self.leaves.push(node.first);
            if let Some(own) = self.boxes.last_mut() {
                for axis in 0..3 {
                    own.low[axis][lane] = node.low[axis];
                    own.high[axis][lane] = node.high[axis];
                }
            }
        }
        true
    }

    /// Returns the squared distance to the nearest triangle of all listed leaves.
    #[inline(always)]
    fn nearest_of_list(&mut self, p: Vec3) -> f32 {
        let tree = self.tree;
        let mut best = leaf_square(&tree.leaves[self.hint as usize], p);
        for (boxes, leaves) in self.boxes.iter().zip(self.leaves.chunks(WIDE)) {
            let squares = boxes.squares(p);
            for (square, &leaf) in squares.iter().zip(leaves) {
                if *square < best && leaf != self.hint {
                    let own = leaf_square(&tree.leaves[leaf as usize], p);
                    if own < best {
                        (best, self.hint) = (own, leaf);
                    }
                }
            }
        }
        best
    }
}
