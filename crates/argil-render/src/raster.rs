//! Draws triangles by depth.
//!
//! *Theory.* The ray of a pixel is on one side of the plane through the eye and an edge. It hits the triangle if it
//! is on the same side of all three (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates",
//! 1997). Neighbors have an edge's plane with opposite signs, bit for bit, so no pixel between them is missed.
//! Nothing is clipped: what is behind the eye has no position on the ray.
//!
//! *Practice.* Triangles are sorted into the tiles that their boxes touch, and a tile's pixels keep the nearest.
//! `raster_resolve.wgsl` leaves that to the device, and gives the same normals and lengths within rounding.

use crate::camera::primary_ray;
use crate::probe::FieldProbe;
use crate::source::{RayTracer, RenderSource};
use crate::tile::{TILE_HEIGHT, TILE_WIDTH, Tile};
use crate::tile_buffers::TileScratch;
use crate::trace::intersect_ground;
use argil_abi::{self as abi, FrameUniform, Hit};
use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;

/// Triangles to draw, counterclockwise as seen from outside.
#[derive(Clone, Copy, Debug)]
pub struct Triangles<'a> {
    /// Positions of vertices.
    pub positions: &'a [Vec3],
    /// A unit normal per vertex. If empty, triangles use their own.
    pub normals: &'a [Vec3],
    /// The vertices of each triangle.
    pub triangles: &'a [[u32; 3]],
}

impl RenderSource for Triangles<'_> {
    fn tracer<'a>(&'a self, first: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        Some(Box::new(Raster::new(*self, first)))
    }
}

impl RayTracer for Raster<'_> {
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        _: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        self.draw(frame, tile, scratch.source.of(), out);
    }
}

/// The direction of each pixel's ray.
#[derive(Default)]
struct Directions(Vec<Vec3>);

/// The pixels that a triangle can cover: from the first column and row to the last.
type Reach = [u16; 4];

/// Triangles sorted by tiles.
struct Raster<'a> {
    mesh: Triangles<'a>,
    reaches: Vec<Reach>,
    /// Tiles per row.
    across: usize,
    /// The index of each tile's first triangle, and the end.
    begins: Vec<u32>,
    order: Vec<u32>,
}

