//! Primary rays; `trace.wgsl` is the twin.

use crate::camera::primary_ray;
use argil_abi::{self as abi, Frame, Hit};
use argil_field::{Evaluator, LANES};
use argil_math::{Aabb, Ray};
use glam::Vec3;

/// Pixels along a tile's side. A tile's rays march together.
pub const TILE: u32 = 64;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Left edge.
    pub x: u32,
    /// Upper edge.
    pub y: u32,
    /// Width, at most [`TILE`].
    pub width: u32,
    /// Height, at most [`TILE`].
    pub height: u32,
}

impl Tile {
    /// Number of pixels.
    pub fn area(&self) -> usize {
        (self.width * self.height) as usize
    }

    /// The picture's coordinates of the tile's pixel `i`, row by row.
    #[inline]
    pub(crate) fn pixel(&self, i: usize) -> (u32, u32) {
        (self.x + i as u32 % self.width, self.y + i as u32 / self.width)
    }
}

/// The tiles of a picture, row by row.
pub fn tiles(width: u32, height: u32) -> impl Iterator<Item = Tile> {
    (0..height.div_ceil(TILE)).flat_map(move |row| {
        (0..width.div_ceil(TILE)).map(move |column| {
            let (x, y) = (column * TILE, row * TILE);
            Tile { x, y, width: TILE.min(width - x), height: TILE.min(height - y) }
        })
    })
}

/// Rays under way, one field an array.
#[derive(Default)]
pub(crate) struct Wave {
    pub pixel: Vec<u32>,
    pub direction: [Vec<f32>; 3],
    pub t: Vec<f32>,
    pub end: Vec<f32>,
    /// 1 outside, −1 inside, 0 before the first step.
    pub side: Vec<f32>,
    pub steps: Vec<u32>,
}

impl Wave {
    pub fn clear(&mut self) {
        self.truncate(0);
    }

    pub fn truncate(&mut self, n: usize) {
        self.pixel.truncate(n);
        self.direction.iter_mut().for_each(|d| d.truncate(n));
        self.t.truncate(n);
        self.end.truncate(n);
        self.side.truncate(n);
        self.steps.truncate(n);
    }

    pub fn push(&mut self, pixel: u32, direction: Vec3, (t, end): (f32, f32)) {
        self.pixel.push(pixel);
        for k in 0..3 {
            self.direction[k].push(direction[k]);
        }
        self.t.push(t);
        self.end.push(end);
        self.side.push(0.0);
        self.steps.push(0);
    }

    /// Close a gap: the ray at `from` goes to `to`.
    #[inline]
    pub fn keep(&mut self, from: usize, to: usize) {
        self.pixel[to] = self.pixel[from];
        for k in 0..3 {
            self.direction[k][to] = self.direction[k][from];
        }
        self.t[to] = self.t[from];
        self.end[to] = self.end[from];
        self.side[to] = self.side[from];
        self.steps[to] = self.steps[from];
    }

    pub fn len(&self) -> usize {
        self.pixel.len()
    }
}

/// Points gathered to be evaluated, with whose they are.
#[derive(Default)]
pub(crate) struct Points {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub z: Vec<f32>,
    pub d: Vec<f32>,
}

impl Points {
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    #[inline]
    pub fn push(&mut self, p: Vec3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }

    /// Fill `d`.
    pub fn measure(&mut self, evaluator: &mut Evaluator<'_>) {
        self.d.resize(self.x.len(), 0.0);
        for first in (0..self.x.len()).step_by(LANES) {
            let range = first..(first + LANES).min(self.x.len());
            let out = &mut self.d[range.clone()];
            evaluator.distances(&self.x[range.clone()], &self.y[range.clone()], &self.z[range], out);
        }
    }
}

/// A thread's buffers, kept from tile to tile.
#[derive(Default)]
pub struct TileScratch {
    pub(crate) wave: Wave,
    pub(crate) points: Points,
    pub(crate) hits: Vec<u32>,
    pub(crate) shading: crate::shade::Scratch,
}

/// Six points around one, two along each axis.
const DIFFERENCES: usize = 6;

