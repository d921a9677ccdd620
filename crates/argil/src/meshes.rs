//! The meshes that scenes name: found, checked, sampled, and kept for the next time.

use argil_math::Aabb;
use argil_mesh::{Format, MeshInput, Repairs, Solid, from_bytes};
use argil_scene::{SAMPLED_HEADER, SampledGrid, Scene};
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// What kept samples begin with; another number for another way of sampling.
const MAGIC: [u8; 8] = *b"argilm03";

/// Words of a kept file before the samples: the box.
const HEAD: usize = 6;

/// A mesh that a scene names, loaded.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// As the scene names it.
    pub path: String,
    /// Samples along the longest side.
    pub resolution: u32,
    /// Its distances.
    pub grid: Arc<SampledGrid>,
    /// Triangles, those that close holes included.
    pub triangles: u64,
    /// What was done to them.
    pub repairs: Repairs,
    /// Whether its samples were kept from another time.
    pub was_kept: bool,
}

/// Why a mesh that a scene names is not loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// Its file cannot be read.
    #[error(transparent)]
    Input(#[from] MeshInput),
    /// The file holds no solid.
    #[error("{}", path.display())]
    Empty {
        /// Which.
        path: PathBuf,
        /// Why.
        source: MeshInput,
    },
    /// It is elsewhere.
    #[error(
        "the mesh \"{path}\" is not in the folder of the scene that names it, {}: put it there, or allow files outside (--allow-outside)",
        folder.display()
    )]
    Outside {
        /// As the scene names it.
        path: String,
        /// Where the scene is.
        folder: PathBuf,
    },
}

/// Load the meshes that a scene names and that are not loaded yet, from the folder of its file; with `outside`, from anywhere
/// that their paths lead to. What was sampled is kept in the user's cache folder, by the hash of the file's bytes.
///
/// # Errors
/// If a file is elsewhere, cannot be read, or holds no triangles.
pub fn load_meshes(
    scene: &mut Scene,
    folder: &Path,
    outside: bool,
) -> Result<Vec<LoadedMesh>, MeshFileError> {
    let mut loaded = Vec::new();
    // The same file at another resolution is read once.
    let mut solids: HashMap<PathBuf, Solid> = HashMap::new();
    for (path, resolution) in scene.missing_meshes() {
        let place = place_of(&path, folder, outside)?;
        let mesh = load(&path, &place, resolution, &mut solids)?;
        scene.set_mesh(path, resolution, mesh.grid.clone());
        loaded.push(mesh);
    }
    Ok(loaded)
}

/// The same of files whose bytes are at hand, found by their names without folders; those that are not there stay missing.
/// Nothing is kept.
///
/// # Errors
/// If a file holds no mesh.
pub fn load_meshes_of(
    scene: &mut Scene,
    files: &[(String, Vec<u8>)],
) -> Result<Vec<LoadedMesh>, MeshFileError> {
    let mut loaded = Vec::new();
    for (path, resolution) in scene.missing_meshes() {
        let name = Path::new(&path).file_name().unwrap_or_default();
        let Some((own, bytes)) = files.iter().find(|(own, _)| name == own.as_str()) else {
            continue;
        };
        let place = Path::new(own);
        let format = Format::of(place).ok_or_else(|| MeshInput::Unknown(place.into()))?;
        let solid = solid_of(bytes, format, place)?;
        let mesh = LoadedMesh {
            grid: Arc::new(sampled(&solid, resolution, place)?),
            resolution,
            triangles: solid.triangles() as u64,
            repairs: *solid.repairs(),
            was_kept: false,
            path,
        };
        scene.set_mesh(mesh.path.clone(), resolution, mesh.grid.clone());
        loaded.push(mesh);
    }
    Ok(loaded)
}

fn solid_of(bytes: &[u8], format: Format, place: &Path) -> Result<Solid, MeshFileError> {
    let mesh = from_bytes(bytes, format, place)?;
    Solid::new(&mesh).map_err(|source| MeshFileError::Empty {
        path: place.into(),
        source,
    })
}

fn sampled(solid: &Solid, resolution: u32, place: &Path) -> Result<SampledGrid, MeshFileError> {
    solid
        .sample(resolution)
        .map_err(|source| MeshFileError::Empty {
            path: place.into(),
            source,
        })
}

/// Where a mesh's file is.
fn place_of(path: &str, folder: &Path, outside: bool) -> Result<PathBuf, MeshFileError> {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let place = folder.join(path);
    if outside {
        return Ok(place);
    }
    let refuse = || MeshFileError::Outside {
        path: path.to_owned(),
        folder: folder.into(),
    };
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if !Path::new(path).components().all(plain) {
        return Err(refuse());
    }
    // A link may lead out, too. What is not there is told when it is read.
    match (place.canonicalize(), folder.canonicalize()) {
        (Ok(place), Ok(folder)) if !place.starts_with(&folder) => Err(refuse()),
        _ => Ok(place),
    }
}

