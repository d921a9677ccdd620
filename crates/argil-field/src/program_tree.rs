//! Pruned programs in a tree, created when a point is first asked about.

use crate::scalar::SIMD_BLOCK;
use crate::{LANES, Program, Pruner, WORLD_LIMIT};
use argil_abi::Instruction;
use argil_math::Aabb;
use glam::{UVec3, Vec3};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, OnceLock};

/// Cells along a side of their parent cell.
const SIDE: u32 = 2;
const CELLS: usize = (SIDE * SIDE * SIDE) as usize;
/// Maximum depth.
const DEPTH: u32 = 7;
/// Edge of the cube, in edges of the program's box, because points around it are asked about too.
const ROOM: f32 = 4.0;
/// Programs of up to this many instructions are not refined.
const SHORT: usize = 16;
/// Longer programs must be half as long as their parent's.
const LONG: usize = 64;
/// The memory of a cell's children themselves, in instructions.
const NODES: i64 = (CELLS * size_of::<ProgramTreeNode>() / size_of::<Instruction>()) as i64;
/// The distance of the surface from cells that stay whole, in edges.
const FAR: f32 = 2.0;
/// The cost of a single point, in instructions, approximately.
const ALONE: usize = 24;
/// Shorter programs need no tree, and longer ones take too long for the first point.
const FEW: usize = 24;
const MANY: usize = 1 << 14;
/// Maximum instructions in all programs of a tree, approximately: 32 MiB.
const MAX_BYTES_TOTAL: i64 = 1 << 21;

/// A tree of pruned programs.
///
/// [`ProgramTree::program_at`] returns the program for a point, and the cell where it holds.
///
/// *Theory.* The instructions that a [`Pruner`] leaves for a cell give the program's values everywhere in the cell,
/// however far the surface is. So programs can be refined from coarse to fine. The cost of a point depends only on
/// the operands that are about as near as the nearest one, within a cell's size.
///
/// *Practice.* A cube around the program is cut into 2³ cells, and those again, where points are asked about. All
/// programs together are limited in memory. If the limit is reached, coarser programs serve. Threads share a tree.
#[derive(Debug)]
pub struct ProgramTree {
    corner: Vec3,
    edge: f32,
    root: ProgramTreeNode,
    /// Remaining instructions.
    room: AtomicI64,
}

/// The key of points outside the cube.
const OUTSIDE: u32 = u32::MAX;

#[derive(Debug)]
struct ProgramTreeNode {
    list: Arc<[Instruction]>,
    /// Whether the surface is far. Rays take long steps there, and seldom return.
    is_far: bool,
    /// Its children, once a point in it is asked about. `None` if it stays whole.
    cells: OnceLock<Option<Box<[ProgramTreeNode]>>>,
}

impl ProgramTreeNode {
    fn new(list: Arc<[Instruction]>, is_far: bool) -> Self {
        Self {
            list,
            is_far,
            cells: OnceLock::new(),
        }
    }
}

/// A node with its cell.
struct Asked<'a> {
    node: &'a ProgramTreeNode,
    corner: Vec3,
    edge: f32,
    depth: u32,
}

impl ProgramTree {
    /// Creates a tree for a program in a box. Returns `None` if the program has few instructions, or very many.
    pub fn new(program: &Program, around: Aabb) -> Option<Self> {
        let count = program.instructions().len();
        let edge = ROOM * around.size().max_element();
        let is_usual = edge > 0.0 && edge.is_finite() && (FEW..=MANY).contains(&count);
        is_usual.then(|| Self {
            corner: around.center() - 0.5 * edge,
            edge,
            root: ProgramTreeNode::new(program.instructions().into(), false),
            room: AtomicI64::new(MAX_BYTES_TOTAL),
        })
    }

    /// Returns the program for a point, and the cell where it holds. Returns `None` outside the tree's cube.
    /// `program` must be the tree's.
    pub fn program_at(&self, program: &Program, point: Vec3) -> Option<(&[Instruction], Aabb)> {
        let mut node = self.holds(point).then_some(&self.root)?;
        let (mut corner, mut edge) = (self.corner, self.edge);
        for depth in 0..DEPTH {
            let Some(cells) = self.cells(program, node, corner, edge, depth) else {
                break;
            };
            edge /= SIDE as f32;
            let place = place_of(point, corner, edge);
            corner += edge * place.as_vec3();
            node = &cells[index_of(place)];
        }
        Some((&node.list, Aabb::new(corner, corner + edge)))
    }

    fn holds(&self, point: Vec3) -> bool {
        let from = point - self.corner;
        let is_in = from.cmpge(Vec3::ZERO) & from.cmple(Vec3::splat(self.edge));
        is_in.all() && point.abs().max_element() < 0.5 * WORLD_LIMIT
    }