impl<'a> Raster<'a> {
    /// Prepares frames that differ only by the position within a pixel.
    fn new(mesh: Triangles<'a>, frame: &FrameUniform) -> Self {
        let across = frame.width.div_ceil(TILE_WIDTH) as usize;
        let down = frame.height.div_ceil(TILE_HEIGHT) as usize;
        let places: Vec<Option<Vec2>> = mesh
            .positions
            .par_iter()
            .with_min_len(4096)
            .map(|&p| place(frame, p))
            .collect();
        let reaches: Vec<Reach> = mesh
            .triangles
            .par_iter()
            .with_min_len(4096)
            .map(|triangle| reach(frame, triangle.map(|i| places[i as usize])))
            .collect();
        let tiles_of = |&[x0, y0, x1, y1]: &Reach| {
            let (x0, x1) = (u32::from(x0) / TILE_WIDTH, u32::from(x1) / TILE_WIDTH);
            let (y0, y1) = (u32::from(y0) / TILE_HEIGHT, u32::from(y1) / TILE_HEIGHT);
            (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| y as usize * across + x as usize))
        };
        let is_seen = |reach: &Reach| reach[0] <= reach[2] && reach[1] <= reach[3];
        let mut begins = vec![0u32; across * down + 1];
        for reach in reaches.iter().filter(|r| is_seen(r)) {
            for tile in tiles_of(reach) {
                begins[tile + 1] += 1;
            }
        }
        for tile in 0..across * down {
            begins[tile + 1] += begins[tile];
        }
        let mut next = begins.clone();
        let mut order = vec![0u32; begins.last().map_or(0, |&n| n as usize)];
        for (i, reach) in (0..).zip(&reaches).filter(|(_, r)| is_seen(r)) {
            for tile in tiles_of(reach) {
                order[next[tile] as usize] = i;
                next[tile] += 1;
            }
        }
        Self {
            mesh,
            reaches,
            across,
            begins,
            order,
        }
    }

    /// Draws what is nearest in each pixel of a tile into `out`, row by row. A hit's steps are the triangles that
    /// cover it.
    fn draw(&self, frame: &FrameUniform, tile: Tile, rays: &mut Directions, out: &mut [Hit]) {
        let rays = &mut rays.0;
        rays.clear();
        rays.extend((0..tile.area()).map(|i| {
            let (x, y) = tile.pixel(i);
            primary_ray(frame, x, y).direction
        }));
        out[..tile.area()].fill(Hit::default());
        let [ex, ey, ez] = frame.eye;
        let eye = Vec3::new(ex, ey, ez);
        let tile_index = (tile.first_row / TILE_HEIGHT) as usize * self.across
            + (tile.first_x / TILE_WIDTH) as usize;
        let range = self.begins[tile_index] as usize..self.begins[tile_index + 1] as usize;
        let (right, last) = (
            tile.first_x + tile.width - 1,
            tile.first_row + tile.rows - 1,
        );
        for &triangle in &self.order[range] {
            let corners = self.mesh.triangles[triangle as usize];
            let [a, b, c] = corners.map(|i| self.mesh.positions[i as usize] - eye);
            let edges = [b.cross(c), c.cross(a), a.cross(b)];
            // Of the plane. The edges' own planes are too nearly parallel to give a length.
            let normal = (b - a).cross(c - a);
            let height = a.dot(normal);
            let [x0, y0, x1, y1] = self.reaches[triangle as usize].map(u32::from);
            for y in y0.max(tile.first_row)..=y1.min(last) {
                let row = (y - tile.first_row) * tile.width;
                for x in x0.max(tile.first_x)..=x1.min(right) {
                    let i = (row + x - tile.first_x) as usize;
                    let direction = rays[i];
                    let [u, v, w] = edges.map(|edge| direction.dot(edge));
                    let is_front = u <= 0.0 && v <= 0.0 && w <= 0.0;
                    let is_back = u >= 0.0 && v >= 0.0 && w >= 0.0;
                    let sum = u + v + w;
                    if !(is_front || is_back) || sum == 0.0 {
                        continue;
                    }
                    let t = height / direction.dot(normal);
                    let hit = &mut out[i];
                    hit.steps += 1;
                    if t.is_nan() || t <= 0.0 || (hit.kind != abi::HIT_NONE && t >= hit.normal_t[3])
                    {
                        continue;
                    }
                    let shares = [u / sum, v / sum, w / sum];
                    let n = self.normal(corners, shares, [a, b, c]);
                    let n = if is_front { n } else { -n };
                    hit.kind = if is_front {
                        abi::HIT_OUTSIDE
                    } else {
                        abi::HIT_INSIDE
                    };
                    hit.normal_t = [n.x, n.y, n.z, t];
                }
            }
        }
        intersect_ground(frame, tile, out);
    }

    fn normal(&self, corners: [u32; 3], shares: [f32; 3], [a, b, c]: [Vec3; 3]) -> Vec3 {
        let flat = || (b - a).cross(c - a).normalize_or(Vec3::Y);
        if self.mesh.normals.is_empty() {
            return flat();
        }
        let normals = corners.map(|i| self.mesh.normals[i as usize]);
        let mixed = normals[0] * shares[0] + normals[1] * shares[1] + normals[2] * shares[2];
        mixed.try_normalize().unwrap_or_else(flat)
    }
}

/// Returns a point's position in the image, in pixels, or `None` beside or behind the eye.
fn place(frame: &FrameUniform, p: Vec3) -> Option<Vec2> {
    let [ex, ey, ez] = frame.eye;
    let way = p - Vec3::new(ex, ey, ez);
    let [forward, right, up] = [frame.forward, frame.right, frame.up].map(Vec3::from);
    let depth = way.dot(forward) / forward.length_squared();
    if depth.is_nan() || depth <= 1e-6 * way.length() {
        return None;
    }
    let u = way.dot(right) / (right.length_squared() * depth);
    let v = way.dot(up) / (up.length_squared() * depth);
    Some(vec2(
        (u + 1.0) * 0.5 * frame.width as f32,
        (1.0 - v) * 0.5 * frame.height as f32,
    ))
}

/// Returns the pixels whose rays can meet a triangle, wherever in the pixel they begin.
fn reach(frame: &FrameUniform, corners: [Option<Vec2>; 3]) -> Reach {
    let (width, height) = (frame.width as f32, frame.height as f32);
    let all = [0, 0, frame.width as u16 - 1, frame.height as u16 - 1];
    let [Some(a), Some(b), Some(c)] = corners else {
        // Partly behind the eye: anywhere.
        return if corners == [None; 3] {
            [1, 1, 0, 0]
        } else {
            all
        };
    };
    let low = a.min(b).min(c).floor() - 1.0;
    let high = a.max(b).max(c).ceil() + 1.0;
    if low.x >= width || low.y >= height || high.x < 0.0 || high.y < 0.0 {
        return [1, 1, 0, 0];
    }
    let (low, high) = (
        low.max(Vec2::ZERO),
        high.min(vec2(width - 1.0, height - 1.0)),
    );
    [low.x as u16, low.y as u16, high.x as u16, high.y as u16]
}
