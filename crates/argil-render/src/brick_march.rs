//! The loop in which the rays of a tile march through bricks: sparse ones, or those of levels of detail.

use crate::bricks::step::StepOutcome;
use crate::bricks::voxel_intersect::NearLanes;
use crate::probe::FieldProbe;
use crate::ray_batch::{Points, RayBatch};
use crate::tile::Tile;
use crate::trace::{
    central_difference_points, face_clips, intersect_ground, set_clip_normal, set_normals,
};
use argil_abi::{self as abi, FrameUniform, Hit};
use argil_field::LANES;
use argil_math::{Ray, set_indices};
use glam::Vec3;
use std::ops::Range;

/// Bricks that rays march through.
pub(crate) trait MarchedBricks {
    /// Takes one step of a range of rays, at most [`LANES`].
    fn step(
        &mut self,
        frame: &FrameUniform,
        steps: u32,
        wave: &mut RayBatch,
        range: Range<usize>,
        found: &mut StepOutcome,
    );

    /// Intersects some of the rays, at most [`LANES`], with the surface in their voxels. `lanes` holds their
    /// directions and lengths.
    fn intersect(
        &mut self,
        frame: &FrameUniform,
        wave: &RayBatch,
        rays: &[u32],
        lanes: &mut NearLanes,
    );
}

/// Rays near the surface, in batches of their own.
#[derive(Default)]
pub(crate) struct NearRays {
    /// Their indices in the batch.
    rays: Vec<u32>,
    lanes: Box<NearLanes>,
}

/// Marches rays until all have ended, and writes what they hit.
pub(crate) fn march(
    frame: &FrameUniform,
    bricks: &mut impl MarchedBricks,
    near: &mut NearRays,
    wave: &mut RayBatch,
    out: &mut [Hit],
) {
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
            bricks.step(frame, steps, wave, range, &mut found);
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
                    // Without a brick: toward the viewer.
                    let [x, y, z] = [0, 1, 2].map(|axis: usize| -wave.direction[axis][ray]);
                    hit.normal_t = [x, y, z, wave.t[ray]];
                    if steps == 1 {
                        face_clip(frame, wave, ray, hit);
                    }
                }
                wave.retire(ray);
            }
        }
        intersect_near_rays(frame, bricks, steps, near, wave, out);
        wave.compact();
    }
}

/// Replaces normals by those of the field where that is asked for, and adds the ground.
pub(crate) fn finish(
    frame: &FrameUniform,
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    (hits, points): (&mut Vec<u32>, &mut Points),
    out: &mut [Hit],
) {
    if frame.normals == abi::NORMALS_FIELD {
        hits.clear();
        let is_hit = |&i: &u32| out[i as usize].kind != abi::HIT_NONE;
        hits.extend((0..tile.area() as u32).filter(is_hit));
        central_difference_points(frame, tile, hits, points, out);
        probe.measure(points);
        set_normals(frame, tile, hits, points, out);
        face_clips(frame, tile, hits, out);
    }
    intersect_ground(frame, tile, out);
}

/// Sets the normal of a ray that hit with its first step, where the box clips a solid.
#[cold]
fn face_clip(frame: &FrameUniform, wave: &RayBatch, ray: usize, hit: &mut Hit) {
    let primary_ray = Ray {
        origin: Vec3::from(frame.eye),
        direction: Vec3::from([0, 1, 2].map(|axis: usize| wave.direction[axis][ray])),
    };
    set_clip_normal(frame, primary_ray, hit);
}

fn kind_of(side: f32) -> u32 {
    if side < 0.0 {
        abi::HIT_INSIDE
    } else {
        abi::HIT_OUTSIDE
    }
}

/// Writes what a ray looked up.
fn end<'a>(wave: &RayBatch, ray: usize, out: &'a mut [Hit]) -> &'a mut Hit {
    let hit = &mut out[wave.pixel[ray] as usize];
    hit.steps += wave.samples[ray] + wave.cells[ray];
    hit.cells += wave.cells[ray];
    hit
}

/// Solves the cubics of the rays near the surface. Rays that hit end, and the others continue behind their voxel.
fn intersect_near_rays(
    frame: &FrameUniform,
    bricks: &mut impl MarchedBricks,
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
        bricks.intersect(frame, wave, rays, lanes);
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
                if steps == 1 {
                    face_clip(frame, wave, ray, hit);
                }
                wave.retire(ray);
            } else if lanes.t[i] > wave.end[ray] || steps >= frame.max_steps {
                end(wave, ray, out);
                wave.retire(ray);
            }
        }
    }
}
