//! Evaluates the field for one thread.

use crate::ray_batch::Points;
use argil_abi::{GpuMaterial, Instruction};
use argil_field::{CELLS_PER_BATCH, Evaluator, LANES, NearEvaluator, NearField, Program, Pruner};
use glam::{Vec3, vec3};
use std::ops::Range;

/// Evaluates the field for one thread.
#[derive(Debug)]
pub struct FieldProbe<'a> {
    pub(crate) program: &'a Program,
    pub(crate) evaluator: Evaluator<'a>,
    pub(crate) pruner: Pruner<'a>,
    near: Option<NearEvaluator<'a>>,
    /// The pruned program of a batch of points.
    list: Vec<Instruction>,
    batches: PointBatches,
}

impl<'a> FieldProbe<'a> {
    pub fn new(program: &'a Program, near: Option<&'a NearField<'a>>) -> Self {
        Self {
            program,
            evaluator: Evaluator::new(program),
            pruner: Pruner::new(program),
            near: near.map(NearEvaluator::new),
            list: Vec::new(),
            batches: PointBatches::default(),
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

    /// Computes the distances of points into their `d`. Batches of points that are close together use a pruned program.
    pub fn measure(&mut self, points: &mut Points) {
        let Points { x, y, z, d, .. } = points;
        d.resize(x.len(), 0.0);
        if let Some(near) = &mut self.near {
            near.distances([x, y, z], d);
            return;
        }
        if x.len() <= LANES {
            self.evaluator.distances(x, y, z, d);
            return;
        }
        self.each_batch([x, y, z], |evaluator, list, p, r| {
            evaluator.distances_with(list, p[0], p[1], p[2], &mut d[r]);
        });
    }

    /// Calls a function for batches of points, with the pruned programs around them.
    fn each_batch(
        &mut self,
        [x, y, z]: [&[f32]; 3],
        mut each: impl FnMut(&mut Evaluator<'a>, &[Instruction], [&[f32]; 3], Range<usize>),
    ) {
        self.batches.prepare([x, y, z]);
        while let Some(radius) = self.batches.take() {
            let centers = &self.batches.centers;
            let mut at_centers = [0.0; CELLS_PER_BATCH];
            let all = self.program.instructions();
            let out = &mut at_centers[..centers.len()];
            self.pruner.classify_cells(all, centers, radius, out);
            for (cell, &batch) in self.batches.taken.iter().enumerate() {
                self.list.clear();
                self.pruner.prune_into(all, cell, &mut self.list);
                let r = batch_range(batch, x.len());
                let p = [&x[r.clone()], &y[r.clone()], &z[r.clone()]];
                each(&mut self.evaluator, &self.list, p, r);
            }
        }
    }

    /// Computes the materials of points on the surface.
    pub fn materials(&mut self, points: &mut Points, out: &mut [GpuMaterial]) {
        let Points { x, y, z, d, .. } = points;
        if let Some(near) = &mut self.near {
            near.materials([x, y, z], out);
            return;
        }
        d.resize(x.len(), 0.0);
        self.each_batch([x, y, z], |evaluator, list, p, r| {
            evaluator.materials_with(list, p, &mut d[r.clone()], &mut out[r]);
        });
    }
}

/// Batches of points that follow one another, with the spheres that contain them.
#[derive(Debug, Default)]
struct PointBatches {
    /// The batches left, the largest radius first.
    left: Vec<(f32, u32, Vec3)>,
    /// The batches that are pruned together.
    taken: Vec<u32>,
    centers: Vec<Vec3>,
}

impl PointBatches {
    fn prepare(&mut self, [x, y, z]: [&[f32]; 3]) {
        self.left.clear();
        for batch in 0..x.len().div_ceil(LANES) as u32 {
            let r = batch_range(batch, x.len());
            let range = |lanes: &[f32]| {
                let ends = (f32::INFINITY, f32::NEG_INFINITY);
                let widen = |(low, high): (f32, f32), &c: &f32| (low.min(c), high.max(c));
                lanes[r.clone()].iter().fold(ends, widen)
            };
            let [(ax, bx), (ay, by), (az, bz)] = [range(x), range(y), range(z)];
            let (low, high) = (vec3(ax, ay, az), vec3(bx, by, bz));
            let radius = 0.500_1 * low.distance(high);
            self.left.push((radius, batch, 0.5 * (low + high)));
        }
        self.left.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    }

    /// Takes batches of about one size, and returns the largest radius. `None` if none is left.
    fn take(&mut self) -> Option<f32> {
        self.taken.clear();
        self.centers.clear();
        let (mut smallest, mut largest) = (0.0f32, 0.0f32);
        while let Some(&(radius, batch, center)) = self.left.last() {
            let is_full = self.taken.len() == CELLS_PER_BATCH;
            if is_full || (!self.taken.is_empty() && radius > 2.0 * smallest) {
                break;
            }
            if self.taken.is_empty() {
                smallest = radius;
            }
            largest = radius;
            self.left.pop();
            self.taken.push(batch);
            self.centers.push(center);
        }
        (!self.taken.is_empty()).then_some(largest)
    }
}

/// Returns the points of a batch.
fn batch_range(batch: u32, count: usize) -> Range<usize> {
    let first = batch as usize * LANES;
    first..(first + LANES).min(count)
}
