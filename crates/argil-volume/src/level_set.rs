//! Distances around a surface for a VDB level set: leaves of 8³ samples at multiples of the voxel size.
//!
//! *Theory.* A level set stores the distances of all voxels nearer to the surface than half the band's width. Regions of
//! 128³ voxels, of 32³ and of 8³ whose center is farther away than their half diagonal and that width have none.
//!
//! *Practice.* Each region has a pruned program (`argil_field::Pruner`), so samples equal the whole program's.

mod correct;

use argil_abi::{GpuMaterial, Instruction};
use argil_field::{CELLS_PER_BATCH, Evaluator, LANES, Program, Pruner};
use argil_math::{Aabb, Control};
use correct::{SAMPLES, WIDE, WIDE_SAMPLES, correct};
use glam::{IVec3, Vec3, ivec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Voxels along the side of a leaf.
const LEAF: i32 = 8;
/// Voxels along the side of what one task bakes.
const TASK: i32 = 128;
/// By how much each size of region exceeds the next.
const FACTOR: i32 = 4;

/// The lattice and the band of a level set. The sample with index `i` is at `voxel_size · i`, in the scene's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSetLayout {
    /// Edge of a voxel, in the scene's unit.
    pub voxel_size: f32,
    /// Half the width of the band, in voxels.
    pub half_width_voxels: f32,
    /// What is sampled, in the scene's space.
    pub region: Aabb,
    /// Whether the region's sides cut the solid off there, so that it is closed.
    pub is_cut: bool,
    /// Whether bounds become distances: where the field's slope is not 1, as in blends, values are divided by it.
    pub is_corrected: bool,
}

impl LevelSetLayout {
    /// Returns half the width of the band in the scene's unit, never less than the voxels say.
    pub fn half_width(&self) -> f32 {
        let exact = f64::from(self.half_width_voxels) * f64::from(self.voxel_size);
        let rounded = exact as f32;
        if f64::from(rounded) < exact {
            rounded.next_up()
        } else {
            rounded
        }
    }

    /// Returns the signed distance of a point to the region that cuts the solid off. −∞ if it does not.
    pub fn distance_to_cut(&self, point: Vec3) -> f32 {
        if !self.is_cut {
            return f32::NEG_INFINITY;
        }
        let beyond = (point - self.region.center()).abs() - 0.5 * self.region.size();
        beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0)
    }
}

/// Samples of 8³ voxels, of which one at least is in the band.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSetLeaf {
    /// Index of the first sample: multiples of 8.
    pub origin: [i32; 3],
    /// Signed distances in the scene's unit, z fastest.
    pub values: Box<[f32; SAMPLES]>,
    /// Base colors, linear, if they were asked for. Those outside of the band are black.
    pub colors: Option<Box<[[f32; 3]; SAMPLES]>>,
}

/// Bakes level sets from a field, one part after another.
///
/// ```
/// use argil_field::Program;
/// use argil_math::{Aabb, Control};
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{LevelSetBaker, LevelSetLayout};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let layout = LevelSetLayout {
///     voxel_size: 0.01,
///     half_width_voxels: 3.0,
///     region: program.aabb(),
///     is_cut: false,
///     is_corrected: true,
/// };
/// let control = Control::default();
/// let baker = LevelSetBaker::new(&program, layout, 4096, &control);
/// let leaves: Vec<_> = baker.parts().map(|part| baker.bake(part, false, &control)).collect();
/// // Around the origin, eight parts meet.
/// assert_eq!(leaves.len(), 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LevelSetBaker<'a> {
    program: &'a Program,
    layout: LevelSetLayout,
    part_voxels: i32,
    instructions: Vec<Instruction>,
    tasks: BTreeMap<[i32; 3], Vec<Task>>,
}

/// A region of 128³ voxels, and its program.
#[derive(Clone, Debug)]
struct Task {
    origin: IVec3,
    program: Range<usize>,
}

impl<'a> LevelSetBaker<'a> {
    /// Finds the regions near the surface. `part_voxels` is the side of a part: 128 times a power of two. A canceled
    /// baker has only some of them.
    pub fn new(
        program: &'a Program,
        layout: LevelSetLayout,
        part_voxels: u32,
        control: &Control,
    ) -> Self {
        let mut own = Self {
            program,
            layout,
            part_voxels: (part_voxels as i32).max(TASK),
            instructions: Vec::new(),
            tasks: BTreeMap::new(),
        };
        let grown = layout
            .region
            .grown((layout.half_width_voxels + 1.0) * layout.voxel_size);
        if !layout.region.is_empty() {
            let low = (grown.min / layout.voxel_size).floor().as_ivec3();
            let high = (grown.max / layout.voxel_size).ceil().as_ivec3();
            let mut side = TASK;
            let wide = (high - low).max_element();
            while side < wide && side < 1 << 24 {
                side *= FACTOR;
            }
            let mut pruner = Pruner::new(program);
            let all = program.instructions();
            own.split((low, high), side, all, &mut pruner, control);
        }
        own
    }

