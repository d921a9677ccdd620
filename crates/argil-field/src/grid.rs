use crate::{Evaluator, LANES, Program};
use glam::{UVec3, Vec3};
use rayon::prelude::*;

/// Points on a regular lattice: `min + spacing * (i, j, k)`, x fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The first point.
    pub min: Vec3,
    /// Between points.
    pub spacing: Vec3,
    /// Points along each axis.
    pub size: UVec3,
}

impl Grid {
    /// `n` points along each axis from `min` to `max`, both ends included.
    pub fn spanning(min: Vec3, max: Vec3, n: u32) -> Self {
        Self {
            min,
            spacing: (max - min) / (n.max(2) - 1) as f32,
            size: UVec3::splat(n),
        }
    }
}

impl Program {
    /// The distances of a grid's points, `out[i + nx * (j + ny * k)]`, on rayon's current threads.
    ///
    /// # Panics
    /// If `out` has another length than the grid has points.
    pub fn distances(&self, grid: &Grid, out: &mut [f32]) {
        let [nx, ny, nz] = grid.size.to_array().map(|n| n as usize);
        assert_eq!(
            out.len(),
            nx * ny * nz,
            "one distance for each point of the grid"
        );
        if out.is_empty() {
            return;
        }
        let along = |n: usize, axis: usize| -> Vec<f32> {
            (0..n)
                .map(|i| grid.min[axis] + grid.spacing[axis] * i as f32)
                .collect()
        };
        let xs = along(nx, 0);
        // One slab of constant z at a time; within it, batches run on over the ends of rows.
        out.par_chunks_mut(nx * ny).enumerate().for_each_init(
            || Evaluator::new(self),
            |evaluator, (k, slab)| {
                let z = [grid.min.z + grid.spacing.z * k as f32; LANES];
                let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
                for (batch, out) in slab.chunks_mut(LANES).enumerate() {
                    let first = batch * LANES;
                    // The batch may hold the end of one row, whole rows and the beginning of another.
                    let mut lane = 0;
                    while lane < out.len() {
                        let (i, j) = ((first + lane) % nx, (first + lane) / nx);
                        let run = (nx - i).min(out.len() - lane);
                        x[lane..lane + run].copy_from_slice(&xs[i..i + run]);
                        y[lane..lane + run].fill(grid.min.y + grid.spacing.y * j as f32);
                        lane += run;
                    }
                    let n = out.len();
                    evaluator.distances(&x[..n], &y[..n], &z[..n], out);
                }
            },
        );
    }
}
