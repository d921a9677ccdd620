//! Samples where each material is, as solids to paint with.
//!
//! *Theory.* The first material fills everything, and each other one is painted over those before it. The weight of paint at
//! distance `d` from its solid is `0.5 − d / k`, between 0 and 1, with a softness `k`. So a sample of `k (0.5 − a)` gives the weight `a`. For
//! shares `s` of the materials, the weight of one is its share of what the later ones leave: `s / (1 − Σ later s)`.
//!
//! *Practice.* Only cells that a border crosses need samples. Elsewhere, the distance grows with the number of cells to the
//! nearest of these, along the largest axis, so that corners of cells are enough. So they are in the air, where nobody sees the
//! border: in cells that are farther from the solid than it would take.

use super::lattice::Lattice;
use super::sampler::ProgramSampler;
use crate::Program;
use argil_abi::{self as abi, GpuMaterial};
use argil_math::{Aabb, Control};
use argil_scene::{DistanceSampler, SAMPLED_SIDE, SampledGrid, Scene};
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeSet, VecDeque};

/// The length over which a weight changes, in voxels. A sampled distance then changes by less than 1 over a length of 1.
pub(super) const SOFTNESS: f32 = 0.5;

/// How far a cell that no border crosses is from one, in voxels: more than half of its diagonal and what is near.
const FAR_VOXELS: f32 = 16.0;

/// The solids of materials.
#[derive(Default)]
pub(super) struct Paints {
    /// The material of what is not painted. `None` is the default one.
    pub(super) first: Option<String>,
    /// The other materials, in the order in which they are painted.
    pub(super) others: Vec<(String, SampledGrid)>,
}

/// Samples the materials of a program of a scene.
pub(super) fn sample(
    program: &Program,
    scene: &Scene,
    lattice: Lattice,
    control: &Control,
) -> Paints {
    let materials = materials_of(program);
    let name = |index: usize| {
        let position = index.checked_sub(1)?;
        scene
            .materials()
            .get_index(position)
            .map(|(name, _)| name.clone())
    };
    if materials.len() < 2 {
        let first = materials.first().and_then(|&index| name(index));
        return Paints {
            first,
            others: Vec::new(),
        };
    }
    let starts: BTreeSet<usize> = materials
        .iter()
        .map(|index| index - index % Program::MARKED_MATERIALS)
        .collect();
    let marked: Vec<(usize, Program)> = starts
        .into_iter()
        .map(|start| (start, program.with_marked_materials(start)))
        .collect();
    let weights = Weights {
        samplers: marked
            .iter()
            .map(|(start, program)| (*start, ProgramSampler::new(program, control)))
            .collect(),
        materials: &materials,
    };
    let distances = ProgramSampler::new(program, control);
    let cells: Vec<CellWeights> = (0..volume(lattice.cells))
        .into_par_iter()
        .map(|index| {
            CellWeights::of(
                &weights,
                &distances,
                lattice,
                place_of(index, lattice.cells),
            )
        })
        .collect();
    // Materials that are nowhere in the solid are left out. The first of the others is under all of them.
    let is_there = |material: &usize| {
        cells
            .iter()
            .any(|cell| cell.is_near && cell.ranges[*material][1] > 0.0)
    };
    let mut there = (0..materials.len()).filter(is_there);
    let first = there.next().and_then(|material| name(materials[material]));
    let others = there.filter_map(|material| {
        let grid = sample_one(material, &weights, &cells, lattice);
        name(materials[material]).map(|name| (name, grid))
    });
    let others = others.collect();
    Paints { first, others }
}

/// Returns the indices of the materials that brushes of a program have.
fn materials_of(program: &Program) -> Vec<usize> {
    let brushes = program.instructions().iter();
    let brushes = brushes.filter(|instr| {
        instr.op < abi::OP_SHAPES_END && instr.flags & abi::FLAG_KEEP_MATERIAL == 0
    });
    let all: BTreeSet<usize> = brushes.map(|brush| brush.operand as usize).collect();
    all.into_iter().collect()
}

/// Computes the weights of materials.
struct Weights<'a> {
    /// Programs with marks, each from a material on.
    samplers: Vec<(usize, ProgramSampler<'a>)>,
    materials: &'a [usize],
}

impl Weights<'_> {
    /// Calls a function with the weights of all materials, at each point.
    fn each(&self, points: &[Vec3], mut use_weights: impl FnMut(usize, &[f32])) {
        let count = self.materials.len();
        let mut all = vec![0.0f32; points.len() * count];
        let mut marks = vec![GpuMaterial::default(); points.len()];
        for (start, sampler) in &self.samplers {
            sampler.materials(points, &mut marks);
            for (index, &material) in self.materials.iter().enumerate() {
                let Some(channel) = material
                    .checked_sub(*start)
                    .filter(|&channel| channel < Program::MARKED_MATERIALS)
                else {
                    continue;
                };
                for (mark, shares) in marks.iter().zip(all.chunks_mut(count)) {
                    shares[index] = match channel {
                        0..4 => mark.base_roughness[channel],
                        _ => mark.emission_metallic[channel - 4],
                    };
                }
            }
        }
        for (point, shares) in all.chunks_mut(count).enumerate() {
            let mut rest = 1.0f32;
            for share in shares.iter_mut().rev() {
                let weight = share.clamp(0.0, 1.0);
                *share = if rest > 1e-6 {
                    (weight / rest).min(1.0)
                } else {
                    0.0
                };
                rest -= weight;
            }
            use_weights(point, shares);
        }
    }
}

