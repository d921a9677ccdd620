//! Searches for the nearest leaf, with eight children of a node measured at once.
//!
//! *Theory.* A search descends into the nearest child first, and skips what lies farther than the nearest leaf so far. Nodes
//! with many children need few steps, and fit SIMD (Wald, Benthin, Boulos 2008).

use super::node::BvhNode;
use glam::Vec3;

/// Children per node.
pub(crate) const WIDE: usize = 8;

/// Three numbers for each of eight triangles or boxes.
pub(crate) type Wide3 = [[f32; WIDE]; 3];

/// What lies together in a tree.
pub(crate) trait Leaf {
    /// Returns the smallest squared distance of a point to what the leaf holds.
    fn square(&self, p: Vec3) -> f32;
}

/// The mark of a child that is a leaf.
const LEAF: u32 = 1 << 31;

/// Eight children: their boxes, and the disks along their plates. Missing ones are infinitely far.
#[derive(Clone, Debug)]
struct WideNode {
    low: Wide3,
    high: Wide3,
    middle: Wide3,
    normal: Wide3,
    along: [[f32; WIDE]; 2],
    radius: [f32; WIDE],
    /// The index of a node, or of a leaf with a mark.
    child: [u32; WIDE],
}

impl WideNode {
    const EMPTY: Self = Self {
        low: [[f32::MAX; WIDE]; 3],
        high: [[f32::MAX; WIDE]; 3],
        middle: [[0.0; WIDE]; 3],
        normal: [[0.0; WIDE]; 3],
        along: [[0.0; WIDE]; 2],
        radius: [0.0; WIDE],
        child: [0; WIDE],
    };

    fn set(&mut self, lane: usize, node: &BvhNode) {
        for axis in 0..3 {
            self.low[axis][lane] = node.low[axis];
            self.high[axis][lane] = node.high[axis];
            self.middle[axis][lane] = node.middle[axis];
            self.normal[axis][lane] = node.normal[axis];
        }
        self.along[0][lane] = node.along[0];
        self.along[1][lane] = node.along[1];
        self.radius[lane] = node.radius;
        self.child[lane] = node.first | if node.is_leaf { LEAF } else { 0 };
    }

    /// Returns lower bounds of the squared distances to the children: to their boxes, or to disks along their plates. The
    /// disks tell more from far away, where most boxes of a smooth surface seem equally near.
    #[inline(always)]
    fn squares(&self, p: Vec3) -> [f32; WIDE] {
        let mut squares = [0.0; WIDE];
        for (lane, square) in squares.iter_mut().enumerate() {
            let (mut of_box, mut along, mut way) = (0.0, 0.0, 0.0);
            for axis in 0..3 {
                let gap = (self.low[axis][lane] - p[axis])
                    .max(p[axis] - self.high[axis][lane])
                    .max(0.0);
                of_box += gap * gap;
                let offset = p[axis] - self.middle[axis][lane];
                along += offset * self.normal[axis][lane];
                way += offset * offset;
            }
            let above = (along - self.along[1][lane])
                .max(self.along[0][lane] - along)
                .max(0.0);
            let across = (way - along * along).max(0.0).sqrt();
            let beside = (across - self.radius[lane]).max(0.0);
            *square = of_box.max(above * above + beside * beside);
        }
        squares
    }
}

/// Leaves below nodes of eight children.
#[derive(Debug)]
pub(crate) struct WideTree<L> {
    nodes: Vec<WideNode>,
    leaves: Vec<L>,
}

impl<L> WideTree<L> {
    /// Joins the nodes of a tree whose first node is its root.
    pub(crate) fn new(binary: &[BvhNode], leaves: Vec<L>) -> Self {
        let mut nodes = vec![WideNode::EMPTY];
        let mut todo = vec![(0usize, 0usize)];
        while let Some((at, from)) = todo.pop() {
            for (lane, child) in children(binary, from).into_iter().enumerate() {
                let node = &binary[child];
                nodes[at].set(lane, node);
                if !node.is_leaf {
                    nodes[at].child[lane] = nodes.len() as u32;
                    todo.push((nodes.len(), child));
                    nodes.push(WideNode::EMPTY);
                }
            }
        }
        Self { nodes, leaves }
    }
}

/// Returns up to eight nodes below one, or that one if it is a leaf.
fn children(binary: &[BvhNode], from: usize) -> Vec<usize> {
    let mut found = vec![from];
    while found.len() < WIDE {
        let area = |at: usize| {
            let size = binary[at].high - binary[at].low;
            size.dot(Vec3::new(size.y, size.z, size.x))
        };
        let inner = (0..found.len()).filter(|&i| !binary[found[i]].is_leaf);
        let Some(widest) = inner.max_by(|&a, &b| area(found[a]).total_cmp(&area(found[b]))) else {
            break;
        };
        let first = binary[found[widest]].first as usize;
        found[widest] = first;
        found.push(first + 1);
    }
    found
}

/// A search of a tree for points, of which consecutive ones lie close together.
pub(crate) struct NearestSearch<'a, L> {
    tree: &'a WideTree<L>,
    stack: Vec<(f32, u32)>,
    /// The leaf that was nearest last.
    nearest: u32,
}

impl<'a, L: Leaf> NearestSearch<'a, L> {
    pub(crate) fn new(tree: &'a WideTree<L>) -> Self {
        Self {
            tree,
            stack: Vec::with_capacity(64),
            nearest: 0,
        }
    }

    /// Returns the distance to the nearest leaf.
    #[inline(always)]
    pub(crate) fn distance(&mut self, p: Vec3) -> f32 {
        let mut best = self.tree.leaves[self.nearest as usize].square(p);
        self.stack.clear();
        self.stack.push((0.0, 0));
        while let Some((square, child)) = self.stack.pop() {
            if square >= best {
                continue;
            }
            if child & LEAF != 0 {
                let squared = self.tree.leaves[(child & !LEAF) as usize].square(p);
                if squared < best {
                    (best, self.nearest) = (squared, child & !LEAF);
                }
                continue;
            }
            let node = &self.tree.nodes[child as usize];
            let squares = node.squares(p);
            let first = self.stack.len();
            for (square, child) in squares.into_iter().zip(node.child) {
                if square < best {
                    self.push(first, (square, child));
                }
            }
        }
        best.sqrt()
    }

    /// Puts a child among those of its node, the nearest one last.
    #[inline(always)]
    fn push(&mut self, first: usize, child: (f32, u32)) {
        let mut at = self.stack.len();
        self.stack.push(child);
        while at > first && self.stack[at - 1].0 < child.0 {
            self.stack[at] = self.stack[at - 1];
            at -= 1;
        }
        self.stack[at] = child;
    }
}