fn load(
    path: &str,
    place: &Path,
    resolution: u32,
    solids: &mut HashMap<PathBuf, Solid>,
) -> Result<LoadedMesh, MeshFileError> {
    let format = Format::of(place).ok_or_else(|| MeshInput::Unknown(place.into()))?;
    let bytes = argil_mesh::bytes(place)?;
    let hash = blake3::hash(&bytes).to_hex();
    let kept =
        cache_folder().map(|f| f.join(format!("{hash}-{format:?}-{resolution}.{MAGIC_TEXT}")));
    let done = |grid, (triangles, repairs), was_kept| LoadedMesh {
        path: path.to_owned(),
        resolution,
        grid: Arc::new(grid),
        triangles,
        repairs,
        was_kept,
    };
    if let Some((grid, counts)) = kept.as_deref().and_then(read_kept) {
        return Ok(done(grid, counts, true));
    }
    if !solids.contains_key(place) {
        solids.insert(place.into(), solid_of(&bytes, format, place)?);
    }
    let solid = &solids[place];
    let grid = sampled(solid, resolution, place)?;
    let counts = (solid.triangles() as u64, *solid.repairs());
    if let Some(kept) = kept {
        // A cache that cannot be written costs time, nothing else.
        let _ = write_kept(&kept, &grid, counts);
    }
    Ok(done(grid, counts, false))
}

/// The ending of kept files' names.
const MAGIC_TEXT: &str = "grid03";

fn cache_folder() -> Option<PathBuf> {
    #[cfg(target_arch = "wasm32")]
    return None;
    #[cfg(not(target_arch = "wasm32"))]
    Some(dirs::cache_dir()?.join("argil").join("meshes"))
}

fn write_kept(
    path: &Path,
    grid: &SampledGrid,
    (triangles, repairs): (u64, Repairs),
) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut words: Vec<f32> = Vec::with_capacity(HEAD + grid.words().len());
    let solid = grid.solid();
    words.extend(solid.min.to_array());
    words.extend(solid.max.to_array());
    words.extend_from_slice(grid.words());
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    let head = [&triangles.to_le_bytes(), bytemuck::bytes_of(&repairs)].concat();
    argil_scene::replace_file(path, |out| {
        use std::io::Write;
        out.write_all(&MAGIC)?;
        out.write_all(hash_of(&head, bytes).as_bytes())?;
        out.write_all(&head)?;
        out.write_all(bytes)
    })
}

/// Of what is kept besides the samples, and of those.
fn hash_of(head: &[u8], bytes: &[u8]) -> blake3::Hash {
    blake3::Hasher::new().update(head).update(bytes).finalize()
}

/// What was kept, if it is whole.
fn read_kept(path: &Path) -> Option<(SampledGrid, (u64, Repairs))> {
    let all = std::fs::read(path).ok()?;
    let (magic, rest) = all.split_at_checked(MAGIC.len())?;
    let (hash, rest) = rest.split_at_checked(32)?;
    let (head, bytes) = rest.split_at_checked(8 + size_of::<Repairs>())?;
    if magic != MAGIC || hash_of(head, bytes).as_bytes() != hash {
        return None;
    }
    let words: Vec<f32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|&b| f32::from_le_bytes(b))
        .collect();
    if words.len() < HEAD + SAMPLED_HEADER {
        return None;
    }
    let corner = |at: usize| glam::Vec3::from_slice(&words[at..]);
    let solid = Aabb::new(corner(0), corner(3));
    let (triangles, repairs) = head.split_first_chunk()?;
    let counts = (
        u64::from_le_bytes(*triangles),
        bytemuck::pod_read_unaligned(repairs),
    );
    Some((
        SampledGrid::from_words(words[HEAD..].to_vec(), solid)?,
        counts,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_lead_out_are_refused() {
        let here = tempfile::tempdir().expect("a folder");
        let inner = here.path().join("scene");
        std::fs::create_dir(&inner).expect("a folder");
        std::fs::write(here.path().join("secret.obj"), "").expect("a file");
        let refused = |path: &str| place_of(path, &inner, false).is_err();
        assert!(refused("../secret.obj") && refused("/etc/passwd.obj") && refused("a/../../b.obj"));
        assert!(!refused("a.obj") && !refused("sub/a.obj") && !refused("./a.obj"));
        assert!(place_of("../secret.obj", &inner, true).is_ok());
        #[cfg(unix)]
        {
            let link = inner.join("link.obj");
            std::os::unix::fs::symlink(here.path().join("secret.obj"), link).expect("a link");
            assert!(refused("link.obj"));
        }
    }

    #[test]
    fn what_was_kept_comes_back_whole_or_not_at_all() {
        let here = tempfile::tempdir().expect("a folder");
        let path = here.path().join("sub").join("kept");
        let ball = |points: &[glam::Vec3], out: &mut [f32]| {
            for (p, out) in points.iter().zip(out) {
                *out = p.length() - 0.5;
            }
        };
        let solid = Aabb::centered(glam::Vec3::splat(0.5));
        let corner = glam::Vec3::splat(-0.75);
        let grid = SampledGrid::sample(corner, 0.5, glam::UVec3::splat(3), solid, &ball);
        let repairs = Repairs {
            holes: 3,
            parts: 1,
            ..Repairs::default()
        };
        write_kept(&path, &grid, (77, repairs)).expect("a file");
        assert_eq!(read_kept(&path), Some((grid, (77, repairs))));
        let whole = std::fs::read(&path).expect("a file");
        for at in (0..whole.len()).step_by(whole.len() / 50) {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            std::fs::write(&path, &damaged).expect("a file");
            assert_eq!(read_kept(&path), None, "{at}");
            std::fs::write(&path, &whole[..at]).expect("a file");
            assert_eq!(read_kept(&path), None, "cut at {at}");
        }
    }
}