    /// Returns the children of a node.
    fn cells<'a>(
        &self,
        program: &Program,
        node: &'a ProgramTreeNode,
        corner: Vec3,
        edge: f32,
        depth: u32,
    ) -> Option<&'a [ProgramTreeNode]> {
        if node.list.len() <= SHORT || node.is_far {
            return None;
        }
        let make = || {
            // The finest cells leave room for coarser ones, which are worth more.
            if self.room.load(Ordering::Relaxed) < MAX_BYTES_TOTAL / 32 * i64::from(depth) {
                return None;
            }
            let mut pruner = Pruner::new(program);
            let cell_edge = edge / SIDE as f32;
            let centers: [Vec3; CELLS] = std::array::from_fn(|index| {
                corner + cell_edge * (place_of_index(index).as_vec3() + 0.5)
            });
            // Half of the diagonal, and rounding.
            let rounding = 4.0 * f32::EPSILON * (self.corner.abs().max_element() + self.edge);
            let half = 0.8661 * cell_edge + rounding;
            let mut distances = [0.0; CELLS];
            pruner.classify_cells(&node.list, &centers, half, &mut distances);
            let (mut list, mut taken) = (Vec::new(), NODES);
            let cells: Box<[ProgramTreeNode]> = (0..CELLS)
                .map(|index| {
                    list.clear();
                    pruner.prune_into(&node.list, index, &mut list);
                    let is_far = distances[index].abs() > FAR * cell_edge;
                    // A program that is hardly shorter is not worth its memory.
                    let is_shorter =
                        list.len() < node.list.len().min(LONG).max(node.list.len() / 2);
                    let held = if is_shorter {
                        taken += list.len() as i64;
                        list.as_slice().into()
                    } else {
                        node.list.clone()
                    };
                    ProgramTreeNode::new(held, is_far)
                })
                .collect();
            self.room.fetch_sub(taken, Ordering::Relaxed);
            Some(cells)
        };
        node.cells.get_or_init(make).as_deref()
    }

    /// Calls `visit` with points that share a program, by their indices, at most [`LANES`] at once. Points outside
    /// the tree's cube have none.
    pub fn each_list(
        &self,
        program: &Program,
        points: &[[f32; 3]],
        mut visit: impl FnMut(Option<&[Instruction]>, &[u32]),
    ) {
        let finest = self.edge / SIDE.pow(DEPTH) as f32;
        let mut keys: Vec<(u32, u32)> = (0..points.len() as u32)
            .map(|index| {
                let point = Vec3::from(points[index as usize]);
                (self.key_of(point, finest), index)
            })
            .collect();
        keys.sort_unstable();
        let inside = keys.partition_point(|&(key, _)| key != OUTSIDE);
        let mut nths: Vec<u32> = keys.iter().map(|&(_, index)| index).collect();
        for outside in nths.split_off(inside).chunks(LANES) {
            visit(None, outside);
        }
        let whole = Asked {
            node: &self.root,
            corner: self.corner,
            edge: self.edge,
            depth: 0,
        };
        self.descend(program, whole, (&keys[..inside], &nths), &mut visit);
    }

    /// Returns the cells that contain a point, from coarse to fine.
    fn key_of(&self, point: Vec3, finest: f32) -> u32 {
        if !self.holds(point) {
            return OUTSIDE;
        }
        let most = SIDE.pow(DEPTH) - 1;
        let place = ((point - self.corner) / finest).as_uvec3();
        let place = place.min(UVec3::splat(most));
        (0..DEPTH).fold(0, |key, level| {
            let child = (place >> level) & UVec3::splat(SIDE - 1);
            key | (index_of(child) as u32) << (3 * level)
        })
    }

    fn descend(
        &self,
        program: &Program,
        asked: Asked<'_>,
        (keys, nths): (&[(u32, u32)], &[u32]),
        visit: &mut impl FnMut(Option<&[Instruction]>, &[u32]),
    ) {
        let Asked {
            node,
            corner,
            edge,
            depth,
        } = asked;
        // Points that share a program are evaluated in blocks. If each of a few has its own program, they are
        // evaluated one by one.
        let blocks = keys.len().div_ceil(SIMD_BLOCK);
        let is_cut = depth < DEPTH && node.list.len() * blocks > ALONE * keys.len();
        let cells = is_cut.then(|| self.cells(program, node, corner, edge, depth));
        let Some(cells) = cells.flatten() else {
            for nths in nths.chunks(LANES) {
                visit(Some(&node.list), nths);
            }
            return;
        };
        let cell_edge = edge / SIDE as f32;
        let cell_of = |key: u32| (key >> (3 * (DEPTH - 1 - depth))) as usize % CELLS;
        let mut begin = 0;
        for some in keys.chunk_by(|a, b| cell_of(a.0) == cell_of(b.0)) {
            let index = cell_of(some[0].0);
            let asked = Asked {
                node: &cells[index],
                corner: corner + cell_edge * place_of_index(index).as_vec3(),
                edge: cell_edge,
                depth: depth + 1,
            };
            let nths = &nths[begin..begin + some.len()];
            begin += some.len();
            self.descend(program, asked, (some, nths), visit);
        }
    }
}

