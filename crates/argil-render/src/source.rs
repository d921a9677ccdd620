//! What rays are marched through: the two traits that a representation implements for its pictures on the CPU.

use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use argil_abi::{self as abi, FrameUniform, GpuMaterial, Hit};
use glam::Vec3;

/// Something that primary rays are marched through. This crate implements it, one file each: for [`Field`](crate::PrunedField),
/// [`WholeField`](crate::WholeField), [`Triangles`](crate::Triangles), and each of `argil_volume`'s volumes.
pub trait RenderSource: Sync {
    /// Makes it ready for the samples of one picture, whose first frame this is. Nothing of a volume whose texels are not of the type
    /// that its encoding says; constructors let none arise.
    #[doc(hidden)]
    fn rays<'a>(&'a self, first: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>>;
}

/// What rays are marched through, made ready once a picture.
pub trait RayTracer: Sync {
    /// Whether a picture asks the field for distances: of many operands, what is near where is found for it.
    fn asks_field(&self, show: u32) -> bool {
        show == abi::SHOW_SHADED
    }

    /// What the primary ray of each pixel of a tile hits, row by row, into `out`.
    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    );

    /// What light is gathered by; the exact field without it.
    fn air(&self) -> Option<&dyn DistanceSource> {
        None
    }
}

/// What tells how far the surface is from points in the air, in place of the exact field.
pub trait DistanceSource: Sync {
    /// What is stored of the material at a point of a surface, given the direction out of the solid.
    fn material(&self, point: Vec3, outwards: Vec3, palette: &[GpuMaterial])
    -> Option<GpuMaterial>;

    /// Fill `d` of some points.
    fn measure(&self, points: &mut Points);
}

macro_rules! volumes {
    ($($name:ident),*) => {
        impl RenderSource for argil_volume::Volume {
            fn rays<'a>(&'a self, first: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
                match self { $(Self::$name(own) => own.rays(first),)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);
