//! Distances in a scene of many brushes, at a cost that hardly depends on their number.

use crate::part_grid::PartGrid;
use crate::spans::OperandSpan;
use crate::{Evaluator, LANES, Program, Pruner};
use argil_abi::{GpuMaterial, Instruction};
use argil_math::Aabb;
use argil_scene::OperatorKind;
use glam::{UVec3, Vec3};
use std::ops::Range;
use std::sync::OnceLock;

/// A grid's far length, in edges of its parts.
const FAR: f32 = 0.5;
/// Operands per part of the finest grid, if they are spread evenly.
const OPERANDS_PER_PART: f32 = 2.0;
/// Maximum parts along an axis.
const MAX_PARTS: f32 = 128.0;
/// Maximum entries per operand. Larger operands get larger parts.
const MAX_ENTRIES: u64 = 64;
/// Maximum mean length of a coarse grid's programs, over its entries.
const MAX_LIST_LENGTH: u64 = 1 << 15;
/// What covers more than one in this many parts is entered once for all.
const SHARE: u32 = 8;
/// Programs of up to this many instructions are not pruned.
const SHORT: usize = 16;

/// Pruned programs near each point, shared by all threads. Create one per program, and a [`NearEvaluator`] per
/// thread.
///
/// *Theory.* A ray marcher, or an occlusion test, treats all distances beyond some length the same. Below that far
/// length, a point's distance depends only on what is near.
///
/// *Practice.* Grids of parts, each twice as coarse as the one before, know which pieces can matter in a part for
/// distances below the grid's far length. The first thread that asks for a point in a part prunes its program. A
/// point uses the finest grid first. If its distance is not below the far length, it uses the next.
#[derive(Debug)]
pub struct NearField<'a> {
    program: &'a Program,
    levels: Vec<NearLevel>,
}

/// The position of a level's parts.
#[derive(Debug)]
struct NearGrid {
    parts: PartGrid,
    around: Aabb,
    /// Number of parts along each axis.
    size: UVec3,
    /// How far values can fall through joints.
    falls: [f32; 2],
}

#[derive(Debug)]
struct NearLevel {
    grid: NearGrid,
    /// For each part, the index of its first operand, and one more for the end.
    begins: Vec<u32>,
    operands: Vec<u32>,
    /// Operands that are entered once for all parts.
    everywhere: Vec<u32>,
    lists: Box<[OnceLock<Box<[Instruction]>>]>,
}

impl<'a> NearField<'a> {
    /// Creates a field for points of a finite box and distances up to `far_length`. Returns `None` if the program's pieces
    /// are not [tracked](Program::operand_count), or if there is a morph, which makes everything matter everywhere.
    pub fn new(program: &'a Program, around: Aabb, far_length: f32) -> Option<Self> {
        let all = &program.operands;
        let size = around.size().max_element();
        let is_usual = size > 0.0 && size.is_finite() && far_length > 0.0;
        if !program.is_local() || !is_usual {
            return None;
        }
        let mut count = (all.len() as f32 / OPERANDS_PER_PART).cbrt();
        count = count.ceil().clamp(1.0, MAX_PARTS);
        // Counted before anything is allocated: large pieces can be in more parts than fit into memory.
        while count > 4.0 {
            let grid = NearGrid::new(program, around, size / count, far_length);
            let entries: u64 = all
                .iter()
                .map(|operand| grid.covered_by(program, operand))
                .sum();
            if entries <= MAX_ENTRIES * all.len() as u64 {
                break;
            }
            count = (0.5 * count).ceil();
        }
        let mut levels = Vec::new();
        loop {
            let level = NearLevel::new(
                program,
                NearGrid::new(program, around, size / count, far_length),
            );
            let entries = level.operands.len() as u64;
            let lengths = level
                .begins
                .windows(2)
                .map(|range| u64::from(range[1] - range[0]));
            let is_long = lengths.map(|n| n * n).sum::<u64>() > MAX_LIST_LENGTH * entries.max(1);
            if is_long && !levels.is_empty() {
                break;
            }
            let is_enough = level.grid.parts.far >= far_length;
            levels.push(level);
            if is_enough {
                break;
            }
            count *= 0.5;
        }
        Some(Self { program, levels })
    }

    /// Returns the distance beyond which results are clamped.
    pub fn far_length(&self) -> f32 {
        self.levels.last().map_or(0.0, |level| level.grid.parts.far)
    }
}

impl NearGrid {
    fn new(program: &Program, around: Aabb, edge: f32, most: f32) -> Self {
        // The last level reaches as far as requested.
        let usual = FAR * edge;
        let far_length = if 1.5 * usual < most { usual } else { most };
        let parts = PartGrid {
            corner: around.min,
            edge,
            far: far_length,
            base: around.size().max_element(),
        };
        Self {
            parts,
            around,
            size: (around.size() / edge).ceil().as_uvec3().max(UVec3::ONE),
            falls: program.falls(far_length),
        }
    }

    fn count(&self) -> u32 {
        self.size.element_product()
    }