    /// Returns the origins of the parts that have leaves, in ascending order.
    pub fn parts(&self) -> impl Iterator<Item = [i32; 3]> {
        self.tasks.keys().copied()
    }

    /// Counts the regions of 128³ voxels to bake.
    pub fn task_count(&self) -> usize {
        self.tasks.values().map(Vec::len).sum()
    }

    /// Finds the regions of 128³ voxels in a box of indices, through regions of `side` voxels.
    fn split(
        &mut self,
        (low, high): (IVec3, IVec3),
        side: i32,
        program: &[Instruction],
        pruner: &mut Pruner<'a>,
        control: &Control,
    ) {
        let first = low.map(|c| c.div_euclid(side));
        let last = high.map(|c| c.div_euclid(side));
        let mut origins = Vec::new();
        for x in first.x..=last.x {
            for y in first.y..=last.y {
                for z in first.z..=last.z {
                    origins.push(ivec3(x, y, z) * side);
                }
            }
        }
        for origins in origins.chunks(CELLS_PER_BATCH) {
            if control.is_cancelled() {
                return;
            }
            let mut kept = Vec::new();
            self.near(origins, side, program, pruner, &mut |pruner, index| {
                let mut own = Vec::new();
                pruner.prune_into(program, index, &mut own);
                kept.push((origins[index], own));
            });
            for (origin, own) in kept {
                if side == TASK {
                    let begin = self.instructions.len();
                    self.instructions.extend(own);
                    let part = (origin & -self.part_voxels).to_array();
                    self.tasks.entry(part).or_default().push(Task {
                        origin,
                        program: begin..self.instructions.len(),
                    });
                } else {
                    let end = origin + side - 1;
                    let inner = (low.max(origin), high.min(end));
                    self.split(inner, side / FACTOR, &own, pruner, control);
                }
            }
        }
    }

    /// Calls a function for the regions that can have voxels in the band.
    fn near(
        &self,
        origins: &[IVec3],
        side: i32,
        program: &[Instruction],
        pruner: &mut Pruner<'a>,
        keep: &mut dyn FnMut(&mut Pruner<'a>, usize),
    ) {
        let voxel = self.layout.voxel_size;
        let middle = 0.5 * (side - 1) as f32;
        let centers: Vec<Vec3> = origins
            .iter()
            .map(|origin| voxel * (origin.as_vec3() + middle))
            .collect();
        // Slopes need a sample more on each side.
        let beside = if self.layout.is_corrected { 1.0 } else { 0.0 };
        let half_diagonal = 3f32.sqrt() * voxel * (middle + beside);
        let mut distances = [0.0; CELLS_PER_BATCH];
        let distances = &mut distances[..centers.len()];
        pruner.classify_cells(program, &centers, half_diagonal, distances);
        let reach = 1.000_1 * (self.program.lipschitz() * half_diagonal + self.value_reach());
        for (index, &distance) in distances.iter().enumerate() {
            // The side of a cut has a surface too, where the field is far inside.
            let of_cut = self.layout.distance_to_cut(centers[index]);
            if distance.max(of_cut).abs() <= reach || distance.is_nan() {
                keep(pruner, index);
            }
        }
    }

    /// Returns the largest value that can be in the band, once it is divided by a slope.
    fn value_reach(&self) -> f32 {
        let steepest = if self.layout.is_corrected {
            self.program.lipschitz().max(1.0)
        } else {
            1.0
        };
        steepest * self.layout.half_width()
    }

    /// Bakes the leaves of a part, on rayon's current threads, in a fixed order. Advances `control` by the number of its
    /// regions of 128³ voxels.
    pub fn bake(&self, part: [i32; 3], with_colors: bool, control: &Control) -> Vec<LevelSetLeaf> {
        let tasks = self.tasks.get(&part).map_or(&[][..], Vec::as_slice);
        let baked: Vec<Vec<LevelSetLeaf>> = tasks
            .par_iter()
            .map_init(
                || LeafBaker::new(self, with_colors),
                |baker, task| {
                    let mut leaves = Vec::new();
                    if !control.is_cancelled() {
                        baker.bake(task, &mut leaves);
                    }
                    control.advance(1);
                    leaves
                },
            )
            .collect();
        baked.into_iter().flatten().collect()
    }
}

/// The state of a thread.
struct LeafBaker<'a> {
    of: &'a LevelSetBaker<'a>,
    with_colors: bool,
    pruner: Pruner<'a>,
    evaluator: Evaluator<'a>,
    points: [[f32; SAMPLES]; 3],
    wide: Box<[f32; WIDE_SAMPLES]>,
    materials: Vec<GpuMaterial>,
}

impl<'a> LeafBaker<'a> {
    fn new(of: &'a LevelSetBaker<'a>, with_colors: bool) -> Self {
        Self {
            of,
            with_colors,
            pruner: Pruner::new(of.program),
            evaluator: Evaluator::new(of.program),
            points: [[0.0; SAMPLES]; 3],
            wide: Box::new([0.0; WIDE_SAMPLES]),
            materials: vec![GpuMaterial::default(); LANES],
        }
    }

