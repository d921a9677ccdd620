//! Worlds for other programs: 3D Tiles and OME-Zarr, made of a world's tiles.

mod cells;
mod subtree;
mod tiles3d;
#[cfg(feature = "zarr")]
mod zarr;

use crate::WorldError;
use argil::scene::TempFolder;
use argil::volume::TileAddress;
use std::path::Path;

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorldExportReport {
    /// Levels of detail, from the coarsest to the finest that was asked for.
    pub levels: u32,
    /// Meshes of 3D Tiles, or shards of OME-Zarr.
    pub files: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Triangles of all meshes.
    pub triangles: u64,
    /// Tiles of the world that are missing or damaged. The export is coarser there.
    pub missing: u64,
    /// Files of edits beside the world. Tiles, and so exports, do not have them.
    pub edits_left_out: u64,
}

fn failed(path: &Path, reason: std::io::Error) -> WorldError {
    WorldError::Io {
        path: path.into(),
        reason,
    }
}

/// Creates the folder in which an export is made before it gets its name. A folder that is there is replaced only if it has a
/// file that tells that it is an older export.
fn begin(path: &Path, mark: &str) -> Result<TempFolder, WorldError> {
    TempFolder::for_export(path, mark).map_err(|error| failed(path, error))
}

/// Refuses an export without the coarsest tile, below which nothing is found.
fn check_any(
    report: &WorldExportReport,
    tiles: u64,
    first: Option<&TileAddress>,
) -> Result<(), WorldError> {
    match first {
        Some(first) if report.files == 0 => Err(WorldError::Incomplete {
            missing: report.missing,
            tiles,
            first: first.to_string(),
        }),
        _ => Ok(()),
    }
}

/// What tells which program made an export.
const GENERATOR: &str = concat!("argil ", env!("CARGO_PKG_VERSION"));