    /// Returns the range of parts in which a piece can matter, if there is any.
    fn range_of(&self, program: &Program, operand: &OperandSpan) -> Option<Range<UVec3>> {
        if operand.operator.kind == OperatorKind::Intersect {
            return Some(UVec3::ZERO..self.size);
        }
        let held = program.reach_of(operand, &self.parts, self.falls);
        if operand.extent.aabb.is_empty() || held.intersection(self.around).is_empty() {
            return None;
        }
        let [first, last] = [held.min, held.max].map(|corner| {
            let place = ((corner - self.parts.corner) / self.parts.edge).floor();
            place.max(Vec3::ZERO).as_uvec3().min(self.size - 1)
        });
        Some(first..last + 1)
    }

    /// Returns the number of those parts.
    fn covered_by(&self, program: &Program, operand: &OperandSpan) -> u64 {
        self.range_of(program, operand).map_or(0, |range| {
            u64::from((range.end - range.start).element_product())
        })
    }
}

impl NearLevel {
    fn new(program: &Program, grid: NearGrid) -> Self {
        let all = &program.operands;
        let (count, size) = (grid.count(), grid.size);
        // The parts of a piece, or an error if it is entered for all.
        let mut everywhere = Vec::new();
        let parts_of = |operand: &OperandSpan| {
            let Some(range) = grid.range_of(program, operand) else {
                return Ok(UVec3::ZERO..UVec3::ZERO);
            };
            let covered = (range.end - range.start).element_product();
            let is_everywhere = operand.operator.kind == OperatorKind::Intersect
                || count > SHARE && covered > count / SHARE;
            if is_everywhere { Err(()) } else { Ok(range) }
        };
        let mut begins = vec![0u32; count as usize + 1];
        for (index, operand) in (0..).zip(all) {
            match parts_of(operand) {
                Err(()) => everywhere.push(index),
                Ok(range) => each_part(range, size, |part| begins[part + 1] += 1),
            }
        }
        let mut sum = 0u32;
        for begin in &mut begins {
            sum = sum.saturating_add(*begin);
            *begin = sum;
        }
        let mut operands = vec![0; sum as usize];
        let mut ends = begins.clone();
        for (index, operand) in (0..).zip(all) {
            if let Ok(range) = parts_of(operand) {
                each_part(range, size, |part| {
                    operands[ends[part] as usize] = index;
                    ends[part] += 1;
                });
            }
        }
        Self {
            grid,
            begins,
            operands,
            everywhere,
            lists: (0..count).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Returns the part that contains a point.
    #[inline]
    fn part_of(&self, point: Vec3) -> Option<u32> {
        let place = ((point - self.grid.parts.corner) / self.grid.parts.edge).floor();
        let is_in = place.cmpge(Vec3::ZERO) & place.cmplt(self.grid.size.as_vec3());
        let place = place.as_uvec3();
        let [x, y, _] = self.grid.size.to_array();
        is_in.all().then(|| (place.z * y + place.y) * x + place.x)
    }

    /// Returns the program of a part.
    fn list(&self, program: &Program, part: u32, scratch: &mut NearScratch<'_>) -> &[Instruction] {
        self.lists[part as usize].get_or_init(|| {
            let range =
                self.begins[part as usize] as usize..self.begins[part as usize + 1] as usize;
            let (found, list) = (&mut scratch.found, &mut scratch.list);
            found.clear();
            found.extend_from_slice(&self.operands[range]);
            if !self.everywhere.is_empty() {
                found.extend_from_slice(&self.everywhere);
                found.sort_unstable();
            }
            list.clear();
            program.append_operands(found, list);
            if list.len() <= SHORT {
                return list.as_slice().into();
            }
            let [x, y, _] = self.grid.size.to_array();
            let place = UVec3::new(part % x, part / x % y, part / (x * y));
            let parts = &self.grid.parts;
            let center = parts.corner + parts.edge * (place.as_vec3() + 0.5);
            // Half of the diagonal, and rounding.
            let half = 0.8661 * parts.edge;
            scratch
                .pruner
                .classify_cells(list, &[center], half, &mut [0.0]);
            let mut left = Vec::new();
            scratch.pruner.prune_into(list, 0, &mut left);
            left.into_boxed_slice()
        })
    }
}

/// Calls `visit` for each part of a range.
fn each_part(range: Range<UVec3>, size: UVec3, mut visit: impl FnMut(usize)) {
    for z in range.start.z..range.end.z {
        for y in range.start.y..range.end.y {
            for x in range.start.x..range.end.x {
                visit(((z * size.y + y) * size.x + x) as usize);
            }
        }
    }
}

/// Evaluates a [`NearField`] for one thread. Create one per thread and keep it.
#[derive(Debug)]
pub struct NearEvaluator<'a> {
    field: &'a NearField<'a>,
    evaluator: Evaluator<'a>,
    scratch: NearScratch<'a>,
    /// The points for a level: their parts, and their indices.
    asked: Vec<(u32, u32)>,
    next: Vec<u32>,
    batch: Box<Batch>,
}

#[derive(Debug)]
struct NearScratch<'a> {
    pruner: Pruner<'a>,
    found: Vec<u32>,
    list: Vec<Instruction>,
}

