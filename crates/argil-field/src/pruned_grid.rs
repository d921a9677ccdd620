//! Computes the distances of a grid's points with pruned programs.
//!
//! *Practice.* A slab of eight layers is cut into columns of 32 × 32 points, and those into cells of 8³, each with
//! its own program: see [`Pruner`]. In a cell, its program gives the whole program's bits.

use crate::{CELLS_PER_BATCH, Evaluator, Grid, LANES, Program, Pruner, WORLD_LIMIT};
use argil_abi::Instruction;
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;

/// Points along a cell's side.
const SIDE: u32 = 8;
/// Cells along a column's side.
const COLUMN: u32 = 4;
/// Programs of fewer instructions are not worth pruning.
const FEW: usize = 4;

impl Program {
    /// Computes what [`Program::distances`] computes, bit for bit, much faster for many brushes.
    ///
    /// ```
    /// # use argil_field::{Grid, Program};
    /// # use argil_scene::{Brush, Scene, Shape};
    /// # let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(1.0))).unwrap();
    /// let program = Program::lower(&scene)?;
    /// let grid = Grid::spanning([-2.0; 3].into(), [2.0; 3].into(), 33);
    /// let mut distances = vec![0.0; 33 * 33 * 33];
    /// program.distances_pruned(&grid, &mut distances);
    /// assert_eq!(distances[16 + 33 * (16 + 33 * 16)], -1.0);
    /// # Ok::<(), argil_field::LowerError>(())
    /// ```
    ///
    /// # Panics
    /// If `out` has another length than the grid has points.
    pub fn distances_pruned(&self, grid: &Grid, out: &mut [f32]) {
        let points = grid.layer_len() * grid.size.z as usize;
        assert_eq!(out.len(), points, "one distance for each point of the grid");
        if self.instructions().len() <= FEW || out.is_empty() {
            return self.distances(grid, out);
        }
        out.par_chunks_mut(grid.layer_len() * SIDE as usize)
            .enumerate()
            .for_each_init(
                || PrunedGridWorker::new(self, grid),
                |worker, (index, slab)| worker.slab(slab, index as u32 * SIDE),
            );
    }
}

/// The state of a thread.
struct PrunedGridWorker<'a> {
    grid: &'a Grid,
    whole: &'a [Instruction],
    coordinates: [Vec<f32>; 3],
    pruner: Pruner<'a>,
    evaluator: Evaluator<'a>,
}

impl<'a> PrunedGridWorker<'a> {
    fn new(program: &'a Program, grid: &'a Grid) -> Self {
        Self {
            grid,
            whole: program.instructions(),
            coordinates: [0, 1, 2].map(|axis| grid.coordinates(axis)),
            pruner: Pruner::new(program),
            evaluator: Evaluator::new(program),
        }
    }

    /// Computes eight layers from layer `z` on.
    fn slab(&mut self, out: &mut [f32], z: u32) {
        let edge = SIDE * COLUMN;
        let columns = self.begins(uvec3(0, 0, z), edge, self.grid.size);
        for columns in columns.chunks(CELLS_PER_BATCH) {
            let lists = self.lists(self.whole, columns, uvec3(edge, edge, SIDE));
            for (&column, list) in columns.iter().zip(&lists) {
                let end = (column + edge).min(self.grid.size);
                let cells = self.begins(column, SIDE, end);
                let lists = self.lists(list, &cells, UVec3::splat(SIDE));
                for (&cell, list) in cells.iter().zip(&lists) {
                    self.cell(list, cell, out, z);
                }
            }
        }
    }

    /// Returns the first points of adjacent parts in a layer, from a point to before another.
    fn begins(&self, from: UVec3, side: u32, end: UVec3) -> Vec<UVec3> {
        let along = |axis: usize| (from[axis]..end[axis]).step_by(side as usize);
        let row = |y: u32| along(0).map(move |x| uvec3(x, y, from.z));
        along(1).flat_map(row).collect()
    }

    /// Prunes a program for parts of a size.
    fn lists(
        &mut self,
        list: &[Instruction],
        begins: &[UVec3],
        size: UVec3,
    ) -> Vec<Vec<Instruction>> {
        let reach = 0.5 * self.grid.spacing * (size - 1).as_vec3();
        let centers: Vec<Vec3> = begins
            .iter()
            .map(|begin| {
                let at = |axis: usize| self.coordinates[axis][begin[axis] as usize];
                Vec3::new(at(0), at(1), at(2)) + reach
            })
            .collect();
        // A part whose center is outside the world says nothing about the points inside.
        let is_in_world = |c: &Vec3| c.abs().max_element() < WORLD_LIMIT;
        if !centers.iter().all(is_in_world) {
            return vec![list.to_vec(); begins.len()];
        }
        // A little more than half of the diagonal, because coordinates are rounded.
        let radius = 1.000_01 * reach.length();
        let mut d = [0.0; CELLS_PER_BATCH];
        self.pruner
            .classify_cells(list, &centers, radius, &mut d[..centers.len()]);
        let prune = |index: usize| {
            let mut pruned = Vec::new();
            self.pruner.prune_into(list, index, &mut pruned);
            pruned
        };
        (0..centers.len()).map(prune).collect()
    }

    /// Computes the points of a cell with its own program.
    fn cell(&mut self, list: &[Instruction], begin: UVec3, out: &mut [f32], first_layer: u32) {
        let size = self.grid.size;
        let end = (begin + SIDE).min(size);
        let row = (end.x - begin.x) as usize;
        let [mut x, mut y, mut z, mut d] = [[0.0f32; LANES]; 4];
        let rows = (begin.z..end.z).flat_map(|k| (begin.y..end.y).map(move |j| (j, k)));
        let rows: Vec<(u32, u32)> = rows.collect();
        for rows in rows.chunks(LANES / SIDE as usize) {
            let n = row * rows.len();
            for (lane, &(j, k)) in (0..n).step_by(row).zip(rows) {
                let from = begin.x as usize;
                x[lane..lane + row].copy_from_slice(&self.coordinates[0][from..from + row]);
                y[lane..lane + row].fill(self.coordinates[1][j as usize]);
                z[lane..lane + row].fill(self.coordinates[2][k as usize]);
            }
            let (d, evaluator) = (&mut d[..n], &mut self.evaluator);
            evaluator.distances_with(list, &x[..n], &y[..n], &z[..n], d);
            for (d, &(j, k)) in d.chunks_exact(row).zip(rows) {
                let layer = (k - first_layer) as usize * self.grid.layer_len();
                let to = layer + j as usize * size.x as usize + begin.x as usize;
                out[to..to + row].copy_from_slice(d);
            }
        }
    }
}
