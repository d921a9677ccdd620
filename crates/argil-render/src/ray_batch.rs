//! Rays that march together, and points that are evaluated together.

use crate::camera::bounds_of;
use crate::source_scratch::SourceScratch;
use crate::tile::Tile;
use argil_abi::FrameUniform;
use glam::Vec3;
use multiversion::multiversion;

/// The rays of a tile, and where they enter and leave the box, row by row. A ray that misses the box enters after
/// it leaves.
#[derive(Debug, Default)]
pub(crate) struct RaySetup {
    pub direction: [Vec<f32>; 3],
    pub near: Vec<f32>,
    pub far: Vec<f32>,
}

impl RaySetup {
    pub(crate) fn fill(&mut self, frame: &FrameUniform, tile: Tile) {
        let [x, y, z] = &mut self.direction;
        for lanes in [x, y, z, &mut self.near, &mut self.far] {
            lanes.resize(tile.area(), 0.0);
        }
        for row in 0..tile.rows {
            start_row(self, frame, tile, row);
        }
    }
}

/// Computes `primary_ray` and `Ray::span` for all pixels of a row, with the same operations in the same order.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn start_row(starts: &mut RaySetup, frame: &FrameUniform, tile: Tile, row: u32) {
    let n = tile.width as usize;
    let range = row as usize * n..(row as usize + 1) * n;
    let bounds = bounds_of(frame);
    let y = tile.first_row + row;
    let v = 1.0 - (y as f32 + frame.jitter_y) / frame.height as f32 * 2.0;
    let (jitter, width) = (frame.jitter_x, frame.width as f32);
    let (forward, right, up, eye) = (frame.forward, frame.right, frame.up, frame.eye);
    let axis = |k: usize, u: f32| forward[k] + right[k] * u + up[k] * v;
    let tiny = |d: f32| if d.abs() < 1e-20 { 1e-20 } else { d };
    let low = |a: f32, b: f32| if b < a { b } else { a };
    let high = |a: f32, b: f32| if b > a { b } else { a };
    let slab = |d: f32, k: usize| {
        let inverse = 1.0 / tiny(d);
        let (a, c) = (
            (bounds.min[k] - eye[k]) * inverse,
            (bounds.max[k] - eye[k]) * inverse,
        );
        (low(a, c), high(a, c))
    };
    let [xs, ys, zs] = &mut starts.direction;
    let (xs, ys, zs) = (
        &mut xs[range.clone()],
        &mut ys[range.clone()],
        &mut zs[range.clone()],
    );
    let (near, far) = (&mut starts.near[range.clone()], &mut starts.far[range]);
    for i in 0..n {
        let u = ((tile.first_x + i as u32) as f32 + jitter) / width * 2.0 - 1.0;
        let (dx, dy, dz) = (axis(0, u), axis(1, u), axis(2, u));
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        let (dx, dy, dz) = (dx / length, dy / length, dz / length);
        let ((nx, fx), (ny, fy), (nz, fz)) = (slab(dx, 0), slab(dy, 1), slab(dz, 2));
        (xs[i], ys[i], zs[i]) = (dx, dy, dz);
        near[i] = high(high(nx, high(ny, nz)), 0.0);
        far[i] = low(fx, low(fy, fz));
    }
}

/// Active rays, as a structure of arrays. They march together, so all have taken the same number of steps.
#[derive(Debug, Default)]
pub(crate) struct RayBatch {
    pub pixel: Vec<u32>,
    pub direction: [Vec<f32>; 3],
    pub t: Vec<f32>,
    pub end: Vec<f32>,
    /// 1 outside, −1 inside, 0 before the first step.
    pub side: Vec<f32>,
    /// The level to read next.
    pub level: Vec<u32>,
    /// The page that the ray is in, where it marches through levels of detail.
    pub page: Vec<u32>,
    /// What the ray has looked up so far, where rays count for themselves.
    pub samples: Vec<u32>,
    pub cells: Vec<u32>,
    /// How far the ray went beyond what was known to be free.
    pub over: Vec<f32>,
    /// Its last distance, and how far it went with that. 0 if unknown.
    pub last_gap: Vec<f32>,
    pub last_way: Vec<f32>,
    /// Number of empty places, and scratch memory to close them.
    retired: usize,
    places: Vec<u32>,
}

/// The end of a ray that is no longer active.
pub(crate) const RETIRED: f32 = -1.0;

impl RayBatch {
    pub(crate) fn clear(&mut self) {
        self.truncate(0);
        self.retired = 0;
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.pixel.truncate(n);
        self.direction.iter_mut().for_each(|d| d.truncate(n));
        self.t.truncate(n);
        self.end.truncate(n);
        self.side.truncate(n);
        self.level.truncate(n);
        self.page.truncate(n);
        self.samples.truncate(n);
        self.cells.truncate(n);
        self.over.truncate(n);
        self.last_gap.truncate(n);
        self.last_way.truncate(n);
    }

    pub(crate) fn push(&mut self, pixel: u32, direction: Vec3, (t, end): (f32, f32)) {
        self.pixel.push(pixel);
        for k in 0..3 {
            self.direction[k].push(direction[k]);
        }
        self.t.push(t);
        self.end.push(end);
        self.side.push(0.0);
        self.level.push(0);
        self.page.push(0);
        self.samples.push(0);
        self.cells.push(0);
        self.over.push(0.0);
        self.last_gap.push(0.0);
        self.last_way.push(0.0);
    }

    /// Removes a ray. Its place stays until enough are empty.
    #[inline]
    pub(crate) fn retire(&mut self, i: usize) {
        self.end[i] = RETIRED;
        self.retired += 1;
    }

    /// Closes the gaps once a quarter of the places is empty, because moving rays costs more than marching a few in
    /// vain.
    pub(crate) fn compact(&mut self) {
        if 4 * self.retired >= self.len() {
            self.close();
        }
    }

    /// Closes all gaps.
    pub(crate) fn close(&mut self) {
        if self.retired == 0 {
            return;
        }
        self.places.clear();
        self.places
            .extend((0..self.len() as u32).filter(|&i| self.end[i as usize] != RETIRED));
        let kept = self.places.len();
        let close = |array: &mut Vec<f32>, places: &[u32]| {
            for (to, &from) in places.iter().enumerate() {
                array[to] = array[from as usize];
            }
        };
        let [x, y, z] = &mut self.direction;
        let lanes = [
            &mut self.t,
            &mut self.end,
            &mut self.side,
            &mut self.over,
            &mut self.last_gap,
            &mut self.last_way,
        ];
        for array in [x, y, z].into_iter().chain(lanes) {
            close(array, &self.places);
        }
        for (to, &from) in self.places.iter().enumerate() {
            self.pixel[to] = self.pixel[from as usize];
            self.level[to] = self.level[from as usize];
            self.page[to] = self.page[from as usize];
            self.samples[to] = self.samples[from as usize];
            self.cells[to] = self.cells[from as usize];
        }
        self.truncate(kept);
        self.retired = 0;
    }

    pub(crate) fn len(&self) -> usize {
        self.pixel.len()
    }
}

/// Points to evaluate, with the index of their owners.
#[derive(Debug, Default)]
pub struct Points {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub z: Vec<f32>,
    pub d: Vec<f32>,
    /// Buffers of what measures them.
    pub(crate) source: SourceScratch,
}

impl Points {
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    pub fn resize(&mut self, n: usize) {
        for lanes in [&mut self.x, &mut self.y, &mut self.z] {
            lanes.resize(n, 0.0);
        }
    }

    #[inline]
    pub fn push(&mut self, p: Vec3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }
}
