//! Samples a distance in nested levels.
//!
//! *Theory.* A cell takes the fewest intervals that follow the distance within a tolerance. A distance at `d` from the
//! surface bends by at most `1/d`, and interpolation over `h` is then off by `h² / 4d`. So intervals grow with the root of
//! the distance, and a few coarse levels reach far.

use super::nest::{
    CellSamples, MAX_KIND, Nest, NestCell, NestLevel, UNITS, corners, index, place_of, volume,
};
use super::{DistanceSampler, MAX_SAMPLED_LEVELS, SAMPLED_SIDE, SampledBlock, SampledGrid};
use argil_math::Aabb;
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

/// Maximum error of interpolation away from the surface and from creases, in voxels. It grows as the box of a solid does
/// whose surface is moved that far.
const TOLERANCE: f32 = 0.08;

/// Around solids of more voxels along their longest side, the error grows with the side.
const FULL_ACCURACY_VOXELS: f32 = 512.0;

/// Up to this many voxels from the surface, creases of the distance have samples a voxel apart, and two voxels beyond.
const CREASE_VOXELS: f32 = 12.0;

/// Up to this many voxels from the surface, cells have all samples.
const NEAR_VOXELS: f32 = 2.0;

/// Maximum error of a cell beside a finer one, in intervals of that one.
const MAX_SEAM: f32 = 0.15;

/// Minimum room around the solid in the finest level, in voxels. There, interpolation over two voxels is accurate enough.
const MARGIN_VOXELS: f32 = 10.0;

/// Maximum cells in one call, whose points fit a few hundred megabytes.
const MAX_CELLS_AT_ONCE: usize = 4096;

/// Samples reach this many times the solid's longest side away from it.
const REACH: f32 = 2.0;

impl SampledGrid {
    /// Samples a distance around a solid, a voxel of `spacing` apart near its surface. `solid` is the box of the solid,
    /// whose center is a sample.
    pub fn sample_around(solid: Aabb, spacing: f32, measure: &dyn DistanceSampler) -> Self {
        let cell = spacing * SAMPLED_SIDE as f32;
        let region = solid.grown(MARGIN_VOXELS * spacing);
        let cells = (region.size() / cell).ceil().as_uvec3().max(UVec3::ONE);
        // As levels have them.
        let cells = cells.map(|n| n.next_multiple_of(2));
        let corner = region.center() - 0.5 * cell * cells.as_vec3();
        Self::sample(corner, cell, cells, solid, measure)
    }

    /// Samples a distance in cells from `corner` on, and in coarser ones around them. `solid` is the box of the solid.
    pub fn sample(
        corner: Vec3,
        cell: f32,
        cells: UVec3,
        solid: Aabb,
        measure: &dyn DistanceSampler,
    ) -> Self {
        let accuracy = Accuracy {
            voxel: cell / SAMPLED_SIDE as f32,
            size: solid.size().max_element().max(cell),
            far: measure.far_tolerance(),
        };
        let has_loose_box = measure.has_loose_box();
        let measure = &AtLeastBox { measure, solid };
        let mut nest = Nest::new(corner, cell);
        nest.add(IVec3::ZERO, cells);
        if measure.knows_outside() {
            let reach = REACH * solid.size().max_element() / cell * UNITS as f32;
            surround(&mut nest, reach as i32);
        }
        for level in 0..nest.levels.len() {
            let nest_level = &nest.levels[level];
            let coarse = coarse_samples(&nest, nest_level, measure);
            nest.levels[level].coarse = coarse;
            let nest_level = &nest.levels[level];
            nest.levels[level].cells = (0..volume(nest_level.count))
                .into_par_iter()
                .chunks(measure.cells_at_once())
                .flat_map_iter(|indices| level_samples(&nest, level, &indices, &accuracy, measure))
                .collect();
        }
        smooth(&mut nest, measure);
        let solid = if has_loose_box {
            nest.tighten(solid)
        } else {
            solid
        };
        nest.close_seams();
        Self::of_nest(&nest, solid)
    }
}

/// How far off interpolation may be.
struct Accuracy {
    voxel: f32,
    /// Length of the solid's longest side.
    size: f32,
    /// See [`DistanceSampler::far_tolerance`].
    far: f32,
}

