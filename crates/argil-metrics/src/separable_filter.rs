//! Weighted sums over windows that are products of a row and a column.

use rayon::prelude::*;

/// A channel of an image.
#[derive(Clone, Debug)]
pub(crate) struct FilterPlane {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f32>,
}

impl FilterPlane {
    pub(crate) fn from_fn(
        width: usize,
        height: usize,
        of: impl Fn(usize) -> f32 + Sync + Send,
    ) -> Self {
        Self {
            width,
            height,
            values: (0..width * height).into_par_iter().map(of).collect(),
        }
    }

    /// Returns weighted sums along rows with one window, and then along columns with another. Both have an odd
    /// number of weights, centered on the pixel. Pixels at the border repeat beyond it.
    pub(crate) fn filtered(&self, row: &[f32], column: &[f32]) -> Self {
        let (width, height) = (self.width, self.height);
        let along = |length: usize, weights: &[f32], at: usize, get: &dyn Fn(usize) -> f32| {
            let reach = weights.len() / 2;
            let clamped = |i: usize| (at + i).saturating_sub(reach).min(length - 1);
            let terms = weights.iter().enumerate();
            terms.map(|(i, w)| w * get(clamped(i))).sum::<f32>()
        };
        let rows = Self::from_fn(width, height, |i| {
            let (x, y) = (i % width, i / width);
            let line = &self.values[y * width..(y + 1) * width];
            along(width, row, x, &|x| line[x])
        });
        Self::from_fn(width, height, |i| {
            let (x, y) = (i % width, i / width);
            along(height, column, y, &|y| rows.values[y * width + x])
        })
    }
}
