//! Reads volumes of other programs as shapes.

mod dense_file;
mod distances;
mod lattice;

use argil_math::Aabb;
use argil_scene::{SAMPLED_SIDE, SampledGrid, ValidationError};
use argil_vdb::vdb::VdbFile;
use argil_vdb::{Grid, GridClass, VdbError, nvdb};
use dense_file::read_dense;
pub use dense_file::{RawLayout, RawType};
use distances::{Distances, scale_to_distances};
use glam::{IVec3, Vec3};
use lattice::{Lattice, Samples};
use std::path::{Path, PathBuf};

/// Maximum cells of 8³ voxels in the box of a volume.
const MAX_CELLS: u64 = 1 << 24;
/// Maximum leaves that active tiles become.
const MAX_LEAVES: u64 = 1 << 20;
/// Cells and leaves of any file, however small. A cell takes 60 bytes, and a leaf 2 KiB.
const FREE_CELLS: u64 = 1 << 20;
const FREE_LEAVES: u64 = 1 << 14;
/// Maximum distance of a voxel from the origin, along an axis.
const MAX_INDEX: i32 = 1 << 24;
/// Minimum voxels around the solid in the finest level.
const ROOM: i32 = 10;
/// Maximum cells along a side.
const MAX_SIDE: i32 = 512;

/// How a volume file is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolumeReadOptions {
    /// `.vdb`, `.nvdb`: the grid's name. `None` is the first one that holds single numbers.
    pub grid: Option<String>,
    /// Whether values are distances or densities. `None` asks the file, and takes distances if that does not say.
    pub is_fog: Option<bool>,
    /// The value at the surface: 0 for distances, and half of the largest density.
    pub iso: Option<f32>,
    /// `.raw`: the layout. `.npy`: the voxel size and the origin.
    pub raw: RawLayout,
}

/// A volume as a shape.
#[derive(Clone, Debug)]
pub struct ReadVolume {
    /// The distances, in the file's space. Its unit becomes the scene's.
    pub grid: SampledGrid,
    /// Name of the grid in the file.
    pub name: String,
    /// Names of the file's other grids, which were not read, such as colors.
    pub other_grids: Vec<String>,
    /// Whether values were densities.
    pub is_fog: bool,
    /// Edge of a voxel.
    pub voxel_size: f32,
    /// Voxels whose values were read.
    pub voxels: u64,
    /// The factor of values: 1 for distances. Values whose slope near the surface is below 0.8 or above 1.25, such as those
    /// in another unit, are scaled to a slope of 1.
    pub scale: f32,
}

/// The reason why a volume cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VolumeReadError {
    /// The file cannot be read.
    #[error("{}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is damaged, or not supported.
    #[error("{}", path.display())]
    Vdb {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong.
        source: VdbError,
    },
    /// The file has no solid.
    #[error("{}: {reason}", path.display())]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong, and what to do.
        reason: String,
    },
}

/// Whether a file name is that of a volume of another program: `.vdb`, `.nvdb`, `.npy`, `.nrrd` or `.raw`.
pub fn is_volume_file(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    ["vdb", "nvdb", "npy", "nrrd", "raw"].contains(&ending.to_lowercase().as_str())
}

/// Reads a volume of another program as a sampled shape: a level set, or the surface of densities. Its distances equal
/// the file's at all voxels nearer to the surface than two voxels. Farther away they are those to the surface between voxels, as
/// far as twice the solid's size. Values of other slopes are scaled: see [`ReadVolume::scale`].
///
/// ```
/// # use argil::prelude::*;
/// use argil::{ExportOptions, VolumeReadOptions, read_volume};
/// # let mut scene = Scene::new();
/// # scene.push(Shape::sphere(0.5))?;
/// # let folder = tempfile::tempdir()?;
/// # let file = folder.path().join("sphere.vdb");
/// let world = Engine::cpu().build(&scene)?.field();
/// world.export(&file, &ExportOptions { resolution: 64, ..ExportOptions::default() })?;
/// let read = read_volume(&file, &VolumeReadOptions::default())?;
/// let mut copy = Scene::new();
/// copy.push(Shape::sampled("sphere", read.grid).at([2.0, 0.0, 0.0]))?;
/// let there = Engine::cpu().build(&copy)?.field().distance([2.5, 0.0, 0.0]);
/// assert!(there.abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the file cannot be read, is damaged, has voxels that are no cubes along the axes, or holds no surface.
pub fn read_volume(
    path: impl AsRef<Path>,
    options: &VolumeReadOptions,
) -> Result<ReadVolume, VolumeReadError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| VolumeReadError::File {
        path: path.into(),
        source,
    })?;
    read_volume_bytes(&bytes, path, options)
}

