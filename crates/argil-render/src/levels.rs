//! Rays through levels of detail.
//!
//! *Theory.* A ray reads the level whose voxels are as large as its pixel, or the finest resident one above it. A
//! page that is too coarse is off by at most half of its voxels' diagonal, times the Lipschitz constant: the ray
//! steps by the distance less that, and ends there. So it never passes through a surface that a finer page would
//! show.
//!
//! *Practice.* Rays march as through sparse bricks (`bricks.rs`), each with a voxel size of its own. Where levels
//! change, a pixel's hash decides, so that the border is dithered over a part of a level. A tile marks the
//! cells that it used, and notes what it lacked.

mod light;
mod notes;
mod rays;
mod step;

use crate::brick_march::{MarchedBricks, NearRays, finish, march};
use crate::bricks::step::StepOutcome;
use crate::bricks::voxel_intersect::NearLanes;
use crate::bricks::{Cones, start};
use crate::probe::FieldProbe;
use crate::ray_batch::RayBatch;
use crate::source::{DistanceSource, RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, FrameUniform, Hit};
use argil_volume::{LevelLanes, Levels};
use notes::PageNotes;
use rays::{LevelCones, LevelRays};
use std::ops::Range;

impl RenderSource for Levels {
    fn tracer<'a>(&'a self, frame: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        self.begin_frame();
        Some(Box::new(LevelRays::new(self, frame)?))
    }
}

impl RayTracer for LevelRays<'_> {
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
        trace_levels(frame, tile, self, probe, scratch, out);
    }

    fn distance_source(&self) -> Option<&dyn DistanceSource> {
        Some(self)
    }
}

/// Buffers that only this tracer needs.
#[derive(Default)]
struct LevelScratch {
    cones: Cones,
    lanes: Box<LevelLanes>,
    near: NearRays,
    pixels: Vec<u32>,
    notes: PageNotes,
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
        source,
        points,
        hits,
        ..
    } = scratch;
    let LevelScratch {
        cones,
        lanes,
        near,
        pixels,
        notes,
    } = source.of();
    notes.asked.clear();
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    let mut around = LevelCones::new(rays, lanes, notes);
    cones.march(frame, tile, starts, &mut around, out);
    start(tile, starts, cones, wave);
    wave.page.fill(rays.any_page());

    let mut marched = MarchedLevels {
        rays,
        lanes,
        pixels,
        notes,
    };
    march(frame, &mut marched, near, wave, out);
    for hit in out[..tile.area()].iter_mut().filter(|hit| hit.id != 0) {
        match frame.mode {
            abi::MODE_LEVELS => hit.id = rays.level_id(hit.id - 1, hit.normal_t[3]),
            abi::MODE_BRICKS => hit.id = rays.place_id(hit.id - 1),
            _ => {}
        }
    }
    rays.note(notes);
    finish(frame, tile, probe, (hits, points), out);
}

/// Levels, with the buffers of a tile.
struct MarchedLevels<'a, 'b> {
    rays: &'a LevelRays<'b>,
    lanes: &'a mut LevelLanes,
    pixels: &'a mut Vec<u32>,
    notes: &'a mut PageNotes,
}

impl MarchedBricks for MarchedLevels<'_, '_> {
    fn step(
        &mut self,
        frame: &FrameUniform,
        steps: u32,
        wave: &mut RayBatch,
        range: Range<usize>,
        found: &mut StepOutcome,
    ) {
        let notes = (&mut *self.lanes, &mut *self.notes);
        self.rays.step(frame, steps, wave, range, notes, found);
    }

    fn intersect(
        &mut self,
        frame: &FrameUniform,
        wave: &RayBatch,
        rays: &[u32],
        lanes: &mut NearLanes,
    ) {
        self.pixels.clear();
        for (&ray, page) in rays.iter().zip(&mut self.lanes.page) {
            self.pixels.push(wave.pixel[ray as usize]);
            *page = wave.page[ray as usize];
        }
        let notes = (&mut *self.lanes, &mut *self.notes);
        self.rays.solve(frame, self.pixels, lanes, notes);
    }
}
