//! The triangles of a volume, for each kind.

use super::{bricks, dense};
use crate::Mesh;
use argil_volume::{Bricks, Dense, Levels, Octree, SampleFormat, Volume};

/// The reason why a volume has no triangles at a level.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// An octree's vacant cells have no samples to mesh.
    #[error("an octree cannot be meshed: use the field, a dense volume or sparse bricks")]
    Octree,
    /// Levels of detail have voxels of several sizes: see [`crate::levels::mesh_levels`].
    #[error("marching cubes needs voxels of one size, and levels of detail have several")]
    Levels,
    /// Bricks store only the surface at distance 0.
    #[error(
        "sparse bricks contain only the surface at distance 0: omit the iso level, or mesh the field or a dense volume"
    )]
    Iso,
    /// The level is beyond the stored band.
    #[error(
        "iso level {iso}: the volume stores distances up to {band}; choose a wider band, or mesh the field"
    )]
    Band {
        /// The requested level.
        iso: f32,
        /// The stored band.
        band: f32,
    },
}

impl SurfaceError {
    /// Checks that the stored samples reach a level.
    ///
    /// # Errors
    /// If the level is beyond the band.
    pub fn check_band(iso: f32, band: f32) -> Result<(), Self> {
        if iso.abs() >= band {
            return Err(Self::Band { iso, band });
        }
        Ok(())
    }
}

/// A representation that can be meshed.
pub trait Surface {
    /// Extracts the triangles at a level, in the scene's unit, with normals of the stored samples if requested and
    /// available.
    ///
    /// # Errors
    /// If the representation has no triangles, or none at that level.
    fn triangles(&self, iso: f32, with_normals: bool) -> Result<Mesh, SurfaceError>;
}

impl Surface for Dense {
    fn triangles(&self, iso: f32, with_normals: bool) -> Result<Mesh, SurfaceError> {
        let (voxel_grid, encoding) = (self.voxel_grid(), self.encoding());
        let band = encoding.band_width(voxel_grid, 0);
        SurfaceError::check_band(iso, band)?;
        let iso = iso / band * encoding.format.max_code() as f32;
        let grid = voxel_grid.grid(0);
        let texels = &self.levels()[0];
        Ok(match encoding.format {
            SampleFormat::Snorm8 => {
                let samples = texels.of::<i8>().expect("texels of 8 bits");
                dense::march(samples, &grid, iso, with_normals)
            }
            SampleFormat::Snorm16 => {
                let samples = texels.of::<i16>().expect("texels of 16 bits");
                dense::march(samples, &grid, iso, with_normals)
            }
        })
    }
}

impl Surface for Bricks {
    fn triangles(&self, iso: f32, _: bool) -> Result<Mesh, SurfaceError> {
        if iso != 0.0 {
            return Err(SurfaceError::Iso);
        }
        Ok(bricks::march(self).mesh)
    }
}

impl Surface for Octree {
    fn triangles(&self, _: f32, _: bool) -> Result<Mesh, SurfaceError> {
        Err(SurfaceError::Octree)
    }
}

impl Surface for Levels {
    fn triangles(&self, _: f32, _: bool) -> Result<Mesh, SurfaceError> {
        Err(SurfaceError::Levels)
    }
}

macro_rules! volumes {
    ($($name:ident),*) => {
        impl Surface for Volume {
            fn triangles(&self, iso: f32, with_normals: bool) -> Result<Mesh, SurfaceError> {
                match self { $(Self::$name(volume) => volume.triangles(iso, with_normals),)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);