impl Accuracy {
    /// Returns the maximum error of interpolation in a cell. `away` is a lower bound on how far the surface is from it.
    fn tolerance(&self, level: usize, away: f32) -> f32 {
        // Around a long solid, a share of its size is accurate enough, and samples stay few.
        let wide = match level {
            0 => 1.0,
            _ => (self.size / (FULL_ACCURACY_VOXELS * self.voxel)).max(1.0),
        };
        let beyond_creases = (away - CREASE_VOXELS * self.voxel).max(0.0);
        TOLERANCE * self.voxel * wide * (1.0 + 2.0 * away / self.size) + self.far * beyond_creases
    }
}

/// A distance that is at least the distance to a box, as bounds of the solid promise.
struct AtLeastBox<'a> {
    measure: &'a dyn DistanceSampler,
    solid: Aabb,
}

impl AtLeastBox<'_> {
    fn raise(&self, p: Vec3, d: &mut f32) {
        let of_box = p.distance(p.clamp(self.solid.min, self.solid.max));
        // NaN stays NaN, which a maximum would hide.
        if of_box > 0.0 && *d < of_box {
            *d = of_box;
        }
    }
}

impl DistanceSampler for AtLeastBox<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        self.measure.distances(points, out);
        for (&p, d) in points.iter().zip(out) {
            self.raise(p, d);
        }
    }

    fn unsigned_distances(&self, points: &[Vec3], out: &mut [f32]) {
        self.measure.unsigned_distances(points, out);
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        self.measure.sample_block(block, out);
        for (index, d) in out.iter_mut().enumerate() {
            self.raise(block.position(index), d);
        }
    }

    fn knows_outside(&self) -> bool {
        self.measure.knows_outside()
    }

    fn cells_at_once(&self) -> usize {
        self.measure.cells_at_once().clamp(1, MAX_CELLS_AT_ONCE)
    }
}

/// Adds levels until they reach far enough. Each reaches four times as far from the first as the one before.
fn surround(nest: &mut Nest, reach: i32) {
    let first = &nest.levels[0];
    let inner = [IVec3::ZERO, UNITS * first.count.as_ivec3()];
    let mut margin = (MARGIN_VOXELS / SAMPLED_SIDE as f32 * UNITS as f32) as i32;
    while margin < reach && nest.levels.len() < MAX_SAMPLED_LEVELS {
        margin = (4 * margin).min(reach);
        let before = &nest.levels[nest.levels.len() - 1];
        let [low, high] = before.span();
        // Whole cells of this level, which are two of the one before.
        let width = 2 * before.width;
        let steps = |units: IVec3| (units + width - 1) / width;
        let below = steps((low - (inner[0] - margin)).max(IVec3::ZERO));
        let from = low - width * below;
        let count = steps((inner[1] + margin).max(high) - from);
        nest.add(from, count.as_uvec3());
    }
}

fn coarse_samples(nest: &Nest, level: &NestLevel, measure: &dyn DistanceSampler) -> Vec<f32> {
    let points = level.count + 1;
    let mut coarse = vec![0.0; volume(points)];
    // Rows of points.
    let at_once = points.x as usize * measure.cells_at_once();
    let rows = coarse.par_chunks_mut(at_once).enumerate();
    rows.for_each(|(index, out)| {
        let place = |i| nest.position(level.corner_at(place_of(index * at_once + i, points)));
        let places: Vec<Vec3> = (0..out.len()).map(place).collect();
        measure.distances(&places, out);
    });
    coarse
}

/// Takes more samples where a finer neighbor shows that interpolation is off, so that closing the seam bends nothing much.
fn smooth(nest: &mut Nest, measure: &dyn DistanceSampler) {
    let mut unchecked = nest.sampled_cells();
    loop {
        let mut rough = nest.rough_seams(&unchecked, MAX_SEAM);
        rough.retain(|seam| {
            let wider = &nest.levels[seam.wider.level].cells[seam.wider.index];
            wider.kind < wider.max_kind
        });
        if rough.is_empty() {
            return;
        }
        unchecked = rough.iter().map(|seam| seam.cell).collect();
        let mut wider: Vec<NestCell> = rough.iter().map(|seam| seam.wider).collect();
        wider.sort_unstable();
        wider.dedup();
        let sampled: Vec<SampledCell> = wider
            .par_chunks(measure.cells_at_once())
            .flat_map_iter(|cells| {
                let cell_samples = |&cell: &NestCell| &nest.levels[cell.level].cells[cell.index];
                let begin =
                    |cell: &NestCell| SampledCell::again(block_of(nest, *cell), cell_samples(cell));
                let mut cells: Vec<_> = cells.iter().map(begin).collect();
                // From the finest on, so that each cell is refined once.
                for kind in (0..MAX_KIND).rev() {
                    refine(&mut cells, kind, measure);
                }
                cells
            })
            .collect();
        for (&cell, sampled) in wider.iter().zip(sampled) {
            let stored = &mut nest.levels[cell.level].cells[cell.index];
            stored.kind = sampled.kind;
            stored.samples = sampled.samples;
        }
        unchecked.extend(wider);
        unchecked.sort_unstable();
        unchecked.dedup();
    }
}

