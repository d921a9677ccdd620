//! Bakes one level of a dense volume with pruned programs. Its twin `fill.wgsl` evaluates the whole program.
//!
//! *Theory.* The grid is cut into slabs, slabs into columns, and columns into cells of 8³ points. Each has the
//! instructions that can matter there (`argil_field::Pruner`). A cell whose center distance proves that all its
//! samples are saturated is not evaluated. The samples equal the whole program's, bit for bit.

use crate::encoding::encode;
use crate::{Texel, Texels};
use argil_abi::{FillUniform, Instruction};
use argil_field::{CELLS_PER_BATCH, Evaluator, Grid, LANES, Program, Pruner};
use argil_math::{Aabb, Control};
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;
use std::mem::take;
use std::ops::Range;

/// Points along a cell's side.
const SIDE: u32 = 8;
/// Cells along a column's side.
const COLUMN: u32 = 4;
/// Layers of a cell that fill a batch.
const BATCH_LAYERS: u32 = LANES as u32 / (SIDE * SIDE);

/// Returns the value of a cell that is not sampled, given its first point.
pub(crate) type Vacant<'a, T> = &'a (dyn Fn(UVec3) -> Option<T> + Sync);

/// Samples all points of a level's grid, except in vacant cells.
pub(crate) fn sample<T: Texel>(
    program: &Program,
    grid: &Grid,
    fill: &FillUniform,
    vacant: Vacant<'_, T>,
    control: &Control,
) -> Texels {
    let size = grid.size;
    let layer = grid.layer_len();
    let mut texels = vec![T::default(); layer * size.z as usize];
    control.begin("layers", size.z.into());
    texels
        .par_chunks_mut(layer * SIDE as usize)
        .zip((0..size.z).into_par_iter().step_by(SIDE as usize))
        .for_each_init(
            || LevelBaker::new(program, grid, fill, vacant),
            |worker, (slab, z)| {
                if !control.is_cancelled() {
                    worker.slab(slab, z);
                }
                control.advance(SIDE.min(size.z - z).into());
            },
        );
    Texels::from_vec(texels)
}

/// The state of a thread.
struct LevelBaker<'a, T> {
    program: &'a Program,
    grid: &'a Grid,
    fill: &'a FillUniform,
    vacant: Vacant<'a, T>,
    pruner: Pruner<'a>,
    evaluator: Evaluator<'a>,
    /// Pruned programs of some columns, and of the cells of a column.
    columns: LevelParts,
    cells: LevelParts,
    /// Positions of points along x and along y.
    x: Vec<f32>,
    y: Vec<f32>,
}

/// Cells by their first points, each with its range of a shared list.
#[derive(Default)]
struct LevelParts {
    instructions: Vec<Instruction>,
    stretches: Vec<(UVec3, Range<usize>)>,
}

impl<'a, T: Texel> LevelBaker<'a, T> {
    fn new(
        program: &'a Program,
        grid: &'a Grid,
        fill: &'a FillUniform,
        vacant: Vacant<'a, T>,
    ) -> Self {
        Self {
            program,
            grid,
            fill,
            vacant,
            pruner: Pruner::new(program),
            evaluator: Evaluator::new(program),
            columns: LevelParts::default(),
            cells: LevelParts::default(),
            x: grid.coordinates(0),
            y: grid.coordinates(1),
        }
    }

    /// Bakes eight layers of the grid, from layer `z` on.
    fn slab(&mut self, texels: &mut [T], z: u32) {
        let edge = SIDE * COLUMN;
        let size = self.grid.size;
        let all: Vec<UVec3> = (0..size.y)
            .step_by(edge as usize)
            .flat_map(|y| {
                (0..size.x)
                    .step_by(edge as usize)
                    .map(move |x| uvec3(x, y, z))
            })
            .collect();
        let (mut columns, mut cells) = (take(&mut self.columns), take(&mut self.cells));
        for begins in all.chunks(CELLS_PER_BATCH) {
            let instructions = self.program.instructions();
            self.part(
                instructions,
                begins,
                uvec3(edge, edge, SIDE),
                &mut columns,
                texels,
            );
            for (begin, stretch) in &columns.stretches {
                let inner: [UVec3; (COLUMN * COLUMN) as usize] = std::array::from_fn(|i| {
                    *begin + SIDE * uvec3(i as u32 % COLUMN, i as u32 / COLUMN, 0)
                });
                let instructions = &columns.instructions[stretch.clone()];
                self.part(instructions, &inner, UVec3::splat(SIDE), &mut cells, texels);
                for (begin, stretch) in &cells.stretches {
                    self.evaluate(&cells.instructions[stretch.clone()], *begin, texels);
                }
            }
        }
        (self.columns, self.cells) = (columns, cells);
    }

