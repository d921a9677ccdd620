use crate::picture::{Picture, encode_srgb};
use crate::shade::shade_tile;
use crate::trace::{TILE, TileScratch, tiles, trace_tile};
use argil_abi::{Frame, Hit};
use argil_field::{Evaluator, Program};
use rayon::prelude::*;

/// Draw on the CPU, on rayon's current threads: `frames` as [`crate::frames`] makes them, one a sample.
pub fn render(program: &Program, frames: &[Frame]) -> Picture {
    let Some(first) = frames.first() else {
        return Picture { size: [0, 0], rgb: Vec::new(), hits: Vec::new(), coverage: Vec::new() };
    };
    let (width, height) = (first.width as usize, first.height as usize);
    let mut hits = vec![Hit::default(); width * height];
    let mut colors = vec![[0.0f32; 4]; width * height];
    let all: Vec<_> = tiles(first.width, first.height).collect();

    // Each tile is drawn apart and copied to its place.
    let area = (TILE * TILE) as usize;
    let drawn: Vec<_> = all
        .par_iter()
        .map_init(
            || (Evaluator::new(program), TileScratch::default(), vec![Hit::default(); area]),
            |(evaluator, scratch, sample), &tile| {
                let mut tile_hits = vec![Hit::default(); tile.area()];
                let mut tile_colors = vec![[0.0f32; 4]; tile.area()];
                for (i, frame) in frames.iter().enumerate() {
                    let found = if i == 0 { &mut tile_hits[..] } else { &mut sample[..tile.area()] };
                    trace_tile(frame, tile, evaluator, scratch, found);
                    shade_tile(frame, tile, evaluator, scratch, found, &mut tile_colors);
                }
                (tile_hits, tile_colors)
            },
        )
        .collect();
    for (tile, (tile_hits, tile_colors)) in all.iter().zip(&drawn) {
        for row in 0..tile.height as usize {
            let to = (tile.y as usize + row) * width + tile.x as usize;
            let from = row * tile.width as usize;
            let n = tile.width as usize;
            hits[to..to + n].copy_from_slice(&tile_hits[from..from + n]);
            colors[to..to + n].copy_from_slice(&tile_colors[from..from + n]);
        }
    }
    let (rgb, coverage) = encode_srgb(&colors);
    Picture { size: [first.width, first.height], rgb, hits, coverage }
}

/// Pixels of which at least half of the samples hit a solid.
pub fn hit_pixels(picture: &Picture) -> usize {
    picture.coverage.iter().filter(|&&c| c >= 0.499).count()
}