fn block_of(nest: &Nest, cell: NestCell) -> SampledBlock {
    let level = &nest.levels[cell.level];
    let place = place_of(cell.index, level.count);
    let corners = corners(place).map(|p| level.coarse[index(p, level.count + 1)]);
    SampledBlock {
        first: nest.position(level.corner_at(place)),
        step: nest.unit * level.width as f32 / SAMPLED_SIDE as f32,
        corners,
    }
}

/// A cell while it is sampled. It has 2 to the power of `kind` intervals.
struct SampledCell {
    block: SampledBlock,
    kind: u8,
    max_kind: u8,
    samples: Vec<f32>,
    /// Maximum error of interpolation.
    tolerance: f32,
}

impl SampledCell {
    /// Begins a cell at its corners. `away` is a lower bound on how far the surface is from it.
    fn new(level: usize, block: SampledBlock, away: f32, accuracy: &Accuracy) -> Self {
        let is_near = away <= NEAR_VOXELS * block.step;
        let is_fine = is_near || level > 0 || away <= CREASE_VOXELS * accuracy.voxel;
        Self {
            block,
            kind: if is_near { MAX_KIND } else { 0 },
            max_kind: MAX_KIND - u8::from(!is_fine),
            samples: block.corners.to_vec(),
            tolerance: accuracy.tolerance(level, away),
        }
    }

    /// Begins at the samples of a cell that must have more.
    fn again(block: SampledBlock, cell: &CellSamples) -> Self {
        Self {
            block,
            kind: cell.kind,
            max_kind: cell.max_kind,
            samples: match cell.kind {
                0 => block.corners.to_vec(),
                _ => cell.samples.clone(),
            },
            tolerance: -1.0,
        }
    }

    /// Appends the centers between the samples.
    fn add_centers(&self, places: &mut Vec<Vec3>) {
        let side = UVec3::splat(1 << self.kind);
        let step = self.block.step * (SAMPLED_SIDE >> self.kind) as f32;
        let center = |i: usize| self.block.first + step * (place_of(i, side).as_vec3() + 0.5);
        places.extend((0..volume(side)).map(center));
    }

    /// Appends what else twice as many intervals need.
    fn add_edges(&self, places: &mut Vec<Vec3>) {
        let points = 2 * UVec3::splat(1 << self.kind) + 1;
        let step = self.block.step * (SAMPLED_SIDE >> (self.kind + 1)) as f32;
        let between = (0..volume(points)).map(|i| place_of(i, points));
        let between = between.filter(|&place| is_between(place));
        places.extend(between.map(|place| self.block.first + step * place.as_vec3()));
    }

    /// Takes twice as many intervals, given the distances at the centers. Takes those at the other places from `edges`.
    fn double(&mut self, centers: &[f32], edges: &mut impl Iterator<Item = f32>) {
        let side = UVec3::splat(1 << self.kind);
        let points = 2 * side + 1;
        let value = |i: usize| {
            let place = place_of(i, points);
            match (place % 2).element_sum() {
                0 => self.samples[index(place / 2, side + 1)],
                3 => centers[index(place / 2, side)],
                _ => edges.next().unwrap_or(f32::NAN),
            }
        };
        self.samples = (0..volume(points)).map(value).collect();
        self.kind += 1;
    }
}

/// Whether a place is neither a sample nor a center of half as many intervals.
fn is_between(place: UVec3) -> bool {
    !matches!((place % 2).element_sum(), 0 | 3)
}