/// The least and the largest weight of each material in a cell.
struct CellWeights {
    ranges: Vec<[f32; 2]>,
    /// Whether the solid or its surface may be in the cell.
    is_near: bool,
}

impl CellWeights {
    fn of(
        weights: &Weights<'_>,
        distances: &ProgramSampler<'_>,
        lattice: Lattice,
        cell: UVec3,
    ) -> Self {
        let first = lattice.corner + lattice.cell * cell.as_vec3();
        let mut at_center = [0.0];
        distances.distances(&[first + 0.5 * lattice.cell], &mut at_center);
        let is_near = at_center[0] < lattice.cell * distances.steepness();
        if distances.is_cancelled() {
            let ranges = vec![[0.0; 2]; weights.materials.len()];
            return Self { ranges, is_near };
        }
        let side = if is_near { SAMPLED_SIDE } else { 1 };
        let step = lattice.cell / side as f32;
        let points = UVec3::splat(side + 1);
        let points: Vec<Vec3> = (0..volume(points))
            .map(|index| first + step * place_of(index, points).as_vec3())
            .collect();
        if let Some(sole) = distances.sole_material(&points) {
            // Later materials cover it nowhere, and it covers the earlier ones.
            let weight = |&material: &usize| [f32::from(u8::from(material == sole)); 2];
            let ranges = weights.materials.iter().map(weight).collect();
            return Self { ranges, is_near };
        }
        let mut ranges = vec![[1.0f32, 0.0]; weights.materials.len()];
        weights.each(&points, |_, all| {
            for (range, &weight) in ranges.iter_mut().zip(all) {
                *range = [range[0].min(weight), range[1].max(weight)];
            }
        });
        Self { ranges, is_near }
    }

    /// Whether the border of a material crosses the cell.
    fn is_crossed(&self, material: usize) -> bool {
        let [least, most] = self.ranges[material];
        least < 1.0 && most > 0.0
    }
}

/// Samples where one material is.
fn sample_one(
    material: usize,
    weights: &Weights<'_>,
    cells: &[CellWeights],
    lattice: Lattice,
) -> SampledGrid {
    let border = Border::new(material, weights, cells, lattice);
    let size = lattice.cell * lattice.cells.as_vec3();
    let region = Aabb::new(lattice.corner, lattice.corner + size);
    SampledGrid::sample(lattice.corner, lattice.cell, lattice.cells, region, &border)
}

/// Counts how many cells each cell is from one that a border crosses, along the largest axis.
fn steps_to_border(cells: &[CellWeights], material: usize, count: UVec3) -> Vec<u8> {
    let mut steps = vec![u8::MAX; cells.len()];
    let crossed = (0..cells.len()).filter(|&index| cells[index].is_crossed(material));
    let mut open: VecDeque<usize> = crossed.collect();
    for &index in &open {
        steps[index] = 0;
    }
    while let Some(index) = open.pop_front() {
        let next = steps[index].saturating_add(1);
        let place = place_of(index, count).as_ivec3();
        for beside in (0..27).map(|i| place + place_of(i, UVec3::splat(3)).as_ivec3() - 1) {
            let is_in = beside.cmpge(IVec3::ZERO) & beside.cmplt(count.as_ivec3());
            if !is_in.all() {
                continue;
            }
            let beside = index_of(beside.as_uvec3(), count);
            if steps[beside] > next {
                steps[beside] = next;
                open.push_back(beside);
            }
        }
    }
    steps
}

/// The distance of a material's border.
struct Border<'a, 'b> {
    material: usize,
    weights: &'a Weights<'b>,
    cells: &'a [CellWeights],
    lattice: Lattice,
    steps: Vec<u8>,
    /// Distances at corners of cells.
    corners: Vec<f32>,
}

impl<'a, 'b> Border<'a, 'b> {
    fn new(
        material: usize,
        weights: &'a Weights<'b>,
        cells: &'a [CellWeights],
        lattice: Lattice,
    ) -> Self {
        let mut border = Self {
            material,
            weights,
            cells,
            lattice,
            steps: steps_to_border(cells, material, lattice.cells),
            corners: Vec::new(),
        };
        let count = lattice.cells + 1;
        let mut corners = vec![0.0; volume(count)];
        let rows = corners.par_chunks_mut(count.x as usize).enumerate();
        rows.for_each(|(row, out)| {
            let place = |x: usize| place_of(row * count.x as usize + x, count).as_vec3();
            let points: Vec<Vec3> = (0..out.len())
                .map(|x| lattice.corner + lattice.cell * place(x))
                .collect();
            border.measure(&points, out);
        });
        border.corners = corners;
        border
    }

