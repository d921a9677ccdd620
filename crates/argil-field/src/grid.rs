use crate::{Evaluator, LANES, Program};
use glam::{UVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The points of a regular grid: `min + spacing * (begin + (i, j, k))`, x fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The grid's origin.
    pub min: Vec3,
    /// The distance between points.
    pub spacing: Vec3,
    /// The first point, in steps from the origin. Parts of one grid have the same points, bit for bit.
    pub begin: UVec3,
    /// Number of points along each axis.
    pub size: UVec3,
}

impl Grid {
    /// Creates `n` points along each axis from `min` to `max`, including both ends.
    pub fn spanning(min: Vec3, max: Vec3, n: u32) -> Self {
        Self {
            min,
            spacing: (max - min) / (n.max(2) - 1) as f32,
            begin: UVec3::ZERO,
            size: UVec3::splat(n),
        }
    }

    /// Returns the number of points.
    #[expect(
        clippy::len_without_is_empty,
        reason = "a grid of no points is nothing to ask for"
    )]
    pub fn len(&self) -> usize {
        self.layer_len().saturating_mul(self.size.z as usize)
    }

    /// Returns the number of points in a layer of constant z.
    pub fn layer_len(&self) -> usize {
        self.size.x as usize * self.size.y as usize
    }

    /// Returns the points' coordinates along an axis.
    pub fn coordinates(&self, axis: usize) -> Vec<f32> {
        let n = self.size[axis] as usize;
        (0..n).map(|i| self.at(axis, i)).collect()
    }

    #[inline]
    fn at(&self, axis: usize, i: usize) -> f32 {
        self.min[axis] + self.spacing[axis] * (self.begin[axis] + i as u32) as f32
    }

    /// Computes the distances of layer `k`, batch after batch. `visit` receives the position of each batch in the
    /// layer, and its values. `xs` are the points' [`Grid::coordinates`] along x.
    ///
    /// # Panics
    /// If `xs` is not as long as the grid is wide.
    pub fn sweep_layer(
        &self,
        evaluator: &mut Evaluator<'_>,
        xs: &[f32],
        k: u32,
        mut emit: impl FnMut(Range<usize>, &[f32]),
    ) {
        let nx = self.size.x as usize;
        assert_eq!(xs.len(), nx, "a coordinate for each point of a row");
        let at = |axis: usize, i: usize| self.at(axis, i);
        let z = [at(2, k as usize); LANES];
        let (mut x, mut y, mut d) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for first in (0..self.layer_len()).step_by(LANES) {
            let n = LANES.min(self.layer_len() - first);
            // A batch may hold the end of one row, whole rows, and the start of another.
            let mut lane = 0;
            while lane < n {
                let (i, j) = ((first + lane) % nx, (first + lane) / nx);
                let run = (nx - i).min(n - lane);
                x[lane..lane + run].copy_from_slice(&xs[i..i + run]);
                y[lane..lane + run].fill(at(1, j));
                lane += run;
            }
            evaluator.distances(&x[..n], &y[..n], &z[..n], &mut d[..n]);
            emit(first..first + n, &d[..n]);
        }
    }
}

impl Program {
    /// Computes the distances of a grid's points into `out[i + nx * (j + ny * k)]`, on rayon's current threads.
    ///
    /// # Panics
    /// If `out` has another length than the grid has points.
    pub fn distances(&self, grid: &Grid, out: &mut [f32]) {
        assert_eq!(
            out.len(),
            grid.layer_len() * grid.size.z as usize,
            "one distance for each point of the grid"
        );
        if out.is_empty() {
            return;
        }
        let xs = grid.coordinates(0);
        out.par_chunks_mut(grid.layer_len())
            .enumerate()
            .for_each_init(
                || Evaluator::new(self),
                |evaluator, (k, layer)| {
                    grid.sweep_layer(evaluator, &xs, k as u32, |range, d| {
                        layer[range].copy_from_slice(d);
                    });
                },
            );
    }
}