    fn bake(&mut self, task: &Task, leaves: &mut Vec<LevelSetLeaf>) {
        let of = self.of;
        let program = &of.instructions[task.program.clone()];
        let blocks = origins_in(task.origin, TASK, TASK / FACTOR);
        let mut kept = Vec::new();
        of.near(
            &blocks,
            TASK / FACTOR,
            program,
            &mut self.pruner,
            &mut |pruner, index| {
                let mut own = Vec::new();
                pruner.prune_into(program, index, &mut own);
                kept.push((blocks[index], own));
            },
        );
        let mut own = Vec::new();
        for (block, program) in &kept {
            let places = origins_in(*block, TASK / FACTOR, LEAF);
            let mut near = Vec::new();
            of.near(
                &places,
                LEAF,
                program,
                &mut self.pruner,
                &mut |pruner, index| {
                    let begin = own.len();
                    pruner.prune_into(program, index, &mut own);
                    near.push((places[index], begin..own.len()));
                },
            );
            for (origin, range) in near {
                leaves.extend(self.leaf(origin, &own[range]));
            }
            own.clear();
        }
    }

    /// Divides bounds of distances by their slopes.
    fn correct(
        &mut self,
        origin: IVec3,
        program: &[Instruction],
        values: &mut [f32; SAMPLES],
        reach: f32,
    ) {
        let layout = &self.of.layout;
        let voxel = layout.voxel_size;
        let mut points = [[0.0; LANES]; 3];
        for first in (0..WIDE_SAMPLES).step_by(LANES) {
            let count = LANES.min(WIDE_SAMPLES - first);
            for (axis, along) in points.iter_mut().enumerate() {
                for (i, c) in along[..count].iter_mut().enumerate() {
                    let at = first + i;
                    let inner = [at / WIDE / WIDE, at / WIDE % WIDE, at % WIDE][axis];
                    *c = voxel * (origin[axis] + inner as i32 - 1) as f32;
                }
            }
            let [x, y, z] = points.each_ref().map(|axis| &axis[..count]);
            let out = &mut self.wide[first..first + count];
            self.evaluator.distances_with(program, x, y, z, out);
            if layout.is_cut {
                for (i, value) in out.iter_mut().enumerate() {
                    *value = value.max(layout.distance_to_cut(Vec3::new(x[i], y[i], z[i])));
                }
            }
        }
        let (evaluator, values) = (&mut self.evaluator, (values, reach));
        correct(
            evaluator,
            program,
            &self.points,
            (&self.wide, voxel),
            values,
        );
    }

    /// Samples a leaf. Returns nothing if no voxel is in the band.
    fn leaf(&mut self, origin: IVec3, program: &[Instruction]) -> Option<LevelSetLeaf> {
        let layout = &self.of.layout;
        let band = layout.half_width();
        for i in 0..SAMPLES {
            let inner = [i / 64, i / 8 % 8, i % 8];
            for axis in 0..3 {
                self.points[axis][i] =
                    layout.voxel_size * (origin[axis] + inner[axis] as i32) as f32;
            }
        }
        let mut values = Box::new([0.0; SAMPLES]);
        let mut colors = self.with_colors.then(|| Box::new([[0.0; 3]; SAMPLES]));
        let [x, y, z] = &self.points;
        for first in (0..SAMPLES).step_by(LANES) {
            let range = first..(first + LANES).min(SAMPLES);
            let points = [x, y, z].map(|axis| &axis[range.clone()]);
            let out = &mut values[range.clone()];
            match &mut colors {
                Some(colors) => {
                    let materials = &mut self.materials[..out.len()];
                    self.evaluator
                        .materials_with(program, points, out, materials);
                    for (color, material) in colors[range].iter_mut().zip(materials) {
                        let [r, g, b, _] = material.base_roughness;
                        *color = [r, g, b];
                    }
                }
                None => self
                    .evaluator
                    .distances_with(program, points[0], points[1], points[2], out),
            }
        }
        if layout.is_cut {
            for (i, value) in values.iter_mut().enumerate() {
                let point = Vec3::new(x[i], y[i], z[i]);
                *value = value.max(layout.distance_to_cut(point));
            }
        }
        let reach = self.of.value_reach();
        if layout.is_corrected && values.iter().any(|value| value.abs() < reach) {
            self.correct(origin, program, &mut values, reach);
        }
        let is_near = values.iter().any(|value| value.abs() < band);
        is_near.then(|| LevelSetLeaf {
            origin: origin.to_array(),
            values,
            colors,
        })
    }
}

/// Returns the origins of the parts of a region, x slowest.
fn origins_in(origin: IVec3, side: i32, part: i32) -> Vec<IVec3> {
    let across = side / part;
    let all = 0..across.pow(3);
    all.map(|i| {
        let place = ivec3(i / across / across, i / across % across, i % across);
        origin + part * place
    })
    .collect()
}
