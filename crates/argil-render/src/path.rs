//! Stills by path tracing, on the CPU.
//!
//! *Practice.* Passes of one path per pixel follow each other until all were made, the time is over, or somebody cancels. What
//! is there then is the picture: pixels that a last pass did not reach have fewer paths.

mod albedo;
mod bsdf;
mod denoise;
mod develop;
mod emitters;
mod environment;
pub(crate) mod fog;
mod glass;
mod gpu_tables;
mod integrator;
mod lights;
mod material;
mod microfacets;
mod sampler;
mod sky;
mod still;
mod view;

pub use denoise::denoised;
pub use develop::{Development, developed};
pub use gpu_tables::PathTables;
pub use integrator::{PathHit, PathScene};
pub(crate) use lights::lamp_rows;
pub use lights::{EnvironmentNotLoaded, PathLights};
pub use material::PathMaterial;
pub use still::Still;
pub use view::{PathLens, PathView, StillOptions};

use crate::tile::{Tile, tiles};
use argil_abi::FrameUniform;
use argil_math::Control;
use integrator::Integrator;
use rayon::prelude::*;
use sampler::Sampler;
use still::Pixel;
use web_time::Instant;

/// Makes a still, on rayon's current threads. The frame has the camera, the size and the ground. Canceled work returns what is
/// there.
pub fn trace_paths(
    scene: &dyn PathScene,
    view: &PathView,
    frame: &FrameUniform,
    options: &StillOptions,
    control: &Control,
) -> Still {
    let mut still = Still::new([frame.width, frame.height]);
    continue_paths(scene, view, frame, options, control, &mut still);
    still
}

/// How many parts a first pass has that the time limit may end.
const TURNS: u32 = 16;

/// Returns the part of a first pass to which a pixel belongs: those of each part are spread evenly (Bayer 1973).
fn turn_of(x: u32, y: u32) -> u32 {
    const ORDER: [[u32; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    ORDER[y as usize % 4][x as usize % 4]
}

/// Adds paths to a still of the same frame: see [`trace_paths`]. As many as one call would have made, made by several, are the same
/// paths.
///
/// # Panics
/// If the still has another size than the frame.
pub fn continue_paths(
    scene: &dyn PathScene,
    view: &PathView,
    frame: &FrameUniform,
    options: &StillOptions,
    control: &Control,
    still: &mut Still,
) {
    let start = Instant::now();
    let size = [frame.width, frame.height];
    assert_eq!(still.size, size, "a still of this frame");
    let all: Vec<_> = tiles(size[0], size[1]).collect();
    let row_of = |tile: &Tile, row: usize| {
        let begin = (tile.first_row as usize + row) * size[0] as usize + tile.first_x as usize;
        begin..begin + tile.width as usize
    };
    let mut of_tiles: Vec<Vec<Pixel>> = all
        .iter()
        .map(|tile| {
            let rows = 0..tile.area() / tile.width as usize;
            let rows = rows.map(|row| &still.pixels[row_of(tile, row)]);
            rows.flatten().copied().collect()
        })
        .collect();
    let integrator = Integrator {
        frame,
        scene,
        lights: &view.lights,
        fog: view.fog.filter(|fog| fog.density > 0.0),
        is_transparent: options.is_transparent,
        max_bounces: options.max_bounces,
        clamp: options.firefly_clamp.unwrap_or(f32::INFINITY),
    };
    let parts = u64::from(options.samples) * all.len() as u64 * u64::from(TURNS);
    control.begin("paths", parts);
    // The first part with a pixel that has no path.
    let places = (0..).zip(&still.pixels);
    let empty = places.filter(|(_, pixel)| pixel.count == 0);
    let first_turn = empty
        .map(|(i, _): (u32, _)| turn_of(i % size[0], i / size[0]))
        .min();
    let first_turn = first_turn.filter(|_| options.time_limit.is_some());
    'passes: for pass in 0..options.samples {
        let sparse = first_turn.filter(|_| pass == 0);
        let first = sparse.unwrap_or(TURNS - 1);
        for turn in first..TURNS {
            let is_over = || {
                let limit = options.time_limit.filter(|_| pass > 0 || turn > first);
                control.is_cancelled() || limit.is_some_and(|limit| start.elapsed() >= limit)
            };
            of_tiles
                .par_iter_mut()
                .zip(&all)
                .for_each(|(pixels, tile)| {
                    for (y, row) in (tile.first_row..).zip(pixels.chunks_mut(tile.width as usize)) {
                        if is_over() {
                            return;
                        }
                        for (x, pixel) in (tile.first_x..).zip(row) {
                            if sparse.is_some() && (turn_of(x, y) != turn || pixel.count > 0) {
                                continue;
                            }
                            let mut sampler = Sampler::new(y * size[0] + x, pixel.count);
                            let [u, v] = sampler.pair();
                            let on_lens = sampler.pair();
                            let place = [x as f32 + u, y as f32 + v];
                            let (origin, direction) = view.ray(frame, place, on_lens);
                            pixel.add(&integrator.path(origin, direction, &mut sampler));
                        }
                    }
                    control.advance(if sparse.is_some() { 1 } else { TURNS.into() });
                });
            if is_over() {
                break 'passes;
            }
        }
    }
    for (tile, tile_pixels) in all.iter().zip(of_tiles) {
        for (row, row_pixels) in tile_pixels.chunks(tile.width as usize).enumerate() {
            still.pixels[row_of(tile, row)].copy_from_slice(row_pixels);
        }
    }
}