    /// Computes distances where the border is exact.
    fn measure(&self, points: &[Vec3], out: &mut [f32]) {
        let softness = SOFTNESS * self.lattice.voxel;
        self.weights.each(points, |index, all| {
            let weight = all[self.material];
            let side = if weight > 0.5 { -1.0 } else { 1.0 };
            out[index] = side * self.clearance(points[index]) + softness * (0.5 - weight);
        });
    }

    /// Returns a lower bound on the distance to the border, linear in each cell: 0 in those that the border crosses.
    fn clearance(&self, point: Vec3) -> f32 {
        let corner = |corner: UVec3| {
            let steps = self.around(corner).map(|cell| self.steps[cell]);
            f32::from(steps.min().unwrap_or(u8::MAX))
        };
        0.5 * self.lattice.cell * self.interpolated(point, corner)
    }

    /// Interpolates values at the corners of the cell that contains a point.
    fn interpolated(&self, point: Vec3, value: impl Fn(UVec3) -> f32) -> f32 {
        let count = self.lattice.cells;
        let at = self.place(point);
        let low = at.floor().as_uvec3().min(count - 1);
        let t = at - low.as_vec3();
        let v: [f32; 8] = std::array::from_fn(|i| {
            let i = i as u32;
            value(low + UVec3::new(i & 1, i >> 1 & 1, i >> 2))
        });
        let along = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let row = |i: usize| along(v[i], v[i + 1], t.x);
        along(along(row(0), row(2), t.y), along(row(4), row(6), t.y), t.z)
    }

    /// Returns where a point is, in cells.
    fn place(&self, point: Vec3) -> Vec3 {
        let at = (point - self.lattice.corner) / self.lattice.cell;
        at.clamp(Vec3::ZERO, self.lattice.cells.as_vec3())
    }

    /// Iterates over the cells that have a corner.
    fn around(&self, corner: UVec3) -> impl Iterator<Item = usize> {
        let count = self.lattice.cells;
        let cells = (0..8).map(move |j| corner.as_ivec3() - IVec3::new(j & 1, j >> 1 & 1, j >> 2));
        let inside = cells
            .filter(move |cell| (cell.cmpge(IVec3::ZERO) & cell.cmplt(count.as_ivec3())).all());
        inside.map(move |cell| index_of(cell.as_uvec3(), count))
    }

    /// Whether a cell in the air touches a point.
    fn is_in_air(&self, point: Vec3) -> bool {
        // A little to all sides, in voxels.
        let at = self.place(point);
        let off = 0.25 / SAMPLED_SIDE as f32;
        let most = self.lattice.cells.as_vec3() - 1.0;
        let [low, high] = [at - off, at + off].map(|at| at.floor().clamp(Vec3::ZERO, most));
        (0..8).any(|i| {
            let high_side = glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0);
            let cell = Vec3::select(high_side, high, low);
            !self.cells[index_of(cell.as_uvec3(), self.lattice.cells)].is_near
        })
    }
}

impl DistanceSampler for Border<'_, '_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        let points_in_air: Vec<bool> = points.iter().map(|&point| self.is_in_air(point)).collect();
        if !points_in_air.iter().all(|&is_in_air| is_in_air) {
            self.measure(points, out);
        }
        let corners = self.lattice.cells + 1;
        let all = points.iter().zip(out).zip(points_in_air);
        for ((&point, out), _) in all.filter(|(_, is_in_air)| *is_in_air) {
            *out = self.interpolated(point, |corner| self.corners[index_of(corner, corners)]);
        }
    }

    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        let most = self.lattice.cells - 1;
        for (&point, out) in points.iter().zip(out) {
            let cell = self.place(point).floor().as_uvec3().min(most);
            let cell = index_of(cell, self.lattice.cells);
            let is_sampled = self.steps[cell] == 0 && self.cells[cell].is_near;
            *out = if is_sampled {
                0.0
            } else {
                FAR_VOXELS * self.lattice.voxel
            };
        }
    }

    /// Outside of the lattice, there is nothing to paint.
    fn knows_outside(&self) -> bool {
        false
    }
}

fn volume(count: UVec3) -> usize {
    count.x as usize * count.y as usize * count.z as usize
}

fn place_of(index: usize, count: UVec3) -> UVec3 {
    let index = index as u32;
    UVec3::new(
        index % count.x,
        index / count.x % count.y,
        index / count.x / count.y,
    )
}

fn index_of(place: UVec3, count: UVec3) -> usize {
    (place.z as usize * count.y as usize + place.y as usize) * count.x as usize + place.x as usize
}
