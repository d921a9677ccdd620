use crate::image::{RenderOutput, covered, show};
use crate::light::light_reach;
use crate::probe::FieldProbe;
use crate::ray_stats::RayCounts;
use crate::shade::shade_tile;
use crate::source::{RayTracer, RenderSource};
use crate::tile::{Tile, tile_rows, tiles};
use crate::tile_buffers::{TilePicture, TileScratch};
use argil_abi::{FrameUniform, Hit};
use argil_field::{NearField, Program};
use argil_math::Control;
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

thread_local! {
    /// Kept as long as the thread: a frame allocates nothing but its image.
    pub(crate) static SCRATCH: RefCell<(TileScratch, TilePicture)> = RefCell::default();
}

/// Renders on the CPU, on rayon's current threads. [`frame_uniforms`](crate::frame_uniforms) makes `frames`, one
/// per sample. `through` is what rays march through. Sparse bricks give their own light and materials, and other
/// sources use the field's. The image has no hits.
pub fn render(
    program: &Program,
    through: &dyn RenderSource,
    frames: &[FrameUniform],
) -> RenderOutput {
    draw(program, through, frames, false, &Control::default())
}

/// Renders as [`render`](fn@render) does, and also returns what the first sample of each pixel hit.
pub fn render_with_hits(
    program: &Program,
    through: &dyn RenderSource,
    frames: &[FrameUniform],
) -> RenderOutput {
    draw(program, through, frames, true, &Control::default())
}

/// Renders with or without hits, reports progress, and can be canceled. Returns `None` if it was.
pub fn render_with_control(
    program: &Program,
    through: &dyn RenderSource,
    frames: &[FrameUniform],
    keeps_hits: bool,
    control: &Control,
) -> Option<RenderOutput> {
    let picture = draw(program, through, frames, keeps_hits, control);
    (!control.is_cancelled()).then_some(picture)
}

fn draw(
    program: &Program,
    through: &dyn RenderSource,
    frames: &[FrameUniform],
    keeps_hits: bool,
    control: &Control,
) -> RenderOutput {
    let Some(first) = frames.first() else {
        return RenderOutput::empty();
    };
    let (width, height) = (first.width, first.height);
    let pixels = width as usize * height as usize;
    let mut rgb = vec![0; 3 * pixels];
    let mut hits = vec![Hit::default(); if keeps_hits { pixels } else { 0 }];
    let rays = through.tracer(first);
    let asks_near = rays
        .as_ref()
        .is_some_and(|rays| rays.needs_field(first.mode));
    let near = asks_near.then(|| near_field(program, first)).flatten();
    let counts = Mutex::new(RayCounts::default());
    let hit_pixels = AtomicUsize::new(0);
    let mut hit_rows = tile_rows(&mut hits, width, 1);
    let all: Vec<_> = tiles(width, height).collect();
    hit_rows.resize_with(all.len(), Vec::new);
    control.begin("picture", all.len() as u64);
    let rays = rays.as_deref();
    all.par_iter()
        .zip(tile_rows(&mut rgb, width, 3))
        .zip(hit_rows)
        .for_each_init(
            || FieldProbe::new(program, near.as_ref()),
            |probe, ((&tile, rgb_rows), mut hit_rows)| {
                if control.is_cancelled() {
                    return;
                }
                SCRATCH.with_borrow_mut(|(scratch, picture)| {
                    draw_tile(rays, frames, tile, probe, scratch, picture, &mut hit_rows);
                    let rows = picture.rgb.chunks(3 * tile.width as usize);
                    for (to, from) in rgb_rows.into_iter().zip(rows) {
                        to.copy_from_slice(from);
                    }
                    hit_pixels.fetch_add(covered(&picture.colors), Ordering::Relaxed);
                    if let Ok(mut counts) = counts.lock() {
                        counts.merge(&picture.counts);
                    }
                    picture.counts.clear();
                });
                control.advance(1);
            },
        );
    RenderOutput {
        size: [width, height],
        rgb,
        hits,
        statistics: is_counted(first).then(|| {
            let counts = counts.into_inner();
            counts.expect("no thread of it has panicked").statistics()
        }),
        hit_pixels: hit_pixels.into_inner(),
    }
}

/// Draws a tile into a thread's own picture, and the hits of the first samples into their rows, if there are any.
pub(crate) fn draw_tile(
    rays: Option<&dyn RayTracer>,
    frames: &[FrameUniform],
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    scratch: &mut TileScratch,
    picture: &mut TilePicture,
    hit_rows: &mut [&mut [Hit]],
) {
    picture.colors.clear();
    picture.colors.resize(tile.area(), [0.0; 4]);
    let air = rays.and_then(RayTracer::distance_source);
    for (i, frames) in frames.chunks(LIT_TOGETHER).enumerate() {
        picture.hits.resize_with(frames.len(), Vec::new);
        for (frame, hits) in frames.iter().zip(&mut picture.hits) {
            hits.resize(tile.area(), Hit::default());
            if let Some(rays) = rays {
                rays.trace(frame, tile, probe, scratch, hits);
            }
        }
        if i == 0 {
            if is_counted(&frames[0]) {
                picture.counts.add(&picture.hits[0]);
            }
            let rows = picture.hits[0].chunks(tile.width as usize);
            for (to, from) in hit_rows.iter_mut().zip(rows) {
                to.copy_from_slice(from);
            }
        }
        let colors = &mut picture.colors;
        shade_tile(frames, tile, probe, air, scratch, &picture.hits, colors);
    }
    picture.rgb.resize(3 * tile.area(), 0);
    if let Some(first) = frames.first() {
        show(first, tile, &picture.colors, &mut picture.rgb);
    }
}

/// Whether what the rays of a frame do is counted.
fn is_counted(frame: &FrameUniform) -> bool {
    frame.records & argil_abi::RECORD_COUNTS != 0
}

/// Samples of a pixel that are lit together.
pub(crate) const LIT_TOGETHER: usize = 4;

/// A program of this many operands uses the program near each point.
const MANY: usize = 1024;

/// Creates the [`NearField`] of an image if that pays, for the places where its rays and its light go.
fn near_field<'a>(program: &'a Program, frame: &FrameUniform) -> Option<NearField<'a>> {
    if program.operand_count() < MANY {
        return None;
    }
    let (around, far) = light_reach(frame);
    NearField::new(program, around, far)
}
