//! An image that is kept, and of which only what an edit can have changed is drawn again.
//!
//! *Theory.* A pixel depends on distances in four places: along its ray up to the surface, around that, above it as far
//! as occlusion reaches, and along the way to the sun, in a cone as wide as the penumbra. Distances elsewhere can
//! change without a trace in the image. For a square of pixels, boxes and cones contain these places.

use crate::camera::{primary_ray, slope_of, through};
use crate::image::RenderOutput;
use crate::light::{sun, tap_height_of};
use crate::probe::FieldProbe;
use crate::render::{LIT_TOGETHER, SCRATCH, draw_tile};
use crate::source::RenderSource;
use crate::tile::Tile;
use crate::view_light::has_more;
use argil_abi::{self as abi, FrameUniform, Hit};
use argil_field::Program;
use argil_math::{Aabb, Ray};
use argil_volume::VoxelGrid;
use glam::Vec3;
use rayon::prelude::*;

/// Pixels along the side of a square, and squares that are drawn together.
const SQUARE: u32 = 16;
const RUN: usize = 8;

/// An image that follows edits: see [`LiveImage::draw`].
#[derive(Debug, Default)]
pub struct LiveImage {
    size: [u32; 2],
    /// Pixels as 8-bit sRGB, three bytes each, row by row from the top.
    rgb: Vec<u8>,
    /// The frames that were drawn, without the box.
    view: Vec<FrameUniform>,
    squares: Vec<Reach>,
    /// What else the image depends on.
    state: LiveState,
}

/// What an image depends on besides its frames: whether there are levels for light, and whether edits are pending; and the
/// grid, because light reads other levels once that grew.
type LiveState = ([bool; 2], Option<VoxelGrid>);

/// Where a square's pixels depend on distances.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// The length of the longest ray, infinite if one shows the sky.
    farthest: f32,
    /// The surfaces, and the highest points above them that occlusion asks for.
    surfaces: Aabb,
    taps: Aabb,
    is_sunlit: bool,
}

impl LiveImage {
    /// Returns the width and the height in pixels. 0 before the first image.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the pixels as 8-bit sRGB, three bytes each, row by row from the top.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    #[doc(hidden)]
    /// Notes what else the image depends on, and returns whether that is what it was. If not, draw everything.
    pub fn follows(&mut self, state: LiveState) -> bool {
        std::mem::replace(&mut self.state, state) == state
    }

    /// Takes an image that was drawn whole, and returns the number of its pixels. The next one is drawn whole too.
    pub fn replace(&mut self, image: RenderOutput) -> usize {
        let pixels = image.rgb.len() / 3;
        *self = Self {
            size: image.size,
            rgb: image.rgb,
            ..Self::default()
        };
        pixels
    }

    /// Draws as [`render`](fn@crate::render) does, on rayon's current threads. If the last image had the same view,
    /// only those squares of 16×16 pixels are drawn that something in the dirty box can affect, and the others stay.
    /// Returns the number of pixels drawn.
    pub fn draw(
        &mut self,
        program: &Program,
        through: &dyn RenderSource,
        frames: &[FrameUniform],
        dirty: Aabb,
    ) -> usize {
        let Some(first) = frames.first() else {
            *self = Self::default();
            return 0;
        };
        let across = first.width.div_ceil(SQUARE);
        let count = across * first.height.div_ceil(SQUARE);
        // Where rays enter the box of the solid, nothing can be seen yet.
        let boxless = |frame: &FrameUniform| FrameUniform {
            box_min: [0.0; 3],
            box_max: [0.0; 3],
            ..*frame
        };
        let view: Vec<_> = frames.iter().map(boxless).collect();
        // Lamps' shadows and light in fog come from anywhere.
        let is_same = self.view == view && frames.len() <= LIT_TOGETHER && !has_more(first);
        if !is_same {
            self.size = [first.width, first.height];
            self.rgb.clear();
            self.rgb
                .resize(3 * first.width as usize * first.height as usize, 0);
            self.view = view;
            self.squares.clear();
            self.squares.resize(count as usize, Reach::NOTHING);
        }
        let affected = |square: &u32| {
            !is_same || self.squares[*square as usize].is_affected(first, *square, dirty)
        };
        let squares: Vec<u32> = (0..count).filter(affected).collect();
        let runs: Vec<&[u32]> = squares
            .chunk_by(|a, b| a + 1 == *b && b % across != 0)
            .flat_map(|run| run.chunks(RUN))
            .collect();
        let rays = through.tracer(first);
        let rays = rays.as_deref();
        let drawn: Vec<_> = runs
            .par_iter()
            .map_init(
                || FieldProbe::new(program, None),
                |probe, run| {
                    let tile = tile_of(first, run);
                    SCRATCH.with_borrow_mut(|(scratch, picture)| {
                        draw_tile(rays, frames, tile, probe, scratch, picture, &mut []);
                        let reaches = reaches(frames, tile, &picture.hits);
                        picture.counts.clear();
                        (tile, picture.rgb.clone(), reaches)
                    })
                },
            )
            .collect();
        let mut pixels = 0;
        for (run, (tile, rgb, reaches)) in runs.iter().zip(drawn) {
            for (square, reach) in run.iter().zip(reaches) {
                self.squares[*square as usize] = reach;
            }
            for (row, from) in (tile.first_row..).zip(rgb.chunks(3 * tile.width as usize)) {
                let at = 3 * (row as usize * first.width as usize + tile.first_x as usize);
                self.rgb[at..at + from.len()].copy_from_slice(from);
            }
            pixels += tile.area();
        }
        pixels
    }
}

