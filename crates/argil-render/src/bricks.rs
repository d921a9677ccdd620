//! Rays through sparse bricks. `bricks.wgsl` is the twin.
//!
//! *Theory.* In an empty cell, a ray advances by the cell's bound, and at least to the end of the cell, or of the
//! block if that is empty. In a brick it sphere traces the interpolated distance until that is below half a voxel.
//! Then the distance along the ray within the voxel is a cubic polynomial, whose first root is the surface (Parker
//! et al., "Interactive ray tracing for isosurface rendering", 1998; Hansson-Söderlund, Evans and Akenine-Möller,
//! "Ray tracing of signed distance function grids", 2022). The size of a pixel ends no ray: that would widen solids.
//!
//! *Practice.* Cones around 8×8 pixels go first (`cones.rs`), and rays begin where theirs ended. A tile's rays
//! march together in batches. Those near the surface are gathered, and their voxels' cubics are solved in batches
//! of their own. The normal comes from differences over one voxel around the point, from the voxel's gradient, or
//! from the field.

mod cones;
mod lit;
mod rays;
pub(crate) mod step;
pub(crate) mod voxel_intersect;

use crate::brick_march::{MarchedBricks, NearRays, finish, march};
use crate::probe::FieldProbe;
use crate::ray_batch::{RayBatch, RaySetup};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{FrameUniform, Hit};
use cones::CONE_SIDE;
pub(crate) use cones::{ConeDistances, Cones};
use glam::Vec3;
pub use lit::LitBricks;
use rays::BrickRays;
use std::ops::Range;
use step::{StepOutcome, step_i8, step_i16};
use voxel_intersect::{NearLanes, solve_i8, solve_i16};

/// Buffers that only this tracer needs.
#[derive(Default)]
struct BrickScratch {
    cones: Cones,
    near: NearRays,
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
        source,
        points,
        hits,
        ..
    } = scratch;
    let BrickScratch { cones, near } = source.of();
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    cones.march(frame, tile, starts, &mut &*bricks, out);
    start(tile, starts, cones, wave);

    march(frame, &mut &*bricks, near, wave, out);
    finish(frame, tile, probe, (hits, points), out);
}

impl MarchedBricks for &BrickRays<'_> {
    fn step(
        &mut self,
        frame: &FrameUniform,
        steps: u32,
        wave: &mut RayBatch,
        range: Range<usize>,
        found: &mut StepOutcome,
    ) {
        match self {
            BrickRays::Eight(s) => step_i8(frame, s, steps, wave, range, found),
            BrickRays::Sixteen(s) => step_i16(frame, s, steps, wave, range, found),
        }
    }

    fn intersect(
        &mut self,
        frame: &FrameUniform,
        _: &RayBatch,
        rays: &[u32],
        lanes: &mut NearLanes,
    ) {
        match self {
            BrickRays::Eight(s) => solve_i8(frame, s, rays.len(), lanes),
            BrickRays::Sixteen(s) => solve_i16(frame, s, rays.len(), lanes),
        }
    }
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
