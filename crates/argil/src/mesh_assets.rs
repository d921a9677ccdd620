//! Finds, checks, samples and caches the meshes that scenes name.

use crate::external_files::ExternalFiles;
use crate::heightmap::heights;
use crate::image_assets;
#[cfg(feature = "mesh-files")]
use crate::mesh_cache;
use crate::mesh_facts::MeshFacts;
use crate::mesh_file_error::MeshFileError;
use argil_math::Control;
use argil_mesh::{MeshFormat, MeshReadError, MeshSdf, MeshSource, RepairReport};
use argil_scene::{SampledGrid, Scene, Shape, is_grid, is_image};
use argil_volume::StoredMesh;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh or a heightmap image that a scene names.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// Path in the scene.
    pub path: String,
    /// Samples along the longest side, or posts of a heightmap.
    pub resolution: u32,
    /// Its distances, or heights.
    pub grid: Arc<SampledGrid>,
    /// Number of triangles, including those that close holes.
    pub triangles: u64,
    /// What was repaired.
    pub repairs: RepairReport,
    /// What the reader left out of the file, or was uncertain about.
    pub file_warnings: Vec<String>,
    /// Whether the samples came from the cache.
    pub from_cache: bool,
}

impl LoadedMesh {
    /// Describes what a user should know: what was left out of the file, which parts were dropped or filled, and whether
    /// a heightmap has a cliff.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.file_warnings.clone();
        warnings.extend(self.repairs.warnings());
        let share = self.grid.steepest_share();
        if share > STEEP {
            warnings.push(format!(
                "one step between posts is {share:.0} times as steep as most others, which shortens all distances: smooth the image there, or use fewer posts"
            ));
        }
        warnings
    }

    /// Returns a shape of this mesh. A heightmap keeps its image's proportions, and its longer side is 2.
    pub fn shape(&self) -> Shape {
        let mut shape = Shape::from_file(self.path.clone());
        if let Some((_, resolution, grid)) = shape.file_mut() {
            *resolution = self.resolution;
            grid.0 = Some(self.grid.clone());
        }
        if let Shape::Heightmap { half_size, .. } = &mut shape {
            let [x, z] = self.grid.posts().map(|n| n as f32 - 1.0);
            *half_size = [x, z].map(|side| side / x.max(z));
        }
        shape
    }
}

/// A step of a heightmap that is this many times steeper than nearly all others is reported as a cliff.
const STEEP: f32 = 6.0;

/// Loads the meshes, heightmaps and images that a scene names and does not have yet. `folder` is the folder of the
/// scene's file. Paths may leave it only to `external` files: none, all, or some. The samples are cached in the user's cache folder,
/// by the hash of the file's bytes.
///
/// # Errors
/// If a file lies outside the folder, cannot be read, or holds no triangles.
pub fn load_meshes(
    scene: &mut Scene,
    folder: &Path,
    external: impl Into<ExternalFiles>,
) -> Result<Vec<LoadedMesh>, MeshFileError> {
    load_meshes_with_control(scene, folder, external, &Control::default())
}

/// Loads meshes as [`load_meshes`] does, and can be canceled. Meshes that were loaded before stay in the scene.
///
/// # Errors
/// If a file lies outside the folder, cannot be read, or holds no triangles, or if the work was canceled.
pub fn load_meshes_with_control(
    scene: &mut Scene,
    folder: &Path,
    external: impl Into<ExternalFiles>,
    control: &Control,
) -> Result<Vec<LoadedMesh>, MeshFileError> {
    let external = external.into();
    let textures = scene.missing_texture_images();
    image_assets::load(scene, textures, |path| {
        image_bytes(path, folder, &external).map(Some)
    })?;
    let mut loaded = Vec::new();
    // A file that is used at several resolutions is read once.
    let mut solids: HashMap<PathBuf, Solid> = HashMap::new();
    for (path, resolution) in scene.missing_meshes() {
        let place = external.place_of(&path, folder)?;
        let mesh = load(&path, &place, resolution, &mut solids, control)?;
        scene.set_mesh_grid(path, resolution, mesh.grid.clone());
        loaded.push(mesh);
    }
    Ok(loaded)
}

