use crate::picture::Picture;
use crate::scratch::TileScratch;
use crate::shade::shade_tile;
use crate::tile::tiles;
use crate::trace::trace_tile;
use argil_abi::{Frame, Hit};
use argil_field::{Evaluator, Program};
use rayon::prelude::*;

/// Draw on the CPU, on rayon's current threads: `frames` as [`crate::frames`] makes them, one a sample.
pub fn render(program: &Program, frames: &[Frame]) -> Picture {
    let Some(first) = frames.first() else {
        return Picture::empty();
    };
    let (width, height) = (first.width as usize, first.height as usize);
    let mut hits = vec![Hit::default(); width * height];
    let mut colors = vec![[0.0f32; 4]; width * height];
    let all: Vec<_> = tiles(first.width, first.height).collect();

    // Each tile's part of the picture is one slice.
    let rows = all.first().map_or(1, |tile| tile.area());
    all.par_iter()
        .zip(hits.par_chunks_mut(rows))
        .zip(colors.par_chunks_mut(rows))
        .for_each_init(
            || (Evaluator::new(program), TileScratch::default(), Vec::new()),
            |(evaluator, scratch, sample), ((&tile, hits), colors)| {
                for (i, frame) in frames.iter().enumerate() {
                    sample.resize(tile.area(), Hit::default());
                    // Only the first sample's hits are kept.
                    let found = if i == 0 { &mut *hits } else { &mut sample[..] };
                    trace_tile(frame, tile, evaluator, scratch, found);
                    shade_tile(frame, tile, evaluator, scratch, found, colors);
                }
            },
        );
    Picture::new(first, &colors, hits)
}

/// Pixels of which at least half of the samples hit a solid.
pub fn hit_pixels(picture: &Picture) -> usize {
    picture.coverage.iter().filter(|&&c| c >= 0.499).count()
}
