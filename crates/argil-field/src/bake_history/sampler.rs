//! Evaluates points that lie close together.

use crate::{Evaluator, FAR, LANES, Program, Pruner, WORLD_LIMIT};
use argil_abi::{self as abi, GpuMaterial, Instruction};
use argil_math::{Aabb, Control};
use argil_scene::DistanceSampler;
use glam::Vec3;
use std::sync::{Mutex, PoisonError};

/// Fewer points, or fewer instructions, are not worth pruning.
const FEW_POINTS: usize = 8;
const FEW_INSTRUCTIONS: usize = 4;

/// How far off distances may be far from the surface, as a share of them. Few edits get there, and bakes take a third less time
/// than without it.
const FAR_TOLERANCE: f32 = 0.05;

/// Evaluates a program, pruned for each call's points. Any threads can call it.
pub(super) struct ProgramSampler<'a> {
    program: &'a Program,
    control: &'a Control,
    workers: Mutex<Vec<Worker<'a>>>,
    /// The box that the solid is cut off at.
    cut: Option<Aabb>,
}

struct Worker<'a> {
    pruner: Pruner<'a>,
    evaluator: Evaluator<'a>,
    list: Vec<Instruction>,
}

impl<'a> Worker<'a> {
    fn new(program: &'a Program) -> Self {
        Self {
            pruner: Pruner::new(program),
            evaluator: Evaluator::new(program),
            list: Vec::new(),
        }
    }

    /// Prepares the list for points.
    fn prune(&mut self, program: &Program, points: &[Vec3]) {
        let whole = program.instructions();
        self.list.clear();
        let around = Aabb::around(points.iter().copied());
        let center = around.center();
        let is_worthwhile = points.len() >= FEW_POINTS && whole.len() > FEW_INSTRUCTIONS;
        // Nothing is known around points outside of the world.
        let is_in_world = center.abs().max_element() < WORLD_LIMIT;
        if !is_worthwhile || !is_in_world {
            self.list.extend_from_slice(whole);
            return;
        }
        // A little more than half of the diagonal, because coordinates are rounded.
        let radius = 1.000_01 * (0.5 * around.size()).length();
        self.pruner
            .classify_cells(whole, &[center], radius, &mut [0.0]);
        self.pruner.prune_into(whole, 0, &mut self.list);
    }
}

impl<'a> ProgramSampler<'a> {
    pub(super) fn new(program: &'a Program, control: &'a Control) -> Self {
        Self {
            program,
            control,
            workers: Mutex::new(Vec::new()),
            cut: None,
        }
    }

    /// Cuts the solid off at a box.
    pub(super) fn cut_to(self, cut: Option<Aabb>) -> Self {
        Self { cut, ..self }
    }

    /// Returns how fast distances change at most: 1 for those that are exact.
    pub(super) fn steepness(&self) -> f32 {
        self.program.lipschitz().max(1.0)
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// Returns the index of the only material that points can have, as far as a list says that is pruned for all points between
    /// them.
    pub(super) fn sole_material(&self, points: &[Vec3]) -> Option<usize> {
        self.with_worker(points, |worker| {
            let brushes = worker.list.iter().filter(|instr| {
                instr.op < abi::OP_SHAPES_END && instr.flags & abi::FLAG_KEEP_MATERIAL == 0
            });
            let mut materials = brushes.map(|brush| brush.operand as usize);
            let first = materials.next()?;
            materials.all(|other| other == first).then_some(first)
        })
    }

    /// Lends a worker with a list that is pruned for points.
    fn with_worker<T>(&self, points: &[Vec3], work: impl FnOnce(&mut Worker<'a>) -> T) -> T {
        let idle = || self.workers.lock().unwrap_or_else(PoisonError::into_inner);
        let worker = idle().pop();
        let mut worker = worker.unwrap_or_else(|| Worker::new(self.program));
        worker.prune(self.program, points);
        let result = work(&mut worker);
        idle().push(worker);
        result
    }

    /// Evaluates points with a list that is pruned for them, at most [`LANES`] at once.
    fn each_batch(
        &self,
        points: &[Vec3],
        mut evaluate: impl FnMut(&mut Evaluator<'a>, &[Instruction], [&[f32]; 3], usize),
    ) {
        if self.control.is_cancelled() {
            return;
        }
        self.with_worker(points, |worker| {
            let mut axes = [[0.0; LANES]; 3];
            for (batch, places) in points.chunks(LANES).enumerate() {
                for (lane, place) in places.iter().enumerate() {
                    for (axis, values) in axes.iter_mut().enumerate() {
                        values[lane] = place[axis];
                    }
                }
                let axes = axes.each_ref().map(|values| &values[..places.len()]);
                evaluate(&mut worker.evaluator, &worker.list, axes, batch * LANES);
            }
        });
    }

    /// Evaluates the materials of points.
    pub(super) fn materials(&self, points: &[Vec3], out: &mut [GpuMaterial]) {
        let mut distances = [0.0; LANES];
        self.each_batch(points, |evaluator, list, axes, first| {
            let count = axes[0].len();
            let out = &mut out[first..first + count];
            evaluator.materials_with(list, axes, &mut distances[..count], out);
        });
    }
}

impl DistanceSampler for ProgramSampler<'_> {
    fn far_tolerance(&self) -> f32 {
        FAR_TOLERANCE
    }

    /// Bounds grow by what smooth brushes may add, and would do so with each bake.
    fn has_loose_box(&self) -> bool {
        true
    }

    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        if self.is_cancelled() {
            // Far from the surface, cells have no samples.
            out.fill(FAR);
            return;
        }
        self.each_batch(points, |evaluator, list, [x, y, z], first| {
            evaluator.distances_with(list, x, y, z, &mut out[first..first + x.len()]);
        });
        if let Some(cut) = self.cut {
            for (&point, d) in points.iter().zip(out) {
                let beyond = (point - cut.center()).abs() - 0.5 * cut.size();
                let of_box = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
                // NaN stays NaN, which a maximum would hide.
                *d = if *d < of_box { of_box } else { *d };
            }
        }
    }

    /// The surface is no nearer than this where distances are steep.
    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        self.distances(points, out);
        for d in out {
            *d = d.abs() / self.steepness();
        }
    }
}
