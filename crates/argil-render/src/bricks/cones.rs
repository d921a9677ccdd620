//! Cones around blocks of pixels. `cones.wgsl` is the twin.
//!
//! *Theory.* A sphere without a surface is free for all rays inside it. A cone around 8×8 pixels advances as long
//! as the free sphere at its axis is wider than the cone. The rays begin there (Claybook, Aaltonen 2018).
//!
//! If the axis is at length t, its rays are within k·t of it, and at length t' within (t' − t) + k·t' of the same
//! point. A free sphere of radius D there is free up to t' = (t + D) / (1 + k).

use crate::camera::bounds_of;
use crate::ray_batch::RaySetup;
use crate::tile::Tile;
use argil_abi::{FrameUniform, Hit};
use argil_field::LANES;
use glam::Vec3;

/// Pixels along a cone's side.
pub(crate) const CONE_SIDE: u32 = argil_abi::CONE_SIDE;
/// Maximum steps of a cone.
const CONE_STEPS: u32 = argil_abi::CONE_STEPS;
/// Distance from a block's center to the corners of its corner pixels, in pixels, and a little more.
const CONE_RADIUS: f32 = argil_abi::CONE_RADIUS;

/// Where cones read how far the surface is.
pub(crate) trait ConeDistances {
    /// Returns the box outside which no cone looks.
    fn bounds(&self) -> argil_math::Aabb;

    /// Computes lower bounds of the signed distance around points in the scene's space, at lengths of their cones,
    /// and the edges of the voxels there.
    fn clearances(&mut self, points: [&[f32]; 3], t: &[f32], out: &mut [f32], voxel: &mut [f32]);
}

/// The cones of a tile.
#[derive(Default)]
pub(crate) struct Cones {
    across: u32,
    /// Where the rays of each block begin; infinity where they all miss.
    begin: Vec<f32>,
    end: Vec<f32>,
    direction: [Vec<f32>; 3],
    under_way: Vec<u32>,
}

impl Cones {
    /// Returns where the rays of a pixel's block begin.
    pub(crate) fn begin(&self, column: u32, row: u32) -> f32 {
        self.begin[(row / CONE_SIDE * self.across + column / CONE_SIDE) as usize]
    }

    /// Marches the cones of a tile. Their steps count with the first pixel of each block.
    pub(crate) fn march(
        &mut self,
        frame: &FrameUniform,
        tile: Tile,
        starts: &RaySetup,
        bricks: &mut impl ConeDistances,
        out: &mut [Hit],
    ) {
        self.start(frame, tile, starts);
        let slope = CONE_RADIUS * frame.pixel_width;
        let bounds = bricks.bounds();
        let eye = Vec3::new(frame.eye[0], frame.eye[1], frame.eye[2]);
        let starts_outside = !bounds_of(frame).contains(eye);
        let mut p = [[0.0f32; LANES]; 3];
        let mut beside = [0.0f32; LANES];
        let mut d = [0.0f32; LANES];
        let (mut t, mut voxel) = ([0.0f32; LANES], [0.0f32; LANES]);
        for _ in 0..CONE_STEPS {
            let count = self.under_way.len();
            if count == 0 {
                break;
            }
            let mut kept = 0;
            for first in (0..count).step_by(LANES) {
                let n = LANES.min(count - first);
                for lane in 0..n {
                    let i = self.under_way[first + lane] as usize;
                    let t = self.begin[i];
                    let direction = Vec3::new(
                        self.direction[0][i],
                        self.direction[1][i],
                        self.direction[2][i],
                    );
                    let at = eye + direction * t;
                    let held = at.clamp(bounds.min, bounds.max);
                    beside[lane] = at.distance(held);
                    for axis in 0..3 {
                        p[axis][lane] = held[axis];
                    }
                }
                for (t, &block) in t.iter_mut().zip(&self.under_way[first..first + n]) {
                    *t = self.begin[block as usize];
                }
                let points = [&p[0][..n], &p[1][..n], &p[2][..n]];
                bricks.clearances(points, &t[..n], &mut d[..n], &mut voxel[..n]);
                for lane in 0..n {
                    let i = self.under_way[first + lane];
                    let (column, row) = (i % self.across, i / self.across);
                    let pixel = row * CONE_SIDE * tile.width + column * CONE_SIDE;
                    let hit = &mut out[pixel as usize];
                    hit.steps += 1;
                    let begin = &mut self.begin[i as usize];
                    let t = *begin;
                    let voxel = voxel[lane];
                    // What enters through a clipped side is not free, whatever is behind it.
                    let inside = d[lane] < 0.0 && starts_outside;
                    let length = d[lane].abs() * frame.inv_lipschitz;
                    let free = (length - beside[lane]).max(beside[lane]);
                    let free = if inside { 0.0 } else { free };
                    let next = (t + free) / (1.0 + slope);
                    let gain = next - t;
                    if gain > 0.0 {
                        *begin = next;
                    }
                    if *begin > self.end[i as usize] {
                        *begin = f32::INFINITY;
                    } else if gain > (0.5 * voxel).max(0.1 * slope * t) {
                        self.under_way[kept] = i;
                        kept += 1;
                    }
                }
            }
            self.under_way.truncate(kept);
        }
    }

    fn start(&mut self, frame: &FrameUniform, tile: Tile, starts: &RaySetup) {
        self.across = tile.width.div_ceil(CONE_SIDE);
        let down = tile.rows.div_ceil(CONE_SIDE);
        let count = (self.across * down) as usize;
        self.begin.clear();
        self.begin.resize(count, f32::INFINITY);
        self.end.clear();
        self.end.resize(count, f32::NEG_INFINITY);
        for (i, (&near, &far)) in starts.near.iter().zip(&starts.far).enumerate() {
            let (column, row) = (i as u32 % tile.width, i as u32 / tile.width);
            let block = (row / CONE_SIDE * self.across + column / CONE_SIDE) as usize;
            if near <= far {
                self.begin[block] = self.begin[block].min(near);
                self.end[block] = self.end[block].max(far);
            }
        }
        self.under_way.clear();
        for lanes in &mut self.direction {
            lanes.resize(count, 0.0);
        }
        for block in 0..count as u32 {
            let (column, row) = (block % self.across, block / self.across);
            let x = (tile.first_x + column * CONE_SIDE) as f32 + 0.5 * CONE_SIDE as f32;
            let y = (tile.first_row + row * CONE_SIDE) as f32 + 0.5 * CONE_SIDE as f32;
            let u = x / frame.width as f32 * 2.0 - 1.0;
            let v = 1.0 - y / frame.height as f32 * 2.0;
            let axis = |k: usize| frame.forward[k] + frame.right[k] * u + frame.up[k] * v;
            let direction = Vec3::new(axis(0), axis(1), axis(2)).normalize();
            for (k, lanes) in self.direction.iter_mut().enumerate() {
                lanes[block as usize] = direction[k];
            }
            if self.begin[block as usize] != f32::INFINITY {
                self.under_way.push(block);
            }
        }
    }
}
