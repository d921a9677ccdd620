//! Signed distances to triangles.
//!
//! *Theory.* The nearest triangle is found in a tree of boxes; whether a point is inside, by how often the surface winds
//! around it (Jacobson, Kavan, Sorkine-Hornung 2013), where what is far counts as one small plate in the middle of its
//! triangles (Barill, Dickson, Schmidt, Levin, Jacobson 2018). More than half of a turn is inside, so that parts may cross one
//! another.
//!
//! *Practice.* Leaves hold up to [`WIDE`] triangles side by side, so that all are measured at once.

mod block;

use crate::repair::{Repairs, repair, solid_angle};
use crate::{Mesh, MeshInput};
use argil_math::{Aabb, Control};
use argil_scene::{Measure, SAMPLED_SIDE, SampledBlock, SampledGrid};
use glam::{DVec3, UVec3, Vec3};
use multiversion::multiversion;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Triangles of a leaf.
const WIDE: usize = 8;

/// The longest side of a solid's box: squares of squares of its triangles' sides are numbers still.
const SHORTEST: f32 = 1e-4;
const LONGEST: f32 = 1e5;

/// A node counts as one plate for points that are farther than so many of its radii.
const FAR_RADII: f32 = 2.3;

/// Three numbers of each triangle of a leaf.
type Wide3 = [[f32; WIDE]; 3];

/// A leaf's triangles: a corner, and the ways to the other two. What is missing is the first again.
#[derive(Clone)]
struct Leaf {
    a: Wide3,
    ab: Wide3,
    ac: Wide3,
}

#[derive(Clone)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// The two children from there on, or a leaf.
    first: u32,
    is_leaf: bool,
    /// Where its plate is, how large it is and how far its triangles reach from there.
    middle: Vec3,
    plate: Vec3,
    radius: f32,
}

/// A tree of boxes over triangles.
struct Tree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    corners: Vec<[Vec3; 3]>,
    /// Where each leaf's triangles begin among those.
    begins: Vec<(u32, u32)>,
    /// The box around each leaf.
    boxes: Vec<[Vec3; 2]>,
}

/// A solid whose surface is made of triangles.
pub struct Solid {
    /// The triangles that are between inside and outside.
    surface: Tree,
    /// All of them, which tell what is inside, where some are not of the surface: parts that lie within others.
    all: Option<Tree>,
    aabb: Aabb,
    repairs: Repairs,
}

impl Solid {
    /// Of triangles, which are repaired first.
    ///
    /// # Errors
    /// If none is left that has an area, or their box is too small or large to be measured in single precision.
    pub fn new(mesh: &Mesh) -> Result<Self, MeshInput> {
        let (mesh, repairs) = repair(mesh);
        if mesh.triangles.is_empty() {
            let held = Aabb::around([
                Vec3::from_slice(&repairs.sheet_box),
                Vec3::from_slice(&repairs.sheet_box[3..]),
            ]);
            return Err(if repairs.sheets > 0 {
                MeshInput::Sheets {
                    size: held.size().max_element(),
                }
            } else {
                MeshInput::Nothing
            });
        }
        // Corners of what was left out do not count.
        let bounds = Aabb::around((0..mesh.triangles.len()).flat_map(|i| mesh.corners(i)));
        let size = bounds.size().max_element();
        let away = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !(SHORTEST..=LONGEST).contains(&size) || away > LONGEST {
            return Err(MeshInput::Extent { size, away });
        }
        let mut tree = Tree::new((0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect());
        let mut all = None;
        // Parts can lie within others, or reach into them.
        if repairs.parts > 1 {
            let reach = 1e-5 * size;
            let outer: Vec<[Vec3; 3]> = tree
                .corners
                .par_iter()
                .filter(|corners| tree.is_surface(corners, reach))
                .copied()
                .collect();
            if !outer.is_empty() && outer.len() < tree.corners.len() {
                all = Some(std::mem::replace(&mut tree, Tree::new(outer)));
            }
        }
        Ok(Self {
            surface: tree,
            all,
            aabb: bounds,
            repairs,
        })
    }

    /// The box around it.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// What was done to its triangles.
    pub fn repairs(&self) -> &Repairs {
        &self.repairs
    }

    /// Triangles, those that close holes included.
    pub fn triangles(&self) -> usize {
        self.all.as_ref().unwrap_or(&self.surface).corners.len()
    }

    /// How often the surface winds around a point.
    pub fn winding(&self, p: Vec3) -> f64 {
        self.all.as_ref().unwrap_or(&self.surface).winding(p)
    }

    /// The signed distance at a point.
    pub fn distance(&self, p: Vec3) -> f32 {
        let mut out = [0.0];
        self.distances(&[p], &mut out);
        out[0]
    }

    /// The signed distances of points; the nearer each is to the one before, the faster.
    ///
    /// # Panics
    /// If there is no place for each.
    pub fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        assert_eq!(points.len(), out.len(), "a distance for each point");
        measure(self, points, out);
    }

    #[inline(always)]
    fn measure(&self, points: &[Vec3], out: &mut [f32]) {
        let mut stack = Vec::with_capacity(64);
        let mut before: Option<(Vec3, f32)> = None;
        let mut leaf = 0;
        for (&p, out) in points.iter().zip(out) {
            let way = before.map_or(f32::INFINITY, |(q, _)| p.distance(q));
            let (d, near) = self.surface.nearest(p, leaf, &mut stack);
            leaf = near;
            let is_in = match before {
                // Both lie in balls that no surface is in, and those touch.
                Some((_, last)) if last.abs() + d > way * 1.0001 => last < 0.0,
                _ => self.winding(p) > 0.5,
            };
            *out = if is_in { -d } else { d };
            before = Some((p, *out));
        }
    }