/// Points in one part.
#[derive(Debug)]
struct Batch {
    p: [[f32; LANES]; 3],
    d: [f32; LANES],
    materials: [GpuMaterial; LANES],
}

/// What to evaluate.
enum Wanted<'a> {
    Distances(&'a mut [f32]),
    Materials(&'a mut [GpuMaterial]),
}

impl<'a> NearEvaluator<'a> {
    /// Creates an evaluator of a field.
    pub fn new(field: &'a NearField<'a>) -> Self {
        Self {
            field,
            evaluator: Evaluator::new(field.program),
            scratch: NearScratch {
                pruner: Pruner::new(field.program),
                found: Vec::new(),
                list: Vec::new(),
            },
            asked: Vec::new(),
            next: Vec::new(),
            batch: Box::new(Batch {
                p: [[0.0; LANES]; 3],
                d: [0.0; LANES],
                materials: [GpuMaterial::default(); LANES],
            }),
        }
    }

    /// Returns the program.
    pub fn program(&self) -> &'a Program {
        self.field.program
    }

    /// Returns the distance beyond which results are clamped: see [`NearField::far_length`].
    pub fn far_length(&self) -> f32 {
        self.field.far_length()
    }

    /// Computes the signed distances of any number of points into `out`, clamped to [`NearField::far_length`]. Points
    /// outside the field's box use the whole program.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn distances(&mut self, points: [&[f32]; 3], out: &mut [f32]) {
        self.ask(points, Wanted::Distances(out));
    }

    /// Computes the materials of points that are nearer to the surface than [`NearField::far_length`].
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn materials(&mut self, points: [&[f32]; 3], out: &mut [GpuMaterial]) {
        self.ask(points, Wanted::Materials(out));
    }

    fn ask(&mut self, points: [&[f32]; 3], mut wanted: Wanted<'_>) {
        let count = match &wanted {
            Wanted::Distances(out) => out.len(),
            Wanted::Materials(out) => out.len(),
        };
        assert!(points.iter().all(|axis| axis.len() == count), "as many");
        let [x, y, z] = points;
        self.next.clear();
        self.next.extend(0..count as u32);
        let field = self.field;
        for (index, level) in field.levels.iter().enumerate() {
            let is_last = index + 1 == field.levels.len();
            self.asked.clear();
            for &i in &self.next {
                let k = i as usize;
                let part = level.part_of(Vec3::new(x[k], y[k], z[k]));
                self.asked.push((part.unwrap_or(u32::MAX), i));
            }
            self.next.clear();
            self.asked.sort_unstable();
            let asked = std::mem::take(&mut self.asked);
            for of_part in asked.chunk_by(|a, b| a.0 == b.0) {
                let part = of_part[0].0;
                if part == u32::MAX {
                    self.evaluate(
                        &field.program.instructions,
                        f32::INFINITY,
                        true,
                        of_part,
                        points,
                        &mut wanted,
                    );
                    continue;
                }
                let list = level.list(field.program, part, &mut self.scratch);
                self.evaluate(
                    list,
                    level.grid.parts.far,
                    is_last,
                    of_part,
                    points,
                    &mut wanted,
                );
            }
            self.asked = asked;
        }
    }

    /// Evaluates points with a program that holds below `far_length`. Other points are left for the next level, unless
    /// this is the last.
    fn evaluate(
        &mut self,
        list: &[Instruction],
        far_length: f32,
        is_last: bool,
        of_part: &[(u32, u32)],
        points: [&[f32]; 3],
        wanted: &mut Wanted<'_>,
    ) {
        let batch = &mut *self.batch;
        for chunk in of_part.chunks(LANES) {
            let n = chunk.len();
            for (lanes, from) in batch.p.iter_mut().zip(points) {
                for (lane, &(_, i)) in lanes.iter_mut().zip(chunk) {
                    *lane = from[i as usize];
                }
            }
            let [x, y, z] = batch.p.each_ref().map(|lanes| &lanes[..n]);
            let d = &mut batch.d[..n];
            match wanted {
                Wanted::Distances(out) => {
                    if list.is_empty() {
                        d.fill(far_length);
                    } else {
                        self.evaluator.distances_with(list, x, y, z, d);
                    }
                    for (&d, &(_, i)) in d.iter().zip(chunk) {
                        if d < far_length || is_last {
                            out[i as usize] = d.min(far_length);
                        } else {
                            self.next.push(i);
                        }
                    }
                }
                Wanted::Materials(out) => {
                    let materials = &mut batch.materials[..n];
                    self.evaluator.materials_with(list, [x, y, z], d, materials);
                    for ((found, d), &(_, i)) in materials.iter().zip(d).zip(chunk) {
                        if *d < far_length || is_last {
                            out[i as usize] = *found;
                        } else {
                            self.next.push(i);
                        }
                    }
                }
            }
        }
    }
}
