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
use glam::{IVec3, UVec3, Vec3, uvec3};
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
        let measure = &AtLeastBox { measure, solid };
        let size = solid.size().max_element().max(cell);
        let mut nest = Nest::new(corner, cell);
        nest.add(IVec3::ZERO, cells);
        if measure.knows_outside() {
            let reach = REACH * solid.size().max_element() / cell * UNITS as f32;
            surround(&mut nest, reach as i32);
        }
        for level in 0..nest.levels.len() {
            let own = &nest.levels[level];
            let coarse = coarse_samples(&nest, own, measure);
            nest.levels[level].coarse = coarse;
            let own = &nest.levels[level];
            nest.levels[level].cells = (0..volume(own.count))
                .into_par_iter()
                .map(|index| {
                    if nest.is_covered(level, place_of(index, own.count)) {
                        CellSamples::default()
                    } else {
                        cell_samples(&nest, NestCell { level, index }, size, measure)
                    }
                })
                .collect();
        }
        smooth(&mut nest, measure);
        nest.close_seams();
        Self::of_nest(&nest, solid)
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

    fn unsigned_distance(&self, point: Vec3) -> f32 {
        self.measure.unsigned_distance(point)
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
    let rows = coarse.par_chunks_mut(points.x as usize).enumerate();
    rows.for_each(|(row, out)| {
        let (y, z) = (row as u32 % points.y, row as u32 / points.y);
        let places: Vec<Vec3> = (0..points.x)
            .map(|x| nest.position(level.corner_at(uvec3(x, y, z))))
            .collect();
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
        let samples: Vec<Vec<f32>> = wider
            .par_iter()
            .map(|&cell| {
                let own = &nest.levels[cell.level].cells[cell.index];
                let block = block_of(nest, cell);
                let samples = match own.kind {
                    0 => &block.corners,
                    _ => &own.samples[..],
                };
                let centers = center_samples(&block, own.kind, measure);
                refined(&block, own.kind, (samples, &centers), measure)
            })
            .collect();
        for (&cell, samples) in wider.iter().zip(samples) {
            let own = &mut nest.levels[cell.level].cells[cell.index];
            own.kind += 1;
            own.samples = samples;
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

/// Samples a cell as finely as its distance bends.
fn cell_samples(
    nest: &Nest,
    cell: NestCell,
    size: f32,
    measure: &dyn DistanceSampler,
) -> CellSamples {
    let block = block_of(nest, cell);
    let length = block.step * SAMPLED_SIDE as f32;
    // The surface is no nearer to a cell than its center says.
    let half = 0.5 * 3f32.sqrt() * length;
    let nearest = block
        .corners
        .iter()
        .fold(f32::INFINITY, |least, d| least.min(d.abs()));
    let away = match nearest > 2.0 * half + NEAR_VOXELS * block.step {
        true => nearest - half,
        false => measure.unsigned_distance(block.first + 0.5 * length) - half,
    };
    let voxel = nest.unit * (UNITS / SAMPLED_SIDE as i32) as f32;
    let is_near = away <= NEAR_VOXELS * block.step;
    let is_fine = is_near || cell.level > 0 || away <= CREASE_VOXELS * voxel;
    let max_kind = MAX_KIND - u8::from(!is_fine);
    // Around a long solid, a share of its size is accurate enough, and samples stay few.
    let wide = match cell.level {
        0 => 1.0,
        _ => (size / (FULL_ACCURACY_VOXELS * voxel)).max(1.0),
    };
    let tolerance = TOLERANCE * voxel * wide * (1.0 + 2.0 * away / size);
    let (mut kind, mut samples) = (0, block.corners.to_vec());
    if is_near {
        kind = MAX_KIND;
        samples = vec![0.0; volume(UVec3::splat(SAMPLED_SIDE + 1))];
        measure.sample_block(&block, &mut samples);
    }
    while kind < max_kind {
        let centers = center_samples(&block, kind, measure);
        if error_at_centers(kind, &samples, &centers) <= tolerance {
            break;
        }
        samples = refined(&block, kind, (&samples, &centers), measure);
        kind += 1;
    }
    if kind == 0 {
        samples = Vec::new();
    }
    CellSamples {
        kind,
        max_kind,
        samples,
    }
}

/// Returns the distances at the centers between a cell's samples. It has 2 to the power of `kind` intervals.
fn center_samples(block: &SampledBlock, kind: u8, measure: &dyn DistanceSampler) -> Vec<f32> {
    let side = UVec3::splat(1 << kind);
    let step = block.step * (SAMPLED_SIDE >> kind) as f32;
    let center = |i: usize| block.first + step * (place_of(i, side).as_vec3() + 0.5);
    let centers: Vec<Vec3> = (0..volume(side)).map(center).collect();
    let mut distances = vec![0.0; centers.len()];
    measure.distances(&centers, &mut distances);
    distances
}

/// Returns samples of a cell at twice as many intervals, given those it has, and those at the centers between them.
fn refined(
    block: &SampledBlock,
    kind: u8,
    (samples, centers): (&[f32], &[f32]),
    measure: &dyn DistanceSampler,
) -> Vec<f32> {
    let side = UVec3::splat(1 << kind);
    let points = 2 * side + 1;
    let step = block.step * (SAMPLED_SIDE >> (kind + 1)) as f32;
    let mut out = vec![0.0; volume(points)];
    let (mut indices, mut places) = (Vec::new(), Vec::new());
    for (i, out) in out.iter_mut().enumerate() {
        let place = place_of(i, points);
        match (place % 2).element_sum() {
            0 => *out = samples[index(place / 2, side + 1)],
            3 => *out = centers[index(place / 2, side)],
            _ => {
                indices.push(i);
                places.push(block.first + step * place.as_vec3());
            }
        }
    }
    let mut distances = vec![0.0; places.len()];
    measure.distances(&places, &mut distances);
    for (i, d) in indices.into_iter().zip(distances) {
        out[i] = d;
    }
    out
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