fn place_of(point: Vec3, corner: Vec3, edge: f32) -> UVec3 {
    ((point - corner) / edge)
        .as_uvec3()
        .min(UVec3::splat(SIDE - 1))
}

fn place_of_index(index: usize) -> UVec3 {
    let index = index as u32;
    UVec3::new(index % SIDE, index / SIDE % SIDE, index / (SIDE * SIDE))
}

fn index_of(place: UVec3) -> usize {
    (place.x + SIDE * (place.y + SIDE * place.z)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Evaluator;
    use argil_scene::{Brush, Scene, Shape};

    fn scene(count: u32) -> Scene {
        let mut scene = Scene::new();
        for i in 0..count {
            let along = |k: u32| 4.0 * ((i * k) % 97) as f32 / 97.0 - 2.0;
            let brush = match i % 4 {
                0 => Brush::new(Shape::sphere(0.3)),
                1 => Brush::new(Shape::cuboid([0.1, 0.4, 0.2])).smooth(0.1),
                2 => Brush::new(Shape::torus(0.3, 0.1)),
                _ => Brush::new(Shape::sphere(0.2)).subtract(),
            };
            let brush = brush.at([along(13), along(31), along(57)]);
            scene.push(brush).expect("a brush");
        }
        scene
    }

    fn points(count: u32) -> Vec<[f32; 3]> {
        let along = |i: u32, k: u32| 9.0 * ((i * k) % 1009) as f32 / 1009.0 - 4.5;
        let mut points: Vec<[f32; 3]> = (0..count)
            .map(|i| [along(i, 101), along(i, 307), along(i, 571)])
            .collect();
        // Sides of cells, what is out of the cube, and out of the world.
        points.extend([[0.0; 3], [2.0; 3], [-2.0, 2.0, 0.0], [50.0, 0.0, 0.0]]);
        points.extend([[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [1e30; 3]]);
        points
    }

    /// Lists give distances and gradients of the whole program, to the bit, wherever a point is, one at a time and
    /// together; and are far shorter.
    #[test]
    fn lists_are_the_whole_programs() {
        let program = Program::lower(&scene(400)).expect("a program");
        let tree = ProgramTree::new(&program, program.aabb()).expect("a tree");
        let mut evaluator = Evaluator::new(&program);
        let points = points(2_000);
        let (mut d, mut g) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let (mut visited, mut lengths) = (vec![0; points.len()], 0);
        tree.each_list(&program, &points, |list, nths| {
            let list = list.unwrap_or(program.instructions());
            lengths += list.len() * nths.len();
            let n = nths.len();
            let lanes = [0, 1, 2].map(|axis| -> Vec<f32> {
                nths.iter()
                    .map(|&index| points[index as usize][axis])
                    .collect()
            });
            let [gx, gy, gz] = &mut g;
            let gradients = [&mut gx[..n], &mut gy[..n], &mut gz[..n]];
            evaluator.gradients_with(
                list,
                lanes.each_ref().map(|l| &l[..]),
                &mut d[..n],
                gradients,
            );
            for (i, &index) in nths.iter().enumerate() {
                visited[index as usize] += 1;
                let (distance, gradient) = program.gradient(points[index as usize].into());
                assert_eq!(
                    d[i].to_bits(),
                    distance.to_bits(),
                    "{:?}",
                    points[index as usize]
                );
                let bits = [g[0][i], g[1][i], g[2][i]].map(f32::to_bits);
                assert_eq!(bits, gradient.to_array().map(f32::to_bits));
            }
        });
        assert!(visited.iter().all(|&times| times == 1));
        assert!(
            lengths < points.len() * 100,
            "{lengths} of {}",
            400 * points.len()
        );
        let mut beyond = 0;
        for &point in &points {
            let p = Vec3::from(point);
            let Some((list, cell)) = tree.program_at(&program, p) else {
                beyond += 1;
                continue;
            };
            assert!(cell.grown(1e-5).contains(p), "{p} {cell:?}");
            let mut distance = [0.0];
            evaluator.distances_with(list, &[p.x], &[p.y], &[p.z], &mut distance);
            assert_eq!(distance[0].to_bits(), program.distance(p).to_bits(), "{p}");
        }
        assert_eq!(beyond, 4);
    }

    /// Threads that ask at once get the same lists; memory stays within its bound.
    #[test]
    fn threads_share_a_tree() {
        let program = Program::lower(&scene(2_000)).expect("a program");
        let tree = ProgramTree::new(&program, program.aabb()).expect("a tree");
        let points = points(20_000);
        let ask = || -> Vec<usize> {
            let lists = points.iter().map(|&p| tree.program_at(&program, p.into()));
            lists
                .map(|list| list.map_or(0, |(list, _)| list.len()))
                .collect()
        };
        let (a, b) = std::thread::scope(|scope| {
            let other = scope.spawn(ask);
            (ask(), other.join().expect("no panic"))
        });
        assert_eq!(a, b);
        let room = tree.room.load(Ordering::Relaxed);
        assert!(room > -2 * 8 * 2_000, "{room}");
    }
}
