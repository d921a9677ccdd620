//! Rays through sparse bricks. `bricks.wgsl` is the twin.
//!
//! *Theory.* In an empty cell, a ray advances by the cell's bound, and at least to the end of the cell, or of the
//! block if that is empty. In a brick it sphere traces the interpolated distance until that is below half a voxel.
//! Then the distance along the ray within the voxel is a cubic polynomial, whose first root is the surface (Parker
//! et al., "Interactive ray tracing for isosurface rendering", 1998; Hansson-Söderlund, Evans and Akenine-Möller,
//! "Ray tracing of signed distance function grids", 2022). A ray that comes closer than half of its pixel also
//! hits.
//!
//! *Practice.* Cones around 8×8 pixels go first (`cones.rs`), and rays begin where theirs ended. A tile's rays
//! march together in batches. Those near the surface are gathered, and their voxels' cubics are solved in batches
//! of their own. The normal comes from differences over one voxel around the point, from the voxel's gradient, or
//! from the field.

mod cones;
mod rays;
pub(crate) mod step;
pub(crate) mod voxel_intersect;

use crate::probe::FieldProbe;
use crate::ray_batch::{Points, RayBatch, RaySetup};
use crate::source::{DistanceSource, RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use crate::trace::{central_difference_points, intersect_ground, set_indices, set_normals};
use argil_abi::{self as abi, FrameUniform, GpuMaterial, Hit};
use argil_field::LANES;
use argil_volume::Bricks;
use cones::CONE_SIDE;
pub(crate) use cones::{ConeDistances, Cones};
use glam::Vec3;
use rays::BrickRays;
use step::{StepOutcome, step_i8, step_i16};
use voxel_intersect::{NearLanes, solve_i8, solve_i16};

impl RenderSource for Bricks {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        Some(Box::new(BrickRays::new(self)?))
    }
}

impl RayTracer for BrickRays<'_> {
    fn needs_field(&self, _: u32) -> bool {
        false
    }

    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_bricks(frame, tile, self, probe, scratch, out);
    }

    fn distance_source(&self) -> Option<&dyn DistanceSource> {
        Some(self)
    }
}

impl DistanceSource for BrickRays<'_> {
    fn material(
        &self,
        point: Vec3,
        outwards: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        self.look(point, outwards, palette)
    }

    fn measure(&self, points: &mut Points) {
        let Points { x, y, z, d } = points;
        d.resize(x.len(), 0.0);
        for first in (0..x.len()).step_by(LANES) {
            let r = first..(first + LANES).min(x.len());
            let p = [&x[r.clone()], &y[r.clone()], &z[r.clone()]];
            self.estimates(p, &mut d[r]);
        }
    }
}

/// Buffers that only this tracer needs.
#[derive(Default)]
struct BrickScratch {
    cones: Cones,
    near: NearRays,
}

/// Rays near the surface, in batches of their own.
#[derive(Default)]
struct NearRays {
    /// Their indices in the batch.
    rays: Vec<u32>,
    lanes: Box<NearLanes>,
}

/// Traces the primary ray of each pixel of a tile into `out`, row by row.
fn trace_bricks(
    frame: &FrameUniform,
    tile: Tile,
    bricks: &BrickRays<'_>,
    probe: &mut FieldProbe<'_>,
    scratch: &mut TileScratch,
    out: &mut [Hit],
) {
    let TileScratch {
        starts,
        wave,
        own,
        points,
        hits,
        ..
    } = scratch;
    let BrickScratch { cones, near } = own.of();
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    cones.march(frame, tile, starts, &mut &*bricks, out);
    start(tile, starts, cones, wave);

    let mut steps = 0;
    while wave.len() > 0 {
        steps += 1;
        near.rays.clear();
        for first in (0..wave.len()).step_by(LANES) {
            let range = first..(first + LANES).min(wave.len());
            let mut found = StepOutcome {
                near: [0; LANES],
                reached: [0; LANES],
                ended: [0; LANES],
            };
            match bricks {
                BrickRays::Eight(s, _) => step_i8(frame, s, steps, wave, range, &mut found),
                BrickRays::Sixteen(s, _) => step_i16(frame, s, steps, wave, range, &mut found),
            }
            for i in set_indices(&found.ended) {
                let ray = first + i;
                if found.near[i] != 0 {
                    near.rays.push(ray as u32);
                    continue;
                }
                let hit = end(wave, ray, out);
                if found.reached[i] != 0 {
                    hit.kind = kind_of(wave.side[ray]);
                    hit.id = 1 + wave.level[ray];
                    // Where the box clips a solid, or there is no brick: toward the viewer.
                    let [x, y, z] = [0, 1, 2].map(|axis: usize| -wave.direction[axis][ray]);
                    hit.normal_t = [x, y, z, wave.t[ray]];
                }
                wave.retire(ray);
            }
        }
        intersect_near_rays(frame, bricks, steps, near, wave, out);
        wave.compact();
    }
    if frame.normals == abi::NORMALS_FIELD {
        hits.clear();
        let is_hit = |&i: &u32| out[i as usize].kind != abi::HIT_NONE;
        hits.extend((0..tile.area() as u32).filter(is_hit));
        central_difference_points(frame, tile, hits, points, out);
        probe.measure(points);
        set_normals(frame, tile, hits, points, out);
    }
    intersect_ground(frame, tile, out);
}

