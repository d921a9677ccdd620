//! A bounding-volume hierarchy over triangles, for nearest triangles and winding numbers.

use crate::repair::solid_angle;
use argil_math::Aabb;
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// Triangles per leaf.
pub(super) const WIDE: usize = 8;

/// A node counts as one plate for points farther than this many of its radii.
pub(super) const FAR_RADII: f32 = 2.3;

/// Three numbers for each triangle of a leaf.
pub(super) type Wide3 = [[f32; WIDE]; 3];

/// A leaf's triangles: a vertex, and the vectors to the other two. Missing ones repeat the first.
#[derive(Clone, Debug)]
pub(super) struct BvhLeaf {
    pub(super) a: Wide3,
    pub(super) ab: Wide3,
    pub(super) ac: Wide3,
}

#[derive(Clone, Debug)]
pub(super) struct BvhNode {
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// The first of two children, or a leaf.
    pub(super) first: u32,
    pub(super) is_leaf: bool,
    /// The position and the area of its plate, and the radius of its triangles around it.
    pub(super) middle: Vec3,
    pub(super) plate: Vec3,
    pub(super) radius: f32,
    /// The plate's direction, and between which values its triangles lie along it, from the position.
    pub(super) normal: Vec3,
    pub(super) along: [f32; 2],
}

impl BvhNode {
    /// Returns a lower bound of the squared distance to the triangles: to their box, or to a disk along their plate. The
    /// disk tells more from far away, where most boxes of a smooth surface seem equally near.
    #[inline(always)]
    fn square(&self, p: Vec3) -> f32 {
        let way = p - self.middle;
        let along = way.dot(self.normal);
        let above = (along - self.along[1]).max(self.along[0] - along).max(0.0);
        let across = (way.length_squared() - along * along).max(0.0).sqrt();
        let beside = (across - self.radius).max(0.0);
        gap_square(self.low, self.high, p).max(above * above + beside * beside)
    }
}

/// A bounding-volume hierarchy.
#[derive(Debug)]
pub(super) struct Bvh {
    pub(super) nodes: Vec<BvhNode>,
    pub(super) leaves: Vec<BvhLeaf>,
    pub(super) corners: Vec<[Vec3; 3]>,
    /// The index of each leaf's first triangle.
    pub(super) begins: Vec<(u32, u32)>,
    /// The box of each leaf.
    pub(super) boxes: Vec<[Vec3; 2]>,
}

impl Bvh {
    pub(super) fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let mut tree = Self {
            nodes: vec![placeholder()],
            leaves: Vec::new(),
            corners,
            begins: Vec::new(),
            boxes: Vec::new(),
        };
        tree.build();
        tree
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

    pub(super) fn build(&mut self) {
        let mut corners = std::mem::take(&mut self.corners);
        let mut todo = vec![(0usize, 0usize, corners.len())];
        while let Some((at, begin, end)) = todo.pop() {
            let own = &mut corners[begin..end];
            let mut node = summary(own);
            if own.len() <= WIDE {
                node.is_leaf = true;
                node.first = self.leaves.len() as u32;
                self.leaves.push(leaf(own));
                self.begins.push((begin as u32, end as u32));
                self.boxes.push([node.low, node.high]);
            } else {
                let middles = Aabb::around(own.iter().map(|c| c[0] + c[1] + c[2]));
                let size = middles.size().to_array();
                let axis = (0..3)
                    .max_by(|&a, &b| size[a].total_cmp(&size[b]))
                    .unwrap_or(0);
                // A whole number of leaves on the left.
                let half = (own.len() / 2).next_multiple_of(WIDE).min(own.len() - 1);
                let key = |c: &[Vec3; 3]| c[0][axis] + c[1][axis] + c[2][axis];
                own.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
                node.first = self.nodes.len() as u32;
                self.nodes.extend([placeholder(), placeholder()]);
                let first = node.first as usize;
                todo.push((first, begin, begin + half));
                todo.push((first + 1, begin + half, end));
            }
            self.nodes[at] = node;
        }
        self.corners = corners;
    }

    /// Returns the unsigned distance and its leaf. `hint` is a leaf to try first.
    #[inline(always)]
    pub(super) fn nearest(&self, p: Vec3, hint: u32, stack: &mut Vec<(f32, u32)>) -> (f32, u32) {
        let best = leaf_square(&self.leaves[hint as usize], p);
        let (square, leaf) = self.nearer(p, (best, hint), stack);
        (square.sqrt(), leaf)
    }

    /// Returns the smallest squared distance and its leaf, given a known one.
    #[inline(always)]
    pub(super) fn nearer(
        &self,
        p: Vec3,
        known: (f32, u32),
        stack: &mut Vec<(f32, u32)>,
    ) -> (f32, u32) {
        let (mut best, mut at_best) = known;
        stack.clear();
        stack.push((self.nodes[0].square(p), 0));
        while let Some((square, at)) = stack.pop() {
            if square >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.is_leaf {
                let own = leaf_square(&self.leaves[node.first as usize], p);
                if own < best {
                    (best, at_best) = (own, node.first);
                }
                continue;
            }
            let first = self.nodes[node.first as usize].square(p);
            let second = self.nodes[node.first as usize + 1].square(p);
            // The nearer one is next.
            if first < second {
                stack.push((second, node.first + 1));
                stack.push((first, node.first));
            } else {
                stack.push((first, node.first));
                stack.push((second, node.first + 1));
            }
        }
        (best, at_best)
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

pub(super) fn placeholder() -> BvhNode {
    summary(&[])
}

pub(super) fn summary(triangles: &[[Vec3; 3]]) -> BvhNode {
    let bounds = Aabb::around(triangles.iter().flatten().copied());
    let (mut area, mut middle, mut plate) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for corners in triangles {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let normal = 0.5 * (b - a).cross(c - a);
        let own = normal.length();
        area += own;
        middle += own * (a + b + c) / 3.0;
        plate += normal;
    }
    let middle = (middle / area.max(f64::MIN_POSITIVE)).as_vec3();
    let reach = |p: &Vec3| p.distance(middle);
    let normal = plate.normalize_or_zero().as_vec3();
    let mut along = [f32::INFINITY, f32::NEG_INFINITY];
    for p in triangles.iter().flatten() {
        let at = (*p - middle).dot(normal);
        along = [along[0].min(at), along[1].max(at)];
    }
    BvhNode {
        low: bounds.min,
        high: bounds.max,
        first: 0,
        is_leaf: false,
        middle,
        plate: plate.as_vec3(),
        radius: triangles.iter().flatten().map(reach).fold(0.0, f32::max),
        normal,
        along,
    }
}

pub(super) fn leaf(triangles: &[[Vec3; 3]]) -> BvhLeaf {
    let mut leaf = BvhLeaf {
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

#[inline(always)]
pub(super) fn gap_square(low: Vec3, high: Vec3, p: Vec3) -> f32 {
    let gap = (low - p).max(p - high).max(Vec3::ZERO);
    gap.length_squared()
}

/// Returns the smallest squared distance to a leaf's triangles: to the plane where the foot lies within, else to
/// the sides.
#[inline(always)]
pub(super) fn leaf_square(leaf: &BvhLeaf, p: Vec3) -> f32 {
    let BvhLeaf { a, ab, ac } = leaf;
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
