//! Rays through levels of detail.
//!
//! *Theory.* A ray reads the level whose voxels are as large as its pixel, or the finest resident one above it. A
//! page that is too coarse is off by at most half of its voxels' diagonal, times the Lipschitz constant: the ray
//! steps by the distance less that, and ends there. So it never passes through a surface that a finer page would
//! show.
//!
//! *Practice.* Rays march as through sparse bricks (`bricks.rs`), each with a voxel size of its own. Where levels
//! change, a pixel's hash decides, so that the border is dithered over a part of a level. A tile notes the pages
//! that it used, and those it lacked.

mod rays;
mod step;

use crate::bricks::step::StepOutcome;
use crate::bricks::{Cones, end, kind_of, start};
use crate::probe::FieldProbe;
use crate::ray_batch::RayBatch;
use crate::source::{RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use crate::trace::{central_difference_points, intersect_ground, set_indices, set_normals};
use argil_abi::{self as abi, FrameUniform, Hit};
use argil_field::LANES;
use argil_volume::{LevelLanes, Levels, NO_REQUEST, PageRequest};
use rays::{LevelCones, LevelRays};
use step::NearLevelLanes;

impl RenderSource for Levels {
    fn tracer<'a>(&'a self, frame: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        self.begin_frame();
        Some(Box::new(LevelRays::new(self, frame)?))
    }
}

impl RayTracer for LevelRays<'_> {
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        trace_levels(frame, tile, self, probe, scratch, out);
    }
}

/// Buffers that only this tracer needs.
#[derive(Default)]
struct LevelScratch {
    cones: Cones,
    lanes: Box<LevelLanes>,
    near: Box<NearLevelLanes>,
    near_rays: Vec<u32>,
    notes: PageNotes,
}

/// What a tile used and lacked.
#[derive(Default)]
pub(crate) struct PageNotes {
    pub used: Vec<u32>,
    pub asked: Vec<PageRequest>,
}

impl PageNotes {
    /// Notes the cell of a lane, and what it lacks.
    #[inline(always)]
    fn note(&mut self, lanes: &LevelLanes, i: usize, distance: f32) {
        let cell = lanes.at.index[i];
        if self.used.last() != Some(&cell) {
            self.used.push(cell);
        }
        let key = lanes.key[i];
        if key != NO_REQUEST && self.asked.last().is_none_or(|last| last.key != key) {
            self.asked.push(PageRequest {
                key,
                gap: lanes.gap[i],
                distance,
            });
        }
    }
}

/// Traces the primary ray of each pixel of a tile into `out`, row by row.
fn trace_levels(
    frame: &FrameUniform,
    tile: Tile,
    rays: &LevelRays<'_>,
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
    let LevelScratch {
        cones,
        lanes,
        near,
        near_rays,
        notes,
    } = own.of();
    notes.used.clear();
    notes.asked.clear();
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    let mut around = LevelCones::new(frame, rays, lanes, notes);
    cones.march(frame, tile, starts, &mut around, out);
    start(tile, starts, cones, wave);
    wave.page.fill(rays.any_page());

    let mut steps = 0;
    while wave.len() > 0 {
        steps += 1;
        near_rays.clear();
        for first in (0..wave.len()).step_by(LANES) {
            let range = first..(first + LANES).min(wave.len());
            let mut found = StepOutcome {
                near: [0; LANES],
                reached: [0; LANES],
                ended: [0; LANES],
            };
            rays.step(frame, steps, wave, range, (lanes, notes), &mut found);
            for i in set_indices(&found.ended) {
                let ray = first + i;
                if found.near[i] != 0 {
                    near_rays.push(ray as u32);
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
        solve_near(
            frame,
            rays,
            steps,
            near_rays,
            (near, lanes, notes),
            wave,
            out,
        );
        wave.compact();
    }
    rays.note(notes);
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

/// Solves the cubics of the rays near the surface. Rays that hit end, and the others continue behind their voxel.
fn solve_near(
    frame: &FrameUniform,
    rays: &LevelRays<'_>,
    steps: u32,
    near_rays: &[u32],
    (near, lanes, notes): (&mut NearLevelLanes, &mut LevelLanes, &mut PageNotes),
    wave: &mut RayBatch,
    out: &mut [Hit],
) {
    for some in near_rays.chunks(LANES) {
        for (i, &ray) in some.iter().enumerate() {
            let ray = ray as usize;
            for axis in 0..3 {
                near.rays.direction[axis][i] = wave.direction[axis][ray];
            }
            near.rays.t[i] = wave.t[ray];
            near.rays.side[i] = wave.side[ray];
            near.pixel[i] = wave.pixel[ray];
            lanes.page[i] = wave.page[ray];
        }
        rays.solve(frame, some.len(), near, (lanes, notes));
        for (i, &ray) in some.iter().enumerate() {
            let ray = ray as usize;
            wave.t[ray] = near.rays.t[i];
            wave.samples[ray] += 1;
            if near.rays.hit[i] != 0 {
                let hit = end(wave, ray, out);
                hit.kind = kind_of(wave.side[ray]);
                hit.id = 1 + wave.level[ray];
                let [x, y, z] = [0, 1, 2].map(|axis: usize| near.rays.normal[axis][i]);
                hit.normal_t = [x, y, z, near.rays.t[i]];
                wave.retire(ray);
            } else if near.rays.t[i] > wave.end[ray] || steps >= frame.max_steps {
                end(wave, ray, out);
                wave.retire(ray);
            }
        }
    }
}
