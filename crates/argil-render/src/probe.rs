//! Evaluates the field for one thread.

use crate::ray_batch::Points;
use argil_abi::GpuMaterial;
use argil_field::{Evaluator, LANES, NearEvaluator, NearField, Program, Pruner};

/// Evaluates the field for one thread.
#[derive(Debug)]
pub struct FieldProbe<'a> {
    pub(crate) program: &'a Program,
    pub(crate) evaluator: Evaluator<'a>,
    pub(crate) pruner: Pruner<'a>,
    near: Option<NearEvaluator<'a>>,
}

impl<'a> FieldProbe<'a> {
    pub fn new(program: &'a Program, near: Option<&'a NearField<'a>>) -> Self {
        Self {
            program,
            evaluator: Evaluator::new(program),
            pruner: Pruner::new(program),
            near: near.map(NearEvaluator::new),
        }
    }

    /// Whether each point uses the program near it.
    pub fn is_near(&self) -> bool {
        self.near.is_some()
    }

    /// Returns the number of points to evaluate at once. Points near each other share a program.
    pub fn batch(&self) -> usize {
        if self.is_near() { usize::MAX } else { LANES }
    }

    /// Returns the distance beyond which results are clamped.
    pub fn far(&self) -> f32 {
        self.near
            .as_ref()
            .map_or(f32::INFINITY, NearEvaluator::far_length)
    }

    /// Computes the distances of points into their `d`.
    pub fn measure(&mut self, points: &mut Points) {
        let Points { x, y, z, d } = points;
        d.resize(x.len(), 0.0);
        if let Some(near) = &mut self.near {
            near.distances([x, y, z], d);
            return;
        }
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let out = &mut d[r.clone()];
            self.evaluator
                .distances(&x[r.clone()], &y[r.clone()], &z[r], out);
        }
    }

    /// Computes the materials of points on the surface.
    pub fn materials(&mut self, points: &mut Points, out: &mut [GpuMaterial]) {
        let Points { x, y, z, d } = points;
        if let Some(near) = &mut self.near {
            near.materials([x, y, z], out);
            return;
        }
        d.resize(x.len(), 0.0);
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let (d, out) = (&mut d[r.clone()], &mut out[r.clone()]);
            self.evaluator
                .materials(&x[r.clone()], &y[r.clone()], &z[r], d, out);
        }
    }
}