/// Reads a volume as [`read_volume`](fn@read_volume) does, from bytes. `path` tells the format, and appears in messages.
///
/// # Errors
/// If the bytes are damaged, have voxels that are no cubes along the axes, or hold no surface.
pub fn read_volume_bytes(
    bytes: &[u8],
    path: &Path,
    options: &VolumeReadOptions,
) -> Result<ReadVolume, VolumeReadError> {
    let refuse = |reason: String| VolumeReadError::Content {
        path: path.into(),
        reason,
    };
    let damaged = |source| VolumeReadError::Vdb {
        path: path.into(),
        source,
    };
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let name = options.grid.as_deref();
    let size = bytes.len() as u64;
    let mut all_grids = Vec::new();
    let (lattice, name, class) = match ending.to_lowercase().as_str() {
        "vdb" => {
            let file = VdbFile::parse(bytes).map_err(damaged)?;
            all_grids.extend(file.grids.iter().map(|stored| stored.name.clone()));
            let grid = file.float_grid(name);
            of_grid(grid.map_err(damaged)?, size).map_err(refuse)?
        }
        "nvdb" => {
            let grids = nvdb::read(bytes).map_err(damaged)?;
            all_grids.extend(grids.iter().map(|stored| stored.header.name.clone()));
            let found = grids
                .into_iter()
                .find(|stored| name.is_none_or(|name| stored.header.name == name));
            let grid = found.ok_or_else(|| refuse(format!("no grid is named {name:?}")))?;
            of_grid(grid, size).map_err(refuse)?
        }
        ending => {
            if name.is_some() {
                return Err(refuse(format!(
                    "a .{ending} file holds one grid, without a name"
                )));
            }
            let lattice = read_dense(bytes, ending, &options.raw).map_err(refuse)?;
            (lattice, String::new(), GridClass::Unknown)
        }
    };
    let is_fog = options.is_fog.unwrap_or(class == GridClass::FogVolume);
    let lattice = match (is_fog, options.iso) {
        (true, iso) => lattice.of_densities(iso),
        (false, Some(iso)) => lattice.moved(iso),
        (false, None) => Ok(lattice),
    };
    let mut lattice = lattice.map_err(refuse)?;
    let scale = scale_to_distances(&mut lattice);
    let grid = sampled(&lattice, size).map_err(refuse)?;
    if let Some(position) = all_grids.iter().position(|other| *other == name) {
        all_grids.remove(position);
    }
    Ok(ReadVolume {
        grid,
        name,
        other_grids: all_grids,
        is_fog,
        voxel_size: lattice.voxel_size,
        voxels: lattice.known_voxels(),
        scale,
    })
}

type NamedLattice = (Lattice, String, GridClass);

/// Returns the values of a grid in a file of some bytes.
fn of_grid(grid: Grid<f32>, file_bytes: u64) -> Result<NamedLattice, String> {
    let Grid { header, mut tree } = grid;
    let is_near = |c: &i32| c.unsigned_abs() <= MAX_INDEX as u32;
    if !tree
        .uppers
        .iter()
        .all(|upper| upper.origin.iter().all(is_near))
    {
        return Err(too_far());
    }
    let has_tiles = tree.statistics().active_tiles != [0; 3];
    let most = MAX_LEAVES.min(FREE_LEAVES + file_bytes / 32);
    if !tree.expand_active_tiles(most) {
        return Err(format!(
            "active tiles of grid {:?} take more than {most} leaves of 8³ voxels: resample it to larger voxels",
            header.name
        ));
    }
    if has_tiles && header.class == GridClass::LevelSet {
        tree.flood_signs();
    }
    let voxel_size = header.transform.uniform_voxel_size().ok_or_else(|| {
        format!(
            "the voxels of grid {:?} are no cubes along the axes: resample it to uniform voxels",
            header.name
        )
    })?;
    let lattice = Lattice {
        voxel_size: voxel_size as f32,
        origin: Vec3::from(header.transform.translation.map(|c| c as f32)),
        samples: Samples::Sparse(tree),
    };
    Ok((lattice, header.name, header.class))
}

fn too_far() -> String {
    format!("the solid reaches {MAX_INDEX} voxels from the origin or farther: move it nearer")
}

/// Samples a shape, in cells of 8³ voxels whose corners are at multiples of 8. Its file has some bytes.
fn sampled(lattice: &Lattice, file_bytes: u64) -> Result<SampledGrid, String> {
    if !(lattice.voxel_size > 0.0 && lattice.origin.is_finite()) {
        return Err("the size or the place of its voxels is not a number".into());
    }
    let Some([low, high]) = lattice.inside() else {
        return Err(
            "no value is inside: distances are negative inside, densities need --class fog".into(),
        );
    };
    if low.min_element() < -MAX_INDEX || high.max_element() > MAX_INDEX {
        return Err(too_far());
    }
    let side = SAMPLED_SIDE as i32;
    let first = (low - ROOM).map(|c| c.div_euclid(side));
    let last = (high + ROOM).map(|c| c.div_euclid(side));
    // An even number of cells, as levels have.
    let cells = (last - first + 2) / 2 * 2;
    let count: u64 = cells.to_array().map(|n| n as u64).iter().product();
    let most = MAX_CELLS.min(FREE_CELLS + file_bytes);
    if cells.max_element() > MAX_SIDE || count > most {
        return Err(format!(
            "the solid takes {} voxels: at most {} along a side and {most} cells of 8³ are read of a file of {file_bytes} bytes; resample it",
            high - low + 1,
            MAX_SIDE * side
        ));
    }
    let distances = Distances::new(lattice, first * side).ok_or(
        "no value is next to a surface: these are no distances; densities need --class fog",
    )?;
    let place = |index: IVec3| lattice.origin + lattice.voxel_size * index.as_vec3();
    let solid = Aabb::new(place(low - 1), place(high + 1));
    let corner = place(first * side);
    let cell = lattice.voxel_size * side as f32;
    let grid = SampledGrid::sample(corner, cell, cells.as_uvec3(), solid, &distances);
    let text = |error: ValidationError| error.to_string();
    grid.check().map_err(text)?;
    Ok(grid)
}