/// Loads the rays whose cones did not prove that they miss.
pub(crate) fn start(tile: Tile, starts: &RaySetup, cones: &Cones, wave: &mut RayBatch) {
    wave.clear();
    let [x, y, z] = &starts.direction;
    for row in 0..tile.rows {
        for first in (0..tile.width).step_by(CONE_SIDE as usize) {
            let begin = cones.begin(first, row);
            if begin == f32::INFINITY {
                continue;
            }
            for column in first..(first + CONE_SIDE).min(tile.width) {
                let i = (row * tile.width + column) as usize;
                let (near, far) = (starts.near[i], starts.far[i]);
                let from = if begin > near { begin } else { near };
                if near <= far && from <= far {
                    wave.push(i as u32, Vec3::new(x[i], y[i], z[i]), (from, far));
                    // For the first step: whether the ray comes from outside the box.
                    if let Some(side) = wave.side.last_mut() {
                        *side = if near > 0.0 { 2.0 } else { 0.0 };
                    }
                }
            }
        }
    }
}

pub(crate) fn kind_of(side: f32) -> u32 {
    if side < 0.0 {
        abi::HIT_INSIDE
    } else {
        abi::HIT_OUTSIDE
    }
}

/// Writes what a ray looked up.
pub(crate) fn end<'a>(wave: &RayBatch, ray: usize, out: &'a mut [Hit]) -> &'a mut Hit {
    let hit = &mut out[wave.pixel[ray] as usize];
    hit.steps += wave.samples[ray] + wave.cells[ray];
    hit.cells += wave.cells[ray];
    hit
}

/// Solves the cubics of the rays near the surface. Rays that hit end, and the others continue behind their voxel.
fn intersect_near_rays(
    frame: &FrameUniform,
    bricks: &BrickRays<'_>,
    steps: u32,
    near: &mut NearRays,
    wave: &mut RayBatch,
    out: &mut [Hit],
) {
    let lanes = &mut near.lanes;
    for rays in near.rays.chunks(LANES) {
        for (i, &ray) in rays.iter().enumerate() {
            let ray = ray as usize;
            for axis in 0..3 {
                lanes.direction[axis][i] = wave.direction[axis][ray];
            }
            lanes.t[i] = wave.t[ray];
            lanes.side[i] = wave.side[ray];
        }
        match bricks {
            BrickRays::Eight(sampler, _) => solve_i8(frame, sampler, rays.len(), lanes),
            BrickRays::Sixteen(sampler, _) => solve_i16(frame, sampler, rays.len(), lanes),
        }
        for (i, &ray) in rays.iter().enumerate() {
            let ray = ray as usize;
            wave.t[ray] = lanes.t[i];
            wave.samples[ray] += 1;
            if lanes.hit[i] != 0 {
                let hit = end(wave, ray, out);
                hit.kind = kind_of(wave.side[ray]);
                hit.id = 1 + wave.level[ray];
                let [x, y, z] = [0, 1, 2].map(|axis: usize| lanes.normal[axis][i]);
                hit.normal_t = [x, y, z, lanes.t[i]];
                wave.retire(ray);
            } else if lanes.t[i] > wave.end[ray] || steps >= frame.max_steps {
                end(wave, ray, out);
                wave.retire(ray);
            }
        }
    }
}