/// Loads the images of textures and of the environment that a scene names and does not have yet. `folder` is the folder of
/// the scene's file. Paths may leave it only to `external` files: none, all, or some.
///
/// # Errors
/// If a file lies outside the folder, or cannot be read.
pub fn load_images(
    scene: &mut Scene,
    folder: &Path,
    external: impl Into<ExternalFiles>,
) -> Result<(), MeshFileError> {
    let external = external.into();
    let images = scene.missing_images();
    image_assets::load(scene, images, |path| {
        image_bytes(path, folder, &external).map(Some)
    })
}

/// Returns the place and the bytes of an image.
fn image_bytes(
    path: &str,
    folder: &Path,
    external: &ExternalFiles,
) -> Result<(PathBuf, Vec<u8>), MeshFileError> {
    let place = external.place_of(path, folder)?;
    let bytes = std::fs::read(&place).map_err(|error| MeshFileError::Image {
        path: place.clone(),
        reason: format!(
            "the image \"{path}\", which the scene names, cannot be read: {error}; images lie beside the scene"
        ),
    })?;
    Ok((place, bytes))
}

/// Loads meshes from bytes, found by file name without folder. Names that are not given stay missing. Nothing is
/// cached.
///
/// # Errors
/// If the bytes hold no mesh.
pub fn load_meshes_from_bytes(
    scene: &mut Scene,
    files: &[(String, Vec<u8>)],
) -> Result<Vec<LoadedMesh>, MeshFileError> {
    let images = scene.missing_images();
    image_assets::load(scene, images, |path| {
        let name = Path::new(path).file_name().unwrap_or_default();
        let file = files.iter().find(|(file, _)| name == file.as_str());
        Ok(file.map(|(file, bytes)| (file.into(), bytes.clone())))
    })?;
    let mut loaded = Vec::new();
    for (path, resolution) in scene.missing_meshes() {
        let name = Path::new(&path).file_name().unwrap_or_default();
        let Some((file_name, bytes)) = files
            .iter()
            .find(|(file_name, _)| name == file_name.as_str())
        else {
            continue;
        };
        let place = Path::new(file_name);
        #[cfg(feature = "volume-files")]
        if crate::is_volume_file(place) {
            let volume = crate::read_volume_bytes(bytes, place, &Default::default())?;
            let mesh = of_grid(&path, resolution, volume.grid);
            scene.set_mesh_grid(path, resolution, mesh.grid.clone());
            loaded.push(mesh);
            continue;
        }
        if is_image(file_name) || is_grid(file_name) {
            let grid = match is_image(file_name) {
                true => heights(bytes, resolution, place)?,
                false => grid_of(bytes, place)?,
            };
            let mesh = of_grid(&path, resolution, grid);
            scene.set_mesh_grid(path, resolution, mesh.grid.clone());
            loaded.push(mesh);
            continue;
        }
        let format = MeshFormat::from_path(place)
            .ok_or_else(|| MeshReadError::UnknownFormat(place.into()))?;
        let source = MeshSource::new(&bytes[..], format, place);
        let solid = solid_of(&source.with_files(|name| given(files, name))?, place)?;
        let grid = sampled(&solid.sdf, resolution, place, &Control::default())?;
        let mesh = LoadedMesh {
            grid: Arc::new(grid),
            resolution,
            triangles: solid.sdf.triangles() as u64,
            repairs: *solid.sdf.repairs(),
            file_warnings: solid.file_warnings,
            from_cache: false,
            path,
        };
        scene.set_mesh_grid(mesh.path.clone(), resolution, mesh.grid.clone());
        loaded.push(mesh);
    }
    Ok(loaded)
}

/// Returns the bytes of a file that a mesh file names, found by its file name without folder.
fn given(files: &[(String, Vec<u8>)], path: &str) -> Result<Vec<u8>, MeshReadError> {
    let name = Path::new(path).file_name().unwrap_or_default();
    let file = files.iter().find(|(file, _)| name == file.as_str());
    let (_, bytes) = file.ok_or_else(|| MeshReadError::Io {
        path: path.into(),
        source: std::io::Error::other("it is not among the files: add it, too"),
    })?;
    Ok(bytes.clone())
}