    /// Its distances in a box with room around it, `resolution` samples along the longest side of its own box.
    ///
    /// # Errors
    /// If no sample is inside.
    pub fn sample(&self, resolution: u32) -> Result<SampledGrid, MeshInput> {
        self.sample_controlled(resolution, &Control::default())
    }

    /// [`Solid::sample`], which can be stopped; how long it takes is not known beforehand.
    ///
    /// # Errors
    /// As there, and if it was cancelled.
    pub fn sample_controlled(
        &self,
        resolution: u32,
        control: &Control,
    ) -> Result<SampledGrid, MeshInput> {
        control.begin("distances to a mesh", 0);
        let spacing = self.aabb.size().max_element().max(1e-6) / resolution as f32;
        let cell = spacing * SAMPLED_SIDE as f32;
        let region = self.aabb.grown(2.0 * spacing);
        let cells = (region.size() / cell).ceil().as_uvec3().max(UVec3::ONE);
        let corner = region.center() - 0.5 * cell * cells.as_vec3();
        let watched = Watched {
            solid: self,
            control,
        };
        let grid = SampledGrid::sample(corner, cell, cells, self.aabb, &watched);
        control.end();
        if control.is_cancelled() {
            return Err(MeshInput::Cancelled);
        }
        if grid.has_inside() {
            Ok(grid)
        } else {
            Err(MeshInput::Hollow { resolution })
        }
    }
}

impl Tree {
    fn new(corners: Vec<[Vec3; 3]>) -> Self {
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

    /// Whether a triangle may be between inside and outside: it is not where both of its sides are in or out, in its middle and near
    /// its corners.
    fn is_surface(&self, corners: &[Vec3; 3], reach: f32) -> bool {
        let [a, b, c] = *corners;
        let middle = (a + b + c) / 3.0;
        let normal = reach * (b - a).cross(c - a).normalize_or_zero();
        let places = [middle, a, b, c].map(|corner| corner.lerp(middle, 0.1));
        places.into_iter().any(|p| {
            let is_in = |p: Vec3| self.winding(p) > 0.5;
            is_in(p - normal) != is_in(p + normal)
        })
    }

    fn build(&mut self) {
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

    /// The unsigned distance, and the leaf where it is; a leaf that is near is looked at first.
    #[inline(always)]
    fn nearest(&self, p: Vec3, hint: u32, stack: &mut Vec<(f32, u32)>) -> (f32, u32) {
        let best = leaf_square(&self.leaves[hint as usize], p);
        let (square, leaf) = self.nearer(p, (best, hint), stack);
        (square.sqrt(), leaf)
    }

    /// The least square of a distance, and the leaf where it is, of one that is known and all that are less.
    #[inline(always)]
    fn nearer(&self, p: Vec3, known: (f32, u32), stack: &mut Vec<(f32, u32)>) -> (f32, u32) {
        let (mut best, mut at_best) = known;
        stack.clear();
        stack.push((box_square(&self.nodes[0], p), 0));
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
            let [a, b] =
                [node.first, node.first + 1].map(|i| (box_square(&self.nodes[i as usize], p), i));
            if a.0 < b.0 {
                stack.extend([b, a]);
            } else {
                stack.extend([a, b]);
            }
        }
        (best, at_best)
    }

    /// How often the triangles wind around a point.
    fn winding(&self, p: Vec3) -> f64 {
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
                    // A triangle that is far is a plate, too.
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

impl Measure for Solid {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        Solid::distances(self, points, out);
    }

    fn length(&self, point: Vec3) -> f32 {
        self.surface.nearest(point, 0, &mut Vec::new()).0
    }

    fn block(&self, block: &SampledBlock, out: &mut [f32]) {
        measure_block(self, block, out);
    }
}

/// A solid that is no longer measured once that is cancelled.
struct Watched<'a> {
    solid: &'a Solid,
    control: &'a Control,
}

impl Measure for Watched<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        if !self.control.is_cancelled() {
            Measure::distances(self.solid, points, out);
        }
    }

    fn length(&self, point: Vec3) -> f32 {
        if self.control.is_cancelled() {
            return f32::INFINITY;
        }
        Measure::length(self.solid, point)
    }

    fn block(&self, block: &SampledBlock, out: &mut [f32]) {
        if !self.control.is_cancelled() {
            Measure::block(self.solid, block, out);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure_block(solid: &Solid, block: &SampledBlock, out: &mut [f32]) {
    block::measure(solid, block, out);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn measure(solid: &Solid, points: &[Vec3], out: &mut [f32]) {
    solid.measure(points, out);
}

fn placeholder() -> Node {
    summary(&[])
}

fn summary(triangles: &[[Vec3; 3]]) -> Node {
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
    Node {
        low: bounds.min,
        high: bounds.max,
        first: 0,
        is_leaf: false,
        middle,
        plate: plate.as_vec3(),
        radius: triangles.iter().flatten().map(reach).fold(0.0, f32::max),
    }
}

fn leaf(triangles: &[[Vec3; 3]]) -> Leaf {
    let mut leaf = Leaf {
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
fn box_square(node: &Node, p: Vec3) -> f32 {
    gap_square(node.low, node.high, p)
}

#[inline(always)]
fn gap_square(low: Vec3, high: Vec3, p: Vec3) -> f32 {
    let gap = (low - p).max(p - high).max(Vec3::ZERO);
    gap.length_squared()
}

/// The least squared distance to a leaf's triangles: to the plane where the foot lies within, else to the sides.
#[inline(always)]
fn leaf_square(leaf: &Leaf, p: Vec3) -> f32 {
    let Leaf { a, ab, ac } = leaf;
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
        // Each side's nearest point.
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
