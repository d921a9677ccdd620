//! What the samples of a tile show, as a structure of arrays: surfaces to be lit, and sky.

use crate::tile::Tile;
use argil_abi::{self as abi, FrameUniform, Hit};
use glam::Vec3;
use multiversion::multiversion;
use std::ops::Range;

/// Pixels along the side of a group, whose surfaces share what their light has in common.
const GROUP_SIDE: u32 = 4;
/// Groups along the side of a block, whose surfaces share a cone toward the sun.
const BLOCK_GROUPS: u32 = 2;
const BLOCK_SIDE: u32 = GROUP_SIDE * BLOCK_GROUPS;

/// The samples of a tile, block by block and group by group.
#[derive(Debug, Default)]
pub struct Surfaces {
    /// The pixel in the tile.
    pub pixel: Vec<u32>,
    /// What was hit: `HIT_OUTSIDE`, `HIT_INSIDE` or `HIT_GROUND`.
    pub kind: Vec<u32>,
    /// The position in the image, in pixels.
    image: [Vec<f32>; 2],
    /// The length of the ray.
    pub length: Vec<f32>,
    /// The direction of the ray.
    pub direction: [Vec<f32>; 3],
    /// The point that was hit, in the scene's space, and its normal.
    pub position: [Vec<f32>; 3],
    pub normal: [Vec<f32>; 3],
    /// Where the surfaces of groups begin, and at last where they end. A block has four groups.
    groups: Vec<u32>,
    /// The number of samples. Arrays may be longer.
    count: usize,
}

impl Surfaces {
    /// Gathers the samples of a tile, one frame each: surfaces into `self`, and the others into `sky`.
    ///
    /// # Panics
    /// If there are fewer hits than frames, or they are shorter than the tile's area.
    pub(crate) fn gather(
        &mut self,
        frames: &[FrameUniform],
        tile: Tile,
        hits: &[Vec<Hit>],
        sky: &mut Surfaces,
    ) {
        let room = frames.len() * tile.area();
        self.begin(room);
        sky.begin(room);
        for row in (0..tile.rows).step_by(BLOCK_SIDE as usize) {
            for column in (0..tile.width).step_by(BLOCK_SIDE as usize) {
                for group in 0..BLOCK_GROUPS * BLOCK_GROUPS {
                    let x = column + group % BLOCK_GROUPS * GROUP_SIDE;
                    let y = row + group / BLOCK_GROUPS * GROUP_SIDE;
                    self.groups.push(self.count as u32);
                    for (frame, hits) in frames.iter().zip(hits) {
                        for y in y..(y + GROUP_SIDE).min(tile.rows) {
                            for x in x..(x + GROUP_SIDE).min(tile.width) {
                                let pixel = y * tile.width + x;
                                let hit = &hits[pixel as usize];
                                let is_sky = hit.kind == abi::HIT_NONE;
                                let to = if is_sky { &mut *sky } else { &mut *self };
                                let x = (tile.first_x + x) as f32 + frame.jitter_x;
                                let y = (tile.first_row + y) as f32 + frame.jitter_y;
                                to.push(pixel, hit, [x, y]);
                            }
                        }
                    }
                }
            }
        }
        self.groups.push(self.count as u32);
        if let Some(frame) = frames.first() {
            self.place(frame);
            sky.place(frame);
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Iterates over the surfaces of each group.
    pub(crate) fn groups(&self) -> impl Iterator<Item = Range<usize>> {
        let bounds = self.groups.windows(2);
        bounds.map(|ends| ends[0] as usize..ends[1] as usize)
    }

    /// Iterates over the surfaces of each block.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = Range<usize>> {
        let count = (BLOCK_GROUPS * BLOCK_GROUPS) as usize;
        let bounds = self.groups.windows(count + 1).step_by(count);
        bounds.map(move |ends| ends[0] as usize..ends[count] as usize)
    }

    #[inline]
    pub(crate) fn point(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.position;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Returns the direction of the primary ray.
    #[inline]
    pub(crate) fn ray(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.direction;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Returns the position in the image, in pixels.
    #[inline]
    pub(crate) fn image_place(&self, i: usize) -> [f32; 2] {
        [self.image[0][i], self.image[1][i]]
    }

    /// Returns the points and the normals of some surfaces, axis by axis.
    #[inline]
    pub(crate) fn lanes(&self, range: Range<usize>) -> [&[f32]; 6] {
        let [[px, py, pz], [nx, ny, nz]] = [&self.position, &self.normal];
        [px, py, pz, nx, ny, nz].map(|lanes| &lanes[range.clone()])
    }

    #[inline]
    pub(crate) fn normal(&self, i: usize) -> Vec3 {
        let [x, y, z] = &self.normal;
        Vec3::new(x[i], y[i], z[i])
    }

    /// Returns the normal on the solid's outer side.
    #[inline]
    pub(crate) fn outward(&self, i: usize) -> Vec3 {
        let n = self.normal(i);
        if self.kind[i] == abi::HIT_INSIDE {
            -n
        } else {
            n
        }
    }

    /// Makes room for samples.
    fn begin(&mut self, room: usize) {
        self.groups.clear();
        self.count = 0;
        for lanes in [&mut self.pixel, &mut self.kind] {
            lanes.resize(room, 0);
        }
        let lanes = self.image.iter_mut().chain(&mut self.normal);
        lanes
            .chain([&mut self.length])
            .for_each(|lanes| lanes.resize(room, 0.0));
    }

    #[inline]
    fn push(&mut self, pixel: u32, hit: &Hit, [x, y]: [f32; 2]) {
        let i = self.count;
        self.count += 1;
        self.pixel[i] = pixel;
        self.kind[i] = hit.kind;
        let [nx, ny, nz, length] = hit.normal_t;
        self.length[i] = length;
        (self.normal[0][i], self.normal[1][i], self.normal[2][i]) = (nx, ny, nz);
        (self.image[0][i], self.image[1][i]) = (x, y);
    }

    /// Computes directions and positions.
    fn place(&mut self, frame: &FrameUniform) {
        let n = self.len();
        for lanes in self.direction.iter_mut().chain(&mut self.position) {
            lanes.resize(n, 0.0);
        }
        let [u, v] = self.image.each_ref().map(|lanes| &lanes[..n]);
        directions(frame, [u, v], &mut self.direction);
        for axis in 0..3 {
            let eye = frame.eye[axis];
            let along = self.direction[axis].iter().zip(&self.length);
            for (p, (d, t)) in self.position[axis].iter_mut().zip(along) {
                *p = eye + d * t;
            }
        }
    }
}

/// Computes `primary_ray` for positions in the image, with the same operations in the same order.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn directions(frame: &FrameUniform, image: [&[f32]; 2], out: &mut [Vec<f32>; 3]) {
    let (width, height) = (frame.width as f32, frame.height as f32);
    let (forward, right, up) = (frame.forward, frame.right, frame.up);
    let [xs, ys, zs] = out;
    let out = xs.iter_mut().zip(ys.iter_mut()).zip(zs.iter_mut());
    for (((x, y), z), (u, v)) in out.zip(image[0].iter().zip(image[1])) {
        let u = u / width * 2.0 - 1.0;
        let v = 1.0 - v / height * 2.0;
        let axis = |k: usize| forward[k] + right[k] * u + up[k] * v;
        let (dx, dy, dz) = (axis(0), axis(1), axis(2));
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        (*x, *y, *z) = (dx / length, dy / length, dz / length);
    }
}
