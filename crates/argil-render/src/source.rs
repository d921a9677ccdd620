//! The traits that a representation implements to be rendered on the CPU.

use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, FrameUniform, GpuMaterial, Hit};

/// Something that primary rays march through: [`PrunedField`](crate::PrunedField),
/// [`UnprunedField`](crate::UnprunedField), [`Triangles`](crate::Triangles), and each of `argil_volume`'s volumes.
pub trait RenderSource: Sync {
    /// Prepares for the samples of one image, whose first frame this is. Returns `None` for a volume whose samples
    /// have another type than its encoding; constructors exclude that.
    #[doc(hidden)]
    fn tracer<'a>(&'a self, first: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>>;
}

/// A source of rays, prepared for one image.
pub trait RayTracer: Sync {
    /// Whether an image evaluates the field. With many operands, the program near each point is prepared for it.
    fn needs_field(&self, show: u32) -> bool {
        show == abi::MODE_SHADED
    }

    /// Traces the primary ray of each pixel of a tile into `out`, row by row.
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    );

    /// Returns where light reads distances, or `None` for the exact field.
    fn distance_source(&self) -> Option<&dyn DistanceSource> {
        None
    }
}

/// A source of distances for light, instead of the exact field.
pub trait DistanceSource: Sync {
    /// Looks up the materials of solid surfaces, whose indices `wanted` holds, and keeps there those without one.
    fn materials(
        &self,
        surfaces: &Surfaces,
        palette: &[GpuMaterial],
        wanted: &mut Vec<u32>,
        out: &mut [GpuMaterial],
    );

    /// Computes the distances of points into their `d`.
    fn measure(&self, points: &mut Points);

    /// Returns the shortest step of a shadow's ray.
    fn min_step(&self, frame: &FrameUniform) -> ByLength {
        ByLength::constant(2.0 * frame.epsilon)
    }

    /// Returns how far above the surface a shadow begins.
    fn lift(&self, frame: &FrameUniform) -> ByLength {
        ByLength::constant(frame.light_offset)
    }
}

/// A length in the scene's unit that grows with the length of a primary ray.
#[derive(Clone, Copy, Debug)]
pub struct ByLength {
    /// The least.
    pub least: f32,
    /// The share of the ray's length, if that is more.
    pub share: f32,
}

impl ByLength {
    pub(crate) fn constant(least: f32) -> Self {
        Self { least, share: 0.0 }
    }

    #[inline]
    pub(crate) fn at(self, length: f32) -> f32 {
        self.least.max(self.share * length)
    }
}

macro_rules! volumes {
    ($($name:ident),*) => {
        impl RenderSource for argil_volume::Volume {
            fn tracer<'a>(&'a self, first: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
                match self { $(Self::$name(volume) => volume.tracer(first),)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);
