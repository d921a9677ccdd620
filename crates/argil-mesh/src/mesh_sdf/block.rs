//! Computes the distances of a block of samples.
//!
//! *Practice.* Signs spread from the block's corners between points whose free spheres touch.
//! Only points that none reaches need a winding number.

use super::MeshSdf;
use crate::nearest::NearestSearch;
use argil_scene::{SAMPLED_SIDE, SampledBlock};
use glam::{UVec3, uvec3};

/// Points along a block's side.
const SIDE: usize = SAMPLED_SIDE as usize + 1;
const POINTS: usize = SIDE * SIDE * SIDE;

#[inline(always)]
pub(super) fn measure(solid: &MeshSdf, block: &SampledBlock, out: &mut [f32]) {
    let mut search = NearestSearch::new(&solid.surface.nearest);
    for (at, out) in out.iter_mut().enumerate() {
        *out = search.distance(block.position(at));
    }
    signs(solid, block, out);
}

/// Gives distances their signs.
#[inline(always)]
fn signs(solid: &MeshSdf, block: &SampledBlock, out: &mut [f32]) {
    let mut is_known = [false; POINTS];
    let mut todo: Vec<u16> = Vec::with_capacity(POINTS);
    for (c, corner) in block.corners.iter().enumerate() {
        let [x, y, z] = [0, 1, 2].map(|axis| (SIDE - 1) * (c >> axis & 1));
        let at = (z * SIDE + y) * SIDE + x;
        out[at] = out[at].copysign(*corner);
        is_known[at] = true;
        todo.push(at as u16);
    }
    spread(block, out, &mut is_known, &mut todo);
    for at in 0..POINTS {
        if is_known[at] {
            continue;
        }
        let is_in = match beside(block, out, &is_known, at) {
            Some(other) => other < 0.0,
            None => solid.winding_number(block.position(at)) > 0.5,
        };
        if is_in {
            out[at] = -out[at];
        }
        is_known[at] = true;
        todo.push(at as u16);
        spread(block, out, &mut is_known, &mut todo);
    }
}

fn place_of(at: usize) -> UVec3 {
    uvec3(
        (at % SIDE) as u32,
        (at / SIDE % SIDE) as u32,
        (at / SIDE / SIDE) as u32,
    )
}

/// Calls with the neighbors of a point, across edges and corners too, whose free spheres touch its own.
#[inline(always)]
fn beside(block: &SampledBlock, out: &[f32], is_known: &[bool; POINTS], at: usize) -> Option<f32> {
    let place = place_of(at);
    let low = place.saturating_sub(UVec3::ONE);
    let high = (place + 1).min(UVec3::splat(SIDE as u32 - 1));
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let other = (z as usize * SIDE + y as usize) * SIDE + x as usize;
                let way = (uvec3(x, y, z).as_vec3() - place.as_vec3()).length();
                let reach = out[other].abs() + out[at];
                if is_known[other] && reach > 1.0001 * block.step * way {
                    return Some(out[other]);
                }
            }
        }
    }
    None
}

/// Spreads signs from known points to their neighbors.
#[inline(always)]
fn spread(
    block: &SampledBlock,
    out: &mut [f32],
    is_known: &mut [bool; POINTS],
    todo: &mut Vec<u16>,
) {
    let way = 1.0001 * block.step;
    while let Some(at) = todo.pop() {
        let at = usize::from(at);
        let place = place_of(at).to_array();
        let d = out[at];
        for (axis, stride) in [1, SIDE, SIDE * SIDE].into_iter().enumerate() {
            let has = [place[axis] > 0, (place[axis] as usize) < SIDE - 1];
            for (has, other) in has.into_iter().zip([at.wrapping_sub(stride), at + stride]) {
                if has && !is_known[other] && d.abs() + out[other] > way {
                    out[other] = out[other].copysign(d);
                    is_known[other] = true;
                    todo.push(other as u16);
                }
            }
        }
    }
}