/// What the primary ray of each pixel of a tile hits, row by row, into `out`.
///
/// # Panics
/// If `out` is shorter than the tile's area.
pub fn trace_tile(frame: &Frame, tile: Tile, evaluator: &mut Evaluator<'_>, scratch: &mut TileScratch, out: &mut [Hit]) {
    let TileScratch { wave, points, hits, .. } = scratch;
    let [ex, ey, ez, step_scale] = frame.eye_step;
    let eye = Vec3::new(ex, ey, ez);
    let bounds = bounds_of(frame);
    let epsilon = frame.box_min_epsilon[3];

    // Start the rays that meet the box.
    wave.clear();
    hits.clear();
    for (i, hit) in out.iter_mut().enumerate().take(tile.area()) {
        let (x, y) = tile.pixel(i);
        let ray = primary_ray(frame, x, y);
        *hit = Hit::default();
        if let Some(span) = ray.span(bounds) {
            wave.push(i as u32, ray.direction, span);
        }
    }

    // March until every ray has hit, left the box or spent its steps.
    while wave.len() > 0 {
        let mut kept = 0;
        let count = wave.len();
        for first in (0..count).step_by(LANES) {
            let n = LANES.min(count - first);
            let mut p = [[0.0f32; LANES]; 3];
            let mut d = [0.0f32; LANES];
            for (k, p) in p.iter_mut().enumerate() {
                let (t, direction) = (&wave.t[first..first + n], &wave.direction[k][first..first + n]);
                for (p, (t, direction)) in p.iter_mut().zip(t.iter().zip(direction)) {
                    *p = eye[k] + direction * t;
                }
            }
            evaluator.distances(&p[0][..n], &p[1][..n], &p[2][..n], &mut d[..n]);
            for (lane, &d) in d[..n].iter().enumerate() {
                let i = first + lane;
                wave.steps[i] += 1;
                if wave.side[i] == 0.0 {
                    wave.side[i] = if d < 0.0 { -1.0 } else { 1.0 };
                }
                let gap = d * wave.side[i];
                let spent = wave.steps[i] >= frame.max_steps;
                // A ray that grazes the surface may run out of steps within a pixel of it.
                let reached = gap < epsilon || (spent && gap < frame.pixel * wave.t[i]);
                wave.t[i] += gap * step_scale;
                let hit = &mut out[wave.pixel[i] as usize];
                hit.steps = wave.steps[i];
                if reached {
                    hit.kind = if wave.side[i] < 0.0 { abi::HIT_INSIDE } else { abi::HIT_OUTSIDE };
                    hit.normal_t[3] = wave.t[i];
                    hits.push(wave.pixel[i]);
                } else if !spent && wave.t[i] <= wave.end[i] {
                    wave.keep(i, kept);
                    kept += 1;
                }
            }
        }
        wave.truncate(kept);
    }

    // Normals by central differences.
    let bias = frame.box_max_bias[3];
    points.clear();
    for &pixel in hits.iter() {
        let (x, y) = tile.pixel(pixel as usize);
        let p = primary_ray(frame, x, y).at(out[pixel as usize].normal_t[3]);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            points.push(p + axis * bias);
            points.push(p - axis * bias);
        }
    }
    points.measure(evaluator);
    for (&pixel, d) in hits.iter().zip(points.d.chunks_exact(DIFFERENCES)) {
        let hit = &mut out[pixel as usize];
        let side = if hit.kind == abi::HIT_INSIDE { -1.0 } else { 1.0 };
        let (nx, ny, nz) = ((d[0] - d[1]) * side, (d[2] - d[3]) * side, (d[4] - d[5]) * side);
        let length = (nx * nx + ny * ny + nz * nz).sqrt();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        hit.normal_t = [nx * scale, ny * scale, nz * scale, hit.normal_t[3]];
    }

    // The ground, where it is nearer.
    if frame.ground_jitter[1] > 0.0 {
        for (i, hit) in out.iter_mut().enumerate().take(tile.area()) {
            let (x, y) = tile.pixel(i);
            if let Some(t) = ground(frame, primary_ray(frame, x, y))
                && (hit.kind == abi::HIT_NONE || t < hit.normal_t[3])
            {
                hit.kind = abi::HIT_GROUND;
                hit.normal_t = [0.0, 1.0, 0.0, t];
            }
        }
    }
}

pub(crate) fn bounds_of(frame: &Frame) -> Aabb {
    let [ax, ay, az, _] = frame.box_min_epsilon;
    let [bx, by, bz, _] = frame.box_max_bias;
    Aabb::new(Vec3::new(ax, ay, az), Vec3::new(bx, by, bz))
}

/// Where a ray from above meets the ground.
fn ground(frame: &Frame, ray: Ray) -> Option<f32> {
    if ray.direction.y > -1e-6 {
        return None;
    }
    let t = (frame.ground_jitter[0] - ray.origin.y) / ray.direction.y;
    (t > 0.0 && t < frame.far).then_some(t)
}