    /// Prunes a program for cells of `size` points. Saturated cells are stored at once.
    fn part(
        &mut self,
        instructions: &[Instruction],
        begins: &[UVec3],
        size: UVec3,
        parts: &mut LevelParts,
        texels: &mut [T],
    ) {
        // The distance between the outermost points of a cell.
        let span = self.grid.spacing * (size - 1).as_vec3();
        let half_diagonal = 0.5 * span.length();
        let mut centers = [Vec3::ZERO; CELLS_PER_BATCH];
        let mut d = [0.0; CELLS_PER_BATCH];
        for (center, begin) in centers.iter_mut().zip(begins) {
            *center = self.grid.min + self.grid.spacing * begin.as_vec3() + 0.5 * span;
        }
        let (centers, d) = (&centers[..begins.len()], &mut d[..begins.len()]);
        self.pruner
            .classify_cells(instructions, centers, half_diagonal, d);

        // The distance that is stored as 1.0, with the bias.
        let range = self.fill.max_code as f32 / self.fill.spacing_scale[3];
        let around = Aabb::around(centers.iter().copied()).grown(half_diagonal);
        let away = 1.000_01
            * (range + self.fill.first_bias[3] + self.program.lipschitz() * half_diagonal)
            + self.program.bound_error(around);
        parts.instructions.clear();
        parts.stretches.clear();
        for (i, (&begin, &d)) in begins.iter().zip(d.iter()).enumerate() {
            if begin.cmpge(self.grid.size).any() {
                continue;
            }
            if d.abs() > away {
                self.store_saturated(begin, size, d, texels);
                continue;
            }
            if size == UVec3::splat(SIDE)
                && let Some(value) = (self.vacant)(begin)
            {
                self.store(begin, value, texels);
                continue;
            }
            let from = parts.instructions.len();
            self.pruner
                .prune_into(instructions, i, &mut parts.instructions);
            parts
                .stretches
                .push((begin, from..parts.instructions.len()));
        }
    }

    /// Returns the size of a cell within the grid.
    fn held(&self, begin: UVec3, size: UVec3) -> UVec3 {
        (begin + size).min(self.grid.size) - begin
    }

    /// Stores cells whose samples all have the smallest or the largest code.
    fn store_saturated(&self, begin: UVec3, size: UVec3, d: f32, texels: &mut [T]) {
        let mut stored = [T::default()];
        encode(&[d], self.fill, &mut stored);
        let held = self.held(begin, size);
        for j in (0..held.y).step_by(SIDE as usize) {
            for i in (0..held.x).step_by(SIDE as usize) {
                let cell = begin + uvec3(i, j, 0);
                self.store(cell, (self.vacant)(cell).unwrap_or(stored[0]), texels);
            }
        }
    }

    /// Stores one value in a cell.
    fn store(&self, begin: UVec3, value: T, texels: &mut [T]) {
        let held = self.held(begin, UVec3::splat(SIDE));
        for k in 0..held.z {
            for j in 0..held.y {
                let row = self.row(begin, j, k);
                texels[row..row + held.x as usize].fill(value);
            }
        }
    }

    /// Returns the index of a row of a cell in its slab.
    fn row(&self, begin: UVec3, j: u32, k: u32) -> usize {
        let width = self.grid.size.x as usize;
        k as usize * self.grid.layer_len() + (begin.y + j) as usize * width + begin.x as usize
    }

    /// Evaluates a cell of [`SIDE`]³ points with its own program.
    fn evaluate(&mut self, instructions: &[Instruction], begin: UVec3, texels: &mut [T]) {
        let held = self.held(begin, UVec3::splat(SIDE));
        let [mut x, mut y, mut z, mut d] = [[0.0f32; LANES]; 4];
        let mut out = [T::default(); LANES];
        for first in (0..held.z).step_by(BATCH_LAYERS as usize) {
            let layers = BATCH_LAYERS.min(held.z - first);
            let mut n = 0;
            for k in first..first + layers {
                let at_z = self.grid.min.z
                    + self.grid.spacing.z * (self.grid.begin.z + begin.z + k) as f32;
                for j in 0..held.y {
                    let to = n..n + held.x as usize;
                    let from = begin.x as usize;
                    x[to.clone()].copy_from_slice(&self.x[from..from + held.x as usize]);
                    y[to.clone()].fill(self.y[(begin.y + j) as usize]);
                    z[to.clone()].fill(at_z);
                    n = to.end;
                }
            }
            self.evaluator
                .distances_with(instructions, &x[..n], &y[..n], &z[..n], &mut d[..n]);
            encode(&d[..n], self.fill, &mut out[..n]);
            let mut rows = out[..n].chunks_exact(held.x as usize);
            for k in first..first + layers {
                for j in 0..held.y {
                    if let Some(values) = rows.next() {
                        let row = self.row(begin, j, k);
                        texels[row..row + values.len()].copy_from_slice(values);
                    }
                }
            }
        }
    }
}