/// Returns the pixels of squares that follow one another in a row.
fn tile_of(frame: &FrameUniform, run: &[u32]) -> Tile {
    let across = frame.width.div_ceil(SQUARE);
    let (first_x, first_row) = (run[0] % across * SQUARE, run[0] / across * SQUARE);
    Tile {
        first_x,
        first_row,
        width: (SQUARE * run.len() as u32).min(frame.width - first_x),
        rows: SQUARE.min(frame.height - first_row),
    }
}

/// Returns the reach of each square of a tile.
fn reaches(frames: &[FrameUniform], tile: Tile, hits: &[Vec<Hit>]) -> Vec<Reach> {
    let mut all = vec![Reach::NOTHING; tile.width.div_ceil(SQUARE) as usize];
    for (frame, hits) in frames.iter().zip(hits) {
        for (i, hit) in hits.iter().enumerate().take(tile.area()) {
            let reach = &mut all[i % tile.width as usize / SQUARE as usize];
            if hit.kind == abi::HIT_NONE {
                reach.farthest = f32::INFINITY;
                continue;
            }
            let (x, y) = tile.pixel(i);
            let [nx, ny, nz, length] = hit.normal_t;
            let p = primary_ray(frame, x, y).at(length);
            let n = Vec3::new(nx, ny, nz);
            let tap = p + n * tap_height_of(frame, length);
            reach.farthest = reach.farthest.max(length);
            reach.surfaces = reach.surfaces.union(Aabb::new(p, p));
            reach.taps = reach.taps.union(Aabb::new(tap, tap));
            reach.is_sunlit |= n.dot(Vec3::from(frame.sun)) > 0.0;
        }
    }
    all
}

impl Reach {
    const NOTHING: Self = Self {
        farthest: 0.0,
        surfaces: Aabb::EMPTY,
        taps: Aabb::EMPTY,
        is_sunlit: false,
    };

    /// Whether something in a box can affect a square of pixels.
    fn is_affected(&self, frame: &FrameUniform, square: u32, dirty: Aabb) -> bool {
        if dirty.is_empty() {
            return false;
        }
        if !dirty.is_finite() {
            return true;
        }
        let eye = Vec3::from(frame.eye);
        let across = frame.width.div_ceil(SQUARE);
        let middle = |c: u32| (c as f32 + 0.5) * SQUARE as f32;
        let direction = through(frame, middle(square % across), middle(square / across));
        let meets = |origin: Vec3, direction: Vec3, radius: f32, slope: f32, farthest: f32| {
            let far = farthest_point(dirty, origin).min(farthest);
            let wide = dirty.grown(radius + slope * far);
            let span = Ray { origin, direction }.span(wide);
            span.is_some_and(|(near, _)| near <= farthest)
        };
        let bias = 2.0 * frame.normal_bias;
        let slope = slope_of(frame, SQUARE);
        if meets(eye, direction, bias, slope, self.farthest + bias) {
            return true;
        }
        if frame.mode != abi::MODE_SHADED || self.surfaces.is_empty() {
            return false;
        }
        let tap = tap_height_of(frame, f32::INFINITY);
        // Pixels share what is measured around their highest points.
        if !self.taps.grown(2.5 * tap).intersection(dirty).is_empty() {
            return true;
        }
        let (center, radius) = (self.surfaces.center(), self.surfaces.half_diagonal());
        // Shadows begin a little above the surface.
        let radius = radius + 4.0 * frame.light_offset;
        let sun = Vec3::from(frame.sun);
        self.is_sunlit && meets(center, sun, radius, 1.0 / sun::SHARPNESS, f32::INFINITY)
    }
}

/// Returns the distance to the farthest point of a box.
fn farthest_point(b: Aabb, from: Vec3) -> f32 {
    let away = (b.min - from).abs().max((b.max - from).abs());
    away.length()
}
