use crate::bricks::{BrickRays, trace_bricks};
use crate::dense::{DenseRays, trace_dense};
use crate::octree::{Descent, OctreeRays};
use crate::picture::{Picture, covered, show};
use crate::probe::{Probe, near_field};
use crate::raster::{Raster, Triangles};
use crate::scratch::{TilePicture, TileScratch};
use crate::shade::{Air, shade_tile};
use crate::slabs::{PrunedField, trace_pruned};
use crate::statistics::Counts;
use crate::tile::{Tile, tile_rows, tiles};
use crate::trace::trace_tile;
use crate::volume::trace_volume;
use argil_abi::{self as abi, Frame, Hit};
use argil_field::Program;
use argil_math::Control;
use argil_volume::{Bits, Bricks, Dense, Octree};
use rayon::prelude::*;
use std::cell::RefCell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What rays are marched through.
#[derive(Clone, Copy)]
pub enum Through<'a> {
    /// The field itself.
    Field,
    /// The field with nothing pruned, as a GPU marches through it: what pruning is held against.
    WholeField,
    /// A dense volume.
    Dense(&'a Dense),
    /// An octree of bricks.
    Octree(&'a Octree, Descent),
    /// Sparse bricks.
    Bricks(&'a Bricks),
    /// Not marched but drawn: triangles. Light and materials are the field's.
    Mesh(Triangles<'a>),
}

thread_local! {
    /// Kept as long as the thread: a frame allocates nothing but its picture.
    static SCRATCH: RefCell<(TileScratch, TilePicture)> = RefCell::default();
}

/// Draw on the CPU, on rayon's current threads: `frames` as [`crate::frames`] makes them, one a sample. Primary rays and
/// normals are what `through` gives, and of sparse bricks the light; materials are the field's, and so is other light. The picture's hits are left out.
pub fn render(program: &Program, through: Through<'_>, frames: &[Frame]) -> Picture {
    draw(program, through, frames, false, &Control::default())
}

/// The same with what the first sample of each pixel hit.
pub fn render_with_hits(program: &Program, through: Through<'_>, frames: &[Frame]) -> Picture {
    draw(program, through, frames, true, &Control::default())
}

/// The same, with or without hits, told and stopped by somebody else; `None` if it was cancelled before the last tile was drawn.
pub fn render_controlled(
    program: &Program,
    through: Through<'_>,
    frames: &[Frame],
    keeps_hits: bool,
    control: &Control,
) -> Option<Picture> {
    let picture = draw(program, through, frames, keeps_hits, control);
    (!control.is_cancelled()).then_some(picture)
}

fn draw(
    program: &Program,
    through: Through<'_>,
    frames: &[Frame],
    keeps_hits: bool,
    control: &Control,
) -> Picture {
    let Some(first) = frames.first() else {
        return Picture::empty();
    };
    let (width, height) = (first.width, first.height);
    let pixels = width as usize * height as usize;
    let mut rgb = vec![0; 3 * pixels];
    let mut hits = vec![Hit::default(); if keeps_hits { pixels } else { 0 }];
    let rays = Rays::new(through, first);
    // Bricks tell light themselves; all else but the whole field asks what is near.
    let asks_near = match through {
        Through::Field => true,
        Through::Dense(_) | Through::Octree(..) | Through::Mesh(_) => {
            first.show == abi::SHOW_SHADED
        }
        Through::WholeField | Through::Bricks(_) => false,
    };
    let near = asks_near.then(|| near_field(program, first)).flatten();
    let counts = Mutex::new(Counts::default());
    let hit_pixels = AtomicUsize::new(0);
    let mut hit_rows = tile_rows(&mut hits, width, 1);
    let all: Vec<_> = tiles(width, height).collect();
    hit_rows.resize_with(all.len(), Vec::new);
    control.begin("picture", all.len() as u64);
    all.par_iter()
        .zip(tile_rows(&mut rgb, width, 3))
        .zip(hit_rows)
        .for_each_init(
            || {
                (
                    Probe::new(program, near.as_ref()),
                    PrunedField::new(program),
                )
            },
            |(probe, pruned), ((&tile, rgb_rows), mut hit_rows)| {
                if control.is_cancelled() {
                    return;
                }
                SCRATCH.with_borrow_mut(|(scratch, own)| {
                    own.colors.clear();
                    own.colors.resize(tile.area(), [0.0; 4]);
                    own.hits.resize(tile.area(), Hit::default());
                    for (i, frame) in frames.iter().enumerate() {
                        rays.trace(frame, tile, (pruned, probe), scratch, &mut own.hits);
                        if i == 0 {
                            own.counts.add(&own.hits);
                            let rows = own.hits.chunks(tile.width as usize);
                            for (to, from) in hit_rows.iter_mut().zip(rows) {
                                to.copy_from_slice(from);
                            }
                        }
                        let air = rays.air();
                        shade_tile(frame, tile, probe, air, scratch, &own.hits, &mut own.colors);
                    }
                    own.rgb.resize(3 * tile.area(), 0);
                    show(first, &own.colors, &mut own.rgb);
                    let rows = own.rgb.chunks(3 * tile.width as usize);
                    for (to, from) in rgb_rows.into_iter().zip(rows) {
                        to.copy_from_slice(from);
                    }
                    hit_pixels.fetch_add(covered(&own.colors), Ordering::Relaxed);
                    if let Ok(mut counts) = counts.lock() {
                        counts.merge(&own.counts);
                    }
                    own.counts.clear();
                });
                control.advance(1);
            },
        );
    Picture {
        size: [width, height],
        rgb,
        hits,
        statistics: counts
            .into_inner()
            .expect("no thread of it has panicked")
            .statistics(),
        hit_pixels: hit_pixels.into_inner(),
    }
}

/// What rays are marched through, made ready once a picture.
enum Rays<'a> {
    Field,
    WholeField,
    Dense(Box<DenseRays<'a>>),
    Eight(OctreeRays<'a, i8>),
    Sixteen(OctreeRays<'a, i16>),
    Bricks(BrickRays<'a>),
    Mesh(Raster<'a>),
    /// Of a volume whose texels are not of the type that its encoding says; its constructors let none arise.
    Nothing,
}

impl<'a> Rays<'a> {
    fn new(through: Through<'a>, first: &Frame) -> Self {
        let rays = match through {
            Through::Field => Some(Self::Field),
            Through::WholeField => Some(Self::WholeField),
            Through::Dense(dense) => DenseRays::new(dense).map(|rays| Self::Dense(Box::new(rays))),
            Through::Bricks(bricks) => BrickRays::new(bricks).map(Self::Bricks),
            Through::Mesh(mesh) => Some(Self::Mesh(Raster::new(mesh, first))),
            Through::Octree(octree, descent) => match octree.layout().encoding.bits {
                Bits::Eight => OctreeRays::new(octree, descent).map(Self::Eight),
                Bits::Sixteen => OctreeRays::new(octree, descent).map(Self::Sixteen),
            },
        };
        rays.unwrap_or(Self::Nothing)
    }

    /// What light is gathered by.
    fn air(&self) -> Air<'_, 'a> {
        match self {
            Self::Bricks(bricks) => Air::Bricks(bricks),
            _ => Air::Field,
        }
    }

    fn trace(
        &self,
        frame: &Frame,
        tile: Tile,
        (pruned, probe): (&mut PrunedField<'_>, &mut Probe<'_>),
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        match self {
            Self::Field if probe.is_near() => trace_tile(frame, tile, probe, scratch, out),
            Self::Field => trace_pruned(frame, tile, pruned, &mut probe.evaluator, scratch, out),
            Self::WholeField => trace_tile(frame, tile, probe, scratch, out),
            Self::Dense(rays) => trace_dense(frame, tile, rays, scratch, out),
            Self::Eight(rays) => trace_volume(frame, tile, rays, out),
            Self::Sixteen(rays) => trace_volume(frame, tile, rays, out),
            Self::Bricks(rays) => trace_bricks(frame, tile, rays, probe, scratch, out),
            Self::Mesh(raster) => raster.draw(frame, tile, &mut scratch.directions, out),
            Self::Nothing => {}
        }
    }
}
