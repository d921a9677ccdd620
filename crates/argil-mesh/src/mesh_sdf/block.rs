//! Computes the distances of a block of samples.
//!
//! *Practice.* The tree is searched for every fourth point. Those distances bound the points between them. If they
//! are far, nothing more is computed. If they are not near, the leaves nearest to the surrounding points suffice.
//! The others are searched. Signs spread from the block's corners between points whose free spheres touch. Only
//! points that none reaches need a winding number.

use super::MeshSdf;
use super::tree::{gap_square, leaf_square};
use argil_scene::{SAMPLED_SIDE, SampledBlock};
use glam::{UVec3, Vec3, uvec3};

/// Points along a block's side.
const SIDE: usize = SAMPLED_SIDE as usize + 1;
const POINTS: usize = SIDE * SIDE * SIDE;
/// Intervals between points that are searched first, and their number along a side.
const STRIDE: usize = 4;
const KNOTS: usize = SAMPLED_SIDE as usize / STRIDE + 1;

/// Maximum intervals from a point to the nearest of eight knots around it.
const WIDEST: f32 = 3.465;

/// A point that was searched.
#[derive(Clone, Copy, Default)]
struct SampleKnot {
    place: Vec3,
    d: f32,
    leaf: u32,
}

#[inline(always)]
pub(super) fn measure(solid: &MeshSdf, block: &SampledBlock, out: &mut [f32]) {
    let mut stack = Vec::with_capacity(64);
    let mut knots = [SampleKnot::default(); KNOTS * KNOTS * KNOTS];
    let mut hint = 0;
    for (i, knot) in knots.iter_mut().enumerate() {
        let inner = uvec3(
            (i % KNOTS) as u32,
            (i / KNOTS % KNOTS) as u32,
            (i / KNOTS / KNOTS) as u32,
        );
        let place = block.first + block.step * (STRIDE as u32 * inner).as_vec3();
        // All surrounding points are far.
        let lower = known_at(block, inner.as_vec3() / (KNOTS - 1) as f32);
        let (d, leaf) = if lower >= block.far + WIDEST * block.step {
            (lower, hint)
        } else {
            solid.surface.nearest(place, hint, &mut stack)
        };
        hint = leaf;
        *knot = SampleKnot { place, d, leaf };
    }
    let mut at = 0;
    for z in 0..SIDE {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let p = block.first + block.step * uvec3(x as u32, y as u32, z as u32).as_vec3();
                let first = [x, y, z].map(|k| (k / STRIDE).min(KNOTS - 2));
                let around: [&SampleKnot; 8] = std::array::from_fn(|c| {
                    let [x, y, z] = [0, 1, 2].map(|axis| first[axis] + (c >> axis & 1));
                    &knots[(z * KNOTS + y) * KNOTS + x]
                });
                (out[at], hint) = one(solid, block, p, around, hint, &mut stack);
                at += 1;
            }
        }
    }
    signs(solid, block, out);
}

/// Returns a lower bound of a point's distance from the block's corners.
#[inline(always)]
fn known_at(block: &SampledBlock, inner: Vec3) -> f32 {
    let length = block.step * SAMPLED_SIDE as f32;
    let mut lower = 0.0f32;
    for (c, d) in block.corners.iter().enumerate() {
        let corner = Vec3::new((c & 1) as f32, (c >> 1 & 1) as f32, (c >> 2) as f32);
        lower = lower.max(d.abs() - length * inner.distance(corner));
    }
    lower
}

/// Returns the unsigned distance of a point between eight known ones, and its leaf.
#[inline(always)]
fn one(
    solid: &MeshSdf,
    block: &SampledBlock,
    p: Vec3,
    around: [&SampleKnot; 8],
    hint: u32,
    stack: &mut Vec<(f32, u32)>,
) -> (f32, u32) {
    let mut lower = 0.0f32;
    let mut nearest = around[0];
    let mut least = f32::INFINITY;
    for knot in around {
        let way = p.distance(knot.place);
        lower = lower.max(knot.d - way);
        if knot.d + way < least {
            (least, nearest) = (knot.d + way, knot);
        }
    }
    if lower >= block.far {
        return (lower, hint);
    }
    let square = leaf_square(&solid.surface.leaves[nearest.leaf as usize], p);
    let mut best = nearer_in(solid, p, hint, (square, nearest.leaf));
    if lower >= block.near {
        for knot in around {
            best = nearer_in(solid, p, knot.leaf, best);
        }
    } else {
        best = solid.surface.nearer(p, best, stack);
    }
    (best.0.sqrt(), best.1)
}

/// Returns the smaller squared distance, and its leaf, of a known one and another leaf.
#[inline(always)]
fn nearer_in(solid: &MeshSdf, p: Vec3, leaf: u32, best: (f32, u32)) -> (f32, u32) {
    let [low, high] = solid.surface.boxes[leaf as usize];
    if leaf == best.1 || gap_square(low, high, p) >= best.0 {
        return best;
    }
    let square = leaf_square(&solid.surface.leaves[leaf as usize], p);
    if square < best.0 {
        (square, leaf)
    } else {
        best
    }
}

/// Gives distances their signs.
#[inline(always)]
pub(super) fn signs(solid: &MeshSdf, block: &SampledBlock, out: &mut [f32]) {
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
        let own = out[at];
        for (axis, stride) in [1, SIDE, SIDE * SIDE].into_iter().enumerate() {
            let has = [place[axis] > 0, (place[axis] as usize) < SIDE - 1];
            for (has, other) in has.into_iter().zip([at.wrapping_sub(stride), at + stride]) {
                if has && !is_known[other] && own.abs() + out[other] > way {
                    out[other] = out[other].copysign(own);
                    is_known[other] = true;
                    todo.push(other as u16);
                }
            }
        }
    }
}
