use crate::dense::{DenseRays, trace_dense};
use crate::octree::{Descent, OctreeRays};
use crate::picture::Picture;
use crate::scratch::TileScratch;
use crate::shade::shade_tile;
use crate::tile::{Tile, tiles};
use crate::trace::trace_tile;
use crate::volume::trace_volume;
use argil_abi::{Frame, Hit};
use argil_field::{Evaluator, Program};
use argil_volume::{Bits, Dense, Octree};
use rayon::prelude::*;

/// What rays are marched through.
#[derive(Clone, Copy)]
pub enum Through<'a> {
    /// The field itself.
    Field,
    /// A dense volume.
    Dense(&'a Dense),
    /// An octree of bricks.
    Octree(&'a Octree, Descent),
}

/// Draw on the CPU, on rayon's current threads: `frames` as [`crate::frames`] makes them, one a sample. Primary rays and
/// normals are what `through` gives; light and materials are the field's.
pub fn render(program: &Program, through: Through<'_>, frames: &[Frame]) -> Picture {
    let Some(first) = frames.first() else {
        return Picture::empty();
    };
    let (width, height) = (first.width as usize, first.height as usize);
    let mut hits = vec![Hit::default(); width * height];
    let mut colors = vec![[0.0f32; 4]; width * height];
    let all: Vec<_> = tiles(first.width, first.height).collect();
    let rays = Rays::new(through);

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
                    rays.trace(frame, tile, evaluator, scratch, found);
                    shade_tile(frame, tile, evaluator, scratch, found, colors);
                }
            },
        );
    Picture::new(first, &colors, hits)
}

/// What rays are marched through, made ready once a picture.
enum Rays<'a> {
    Field,
    Dense(Box<DenseRays<'a>>),
    Eight(OctreeRays<'a, i8>),
    Sixteen(OctreeRays<'a, i16>),
    /// Of a volume whose texels are not of the type that its encoding says; its constructors let none arise.
    Nothing,
}

impl<'a> Rays<'a> {
    fn new(through: Through<'a>) -> Self {
        let rays = match through {
            Through::Field => Some(Self::Field),
            Through::Dense(dense) => DenseRays::new(dense).map(|rays| Self::Dense(Box::new(rays))),
            Through::Octree(octree, descent) => match octree.layout().encoding.bits {
                Bits::Eight => OctreeRays::new(octree, descent).map(Self::Eight),
                Bits::Sixteen => OctreeRays::new(octree, descent).map(Self::Sixteen),
            },
        };
        rays.unwrap_or(Self::Nothing)
    }

    fn trace(
        &self,
        frame: &Frame,
        tile: Tile,
        evaluator: &mut Evaluator<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        match self {
            Self::Field => trace_tile(frame, tile, evaluator, scratch, out),
            Self::Dense(rays) => trace_dense(frame, tile, rays, scratch, out),
            Self::Eight(rays) => trace_volume(frame, tile, rays, out),
            Self::Sixteen(rays) => trace_volume(frame, tile, rays, out),
            Self::Nothing => {}
        }
    }
}

/// Pixels of which at least half of the samples hit a solid.
pub fn hit_pixels(picture: &Picture) -> usize {
    picture.coverage.iter().filter(|&&c| c >= 0.499).count()
}