/// Returns the meshes of a scene, for a volume file.
pub(crate) fn meshes_to_store(scene: &Scene) -> Vec<StoredMesh<'_>> {
    let loaded = scene.loaded_meshes().into_iter();
    loaded
        .map(|(path, resolution, grid)| StoredMesh {
            path: path.into(),
            resolution,
            solid: grid.solid(),
            words: grid.words().into(),
        })
        .collect()
}

/// The solid of a mesh file.
struct Solid {
    sdf: MeshSdf,
    file_warnings: Vec<String>,
}

fn solid_of(source: &MeshSource<'_>, place: &Path) -> Result<Solid, MeshFileError> {
    let file = source.read()?;
    let sdf = MeshSdf::new(&file.mesh).map_err(|source| MeshFileError::Empty {
        path: place.into(),
        source,
    })?;
    let file_warnings = file.warnings;
    Ok(Solid { sdf, file_warnings })
}

fn sampled(
    solid: &MeshSdf,
    resolution: u32,
    place: &Path,
    control: &Control,
) -> Result<SampledGrid, MeshFileError> {
    let grid = solid.sample_with_control(resolution, control);
    grid.map_err(|source| match source {
        MeshReadError::Cancelled => source.into(),
        source => MeshFileError::Empty {
            path: place.into(),
            source,
        },
    })
}

/// Reads the grid of distances in a file.
fn grid_of(bytes: &[u8], place: &Path) -> Result<SampledGrid, MeshReadError> {
    let grid = SampledGrid::from_bytes(bytes).filter(|grid| !grid.has_heights());
    grid.ok_or_else(|| MeshReadError::Damaged {
        path: place.into(),
        kind: "grid",
        reason: "not a grid of distances".into(),
    })
}

/// Wraps a grid that is not a mesh: it has no triangles.
fn of_grid(path: &str, resolution: u32, grid: SampledGrid) -> LoadedMesh {
    LoadedMesh {
        path: path.to_owned(),
        resolution,
        grid: Arc::new(grid),
        triangles: 0,
        repairs: RepairReport::default(),
        file_warnings: Vec::new(),
        from_cache: false,
    }
}

fn load(
    path: &str,
    place: &Path,
    resolution: u32,
    solids: &mut HashMap<PathBuf, Solid>,
    control: &Control,
) -> Result<LoadedMesh, MeshFileError> {
    #[cfg(feature = "volume-files")]
    if crate::is_volume_file(place) {
        let volume = crate::read_volume(place, &Default::default())?;
        return Ok(of_grid(path, resolution, volume.grid));
    }
    if is_grid(path) {
        let grid = grid_of(&argil_mesh::bytes(place)?, place)?;
        return Ok(of_grid(path, resolution, grid));
    }
    if is_image(path) {
        let grid = heights(&argil_mesh::bytes(place)?, resolution, place)?;
        return Ok(of_grid(path, resolution, grid));
    }
    let source = MeshSource::open(place)?;
    #[cfg(feature = "mesh-files")]
    let kept = mesh_cache::place(&source, resolution);
    let done = |grid, facts: MeshFacts, was_kept| LoadedMesh {
        path: path.to_owned(),
        resolution,
        grid: Arc::new(grid),
        triangles: facts.triangles,
        repairs: facts.repairs,
        file_warnings: facts.file_warnings,
        from_cache: was_kept,
    };
    #[cfg(feature = "mesh-files")]
    if let Some((grid, facts)) = kept.as_deref().and_then(mesh_cache::read) {
        return Ok(done(grid, facts, true));
    }
    if !solids.contains_key(place) {
        solids.insert(place.into(), solid_of(&source, place)?);
    }
    let solid = &solids[place];
    let grid = sampled(&solid.sdf, resolution, place, control)?;
    let facts = MeshFacts {
        triangles: solid.sdf.triangles() as u64,
        repairs: *solid.sdf.repairs(),
        file_warnings: solid.file_warnings.clone(),
    };
    #[cfg(feature = "mesh-files")]
    if let Some(kept) = kept {
        // A cache that cannot be written costs time, and nothing else.
        let _ = mesh_cache::write(&kept, &grid, &facts);
    }
    Ok(done(grid, facts, false))
}