/// Samples cells of a level as finely as their distance bends.
fn level_samples(
    nest: &Nest,
    level: usize,
    indices: &[usize],
    accuracy: &Accuracy,
    measure: &dyn DistanceSampler,
) -> Vec<CellSamples> {
    let count = nest.levels[level].count;
    let is_open = |index: &usize| !nest.is_covered(level, place_of(*index, count));
    let open: Vec<usize> = (0..indices.len())
        .filter(|&position| is_open(&indices[position]))
        .collect();
    let block = |&position: &usize| {
        let index = indices[position];
        block_of(nest, NestCell { level, index })
    };
    let blocks: Vec<SampledBlock> = open.iter().map(block).collect();
    let away = clearances(&blocks, measure);
    let begun = blocks.into_iter().zip(away);
    let begun = begun.map(|(block, away)| SampledCell::new(level, block, away, accuracy));
    let mut cells: Vec<SampledCell> = begun.collect();
    for cell in cells.iter_mut().filter(|cell| cell.kind == MAX_KIND) {
        cell.samples = vec![0.0; volume(UVec3::splat(SAMPLED_SIDE + 1))];
        measure.sample_block(&cell.block, &mut cell.samples);
    }
    for kind in 0..MAX_KIND {
        refine(&mut cells, kind, measure);
    }
    let mut all: Vec<CellSamples> = indices.iter().map(|_| CellSamples::default()).collect();
    for (position, cell) in open.into_iter().zip(cells) {
        let SampledCell { kind, max_kind, .. } = cell;
        let samples = if kind == 0 { Vec::new() } else { cell.samples };
        all[position] = CellSamples {
            kind,
            max_kind,
            samples,
        };
    }
    all
}

/// Returns lower bounds on how far the surface is from blocks: it is no nearer than their center says.
fn clearances(blocks: &[SampledBlock], measure: &dyn DistanceSampler) -> Vec<f32> {
    let half = |block: &SampledBlock| 0.5 * 3f32.sqrt() * block.step * SAMPLED_SIDE as f32;
    let nearest = |block: &SampledBlock| {
        let corners = block.corners.iter();
        corners.fold(f32::INFINITY, |least, d| least.min(d.abs()))
    };
    let is_unclear =
        |block: &&SampledBlock| nearest(block) <= 2.0 * half(block) + NEAR_VOXELS * block.step;
    let center = |block: &SampledBlock| block.first + 0.5 * block.step * SAMPLED_SIDE as f32;
    let centers: Vec<Vec3> = blocks.iter().filter(is_unclear).map(center).collect();
    let mut distances = vec![0.0; centers.len()];
    if !centers.is_empty() {
        measure.unsigned_distances(&centers, &mut distances);
    }
    let mut distances = distances.into_iter();
    let distance = |block: &SampledBlock| match is_unclear(&block) {
        true => distances.next().unwrap_or(0.0),
        false => nearest(block),
    };
    let all: Vec<f32> = blocks.iter().map(distance).collect();
    all.iter()
        .zip(blocks)
        .map(|(d, block)| d - half(block))
        .collect()
}

/// Doubles the intervals of cells of a kind whose error is too large.
fn refine(cells: &mut [SampledCell], kind: u8, measure: &dyn DistanceSampler) {
    let may = |cell: &&mut SampledCell| cell.kind == kind && kind < cell.max_kind;
    let mut cells: Vec<&mut SampledCell> = cells.iter_mut().filter(may).collect();
    let distances = |places: &[Vec3]| {
        let mut distances = vec![0.0; places.len()];
        if !places.is_empty() {
            measure.distances(places, &mut distances);
        }
        distances
    };
    let mut places = Vec::new();
    for cell in &cells {
        cell.add_centers(&mut places);
    }
    let centers = distances(&places);
    let of_cells = centers.chunks(volume(UVec3::splat(1 << kind)));
    let rough: Vec<_> = cells
        .iter_mut()
        .zip(of_cells)
        .filter(|(cell, centers)| {
            // A distance that is not a number is refused later.
            error_at_centers(kind, &cell.samples, centers) > cell.tolerance
        })
        .collect();
    places.clear();
    for (cell, _) in &rough {
        cell.add_edges(&mut places);
    }
    let mut edges = distances(&places).into_iter();
    for (cell, centers) in rough {
        cell.double(centers, &mut edges);
    }
}

/// Returns the largest error of interpolation at the centers between samples.
fn error_at_centers(kind: u8, samples: &[f32], centers: &[f32]) -> f32 {
    let side = UVec3::splat(1 << kind);
    let error = |(i, d): (usize, &f32)| {
        let around = corners(place_of(i, side)).map(|p| samples[index(p, side + 1)]);
        (around.iter().sum::<f32>() / 8.0 - d).abs()
    };
    centers.iter().enumerate().map(error).fold(0.0, f32::max)
}
