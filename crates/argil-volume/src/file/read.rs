//! Reads volume files.

use super::format::{MAGIC, Section, VolumeError};
use super::meshes::{StoredMesh, meshes_of};
use super::reader::FileReader;
use super::write::{DESCRIPTION_WORDS, DESCRIPTION_WORDS_1};
use crate::representation::FromFileError;
use crate::{Band, Encoding, SampleFormat, Volume, VoxelGrid};
use glam::{UVec3, Vec3};
use memmap2::MmapMut;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// The contents of a volume file.
///
/// [`VolumeFile::open`] reads one from a file.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{Dense, Encoding, Volume, VolumeFile, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 32)?;
/// let volume = Volume::from(Dense::bake(&program, grid, Encoding::default(), false));
/// let path = std::env::temp_dir().join(format!("argil-example-{}.argil", std::process::id()));
/// volume.write("", &[], std::fs::File::create(&path)?)?;
/// assert_eq!(VolumeFile::open(&path)?.volume, volume);
/// std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeFile {
    /// The samples.
    pub volume: Volume,
    /// The scene that was sampled, as JSON text. May be empty.
    pub scene_json: String,
    /// The meshes of the scene. Files of version 1 have none.
    pub meshes: Vec<StoredMesh<'static>>,
}

impl VolumeFile {
    /// Whether a file begins as volume files do.
    pub fn is_volume_file(path: &Path) -> bool {
        // A pipe can be read only once.
        if !std::fs::metadata(path).is_ok_and(|m| m.is_file()) {
            return false;
        }
        let mut begin = [0; 8];
        let read = std::fs::File::open(path)
            .and_then(|mut f| std::io::Read::read_exact(&mut f, &mut begin));
        read.is_ok() && begin == MAGIC
    }

    /// Reads a file into memory. Samples stay where they were read. Other programs may change the file meanwhile or later.
    ///
    /// # Errors
    /// If the file cannot be read, is not a volume file, is of a newer version, or is damaged. The error names the
    /// section.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, VolumeError> {
        open(path.as_ref())
    }

    /// Reads a file's bytes. `path` appears only in messages.
    ///
    /// # Errors
    /// If the bytes are not a volume file, are of a newer version, or are damaged. The error names the section.
    pub fn from_bytes(bytes: &[u8], path: impl AsRef<Path>) -> Result<Self, VolumeError> {
        copied(bytes, path.as_ref())
    }
}

fn open(path: &Path) -> Result<VolumeFile, VolumeError> {
    let io = |source| VolumeError::Io {
        path: path.into(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(io(std::io::Error::other("is not a file")));
    }
    if !VolumeFile::is_volume_file(path) {
        return Err(VolumeError::NotAVolumeFile(path.into()));
    }
    let length =
        usize::try_from(metadata.len()).map_err(|_| io(std::io::ErrorKind::FileTooLarge.into()))?;
    let mut bytes = MmapMut::map_anon(length).map_err(io)?;
    file.read_exact(&mut bytes).map_err(io)?;
    read_bytes(bytes, path)
}

fn copied(bytes: &[u8], path: &Path) -> Result<VolumeFile, VolumeError> {
    if bytes.is_empty() {
        return Err(VolumeError::NotAVolumeFile(path.into()));
    }
    let map = MmapMut::map_anon(bytes.len());
    let mut map = map.map_err(|source| VolumeError::Io {
        path: path.into(),
        source,
    })?;
    map.copy_from_slice(bytes);
    read_bytes(map, path)
}

/// Reads bytes that nothing else can change.
fn read_bytes(bytes: MmapMut, path: &Path) -> Result<VolumeFile, VolumeError> {
    let bytes = bytes.make_read_only().map_err(|source| VolumeError::Io {
        path: path.into(),
        source,
    })?;
    read(FileReader::new(Arc::new(bytes), path)?)
}

fn read(file: FileReader<'_>) -> Result<VolumeFile, VolumeError> {
    let about = Section::Description;
    let mut words = file.words(about)?;
    if file.version == 1 && words.len() == DESCRIPTION_WORDS_1 {
        words.extend([0, 0, 0, 1]);
    }
    let Ok(words) = <[u32; DESCRIPTION_WORDS]>::try_from(words) else {
        return Err(file.fault(about, "unexpected length"));
    };
    let [
        kind,
        bits,
        range,
        x,
        y,
        z,
        voxel,
        nx,
        ny,
        nz,
        levels,
        brick,
        depth,
        first_x,
        first_y,
        first_z,
        is_cut,
    ] = words;
    let bits = match bits {
        8 => SampleFormat::Snorm8,
        16 => SampleFormat::Snorm16,
        _ => return Err(file.fault(about, "distances of neither 8 nor 16 bits")),
    };
    let range = f32::from_bits(range);
    let voxel_grid = VoxelGrid {
        corner: Vec3::from_array([x, y, z].map(f32::from_bits)),
        voxel_size: f32::from_bits(voxel),
        begin: UVec3::new(first_x, first_y, first_z).as_ivec3(),
        size: UVec3::new(nx, ny, nz),
        is_clipped: is_cut != 0,
    };
    let ends_in_range = (0..3).all(|axis| {
        let (first, count) = (voxel_grid.begin[axis], voxel_grid.size[axis]);
        i64::from(first) + i64::from(count) <= i64::from(i32::MAX)
    });
    let is_positive = |v: f32| v.is_finite() && v > 0.0;
    let is_sane = is_positive(range)
        && range <= 1e6
        && is_positive(voxel_grid.voxel_size)
        && ends_in_range
        && voxel_grid.aabb().is_finite()
        && voxel_grid.size.min_element() >= 1;
    if !is_sane {
        return Err(file.fault(about, "invalid grid dimensions"));
    }
    let encoding = Encoding {
        format: bits,
        band: Band::Voxels(range),
    };
    let own = [levels, brick, depth];
    let volume = Volume::from_file(kind, (&file, file.version), voxel_grid, encoding, own);
    let volume = volume.map_err(|error| match error {
        FromFileError::Kind => file.fault(about, "a volume of an unknown kind"),
        FromFileError::Lattice => file.fault(about, "invalid grid dimensions"),
        FromFileError::Content(error) => error,
    })?;
    let Ok(scene_json) = String::from_utf8(file.bytes(Section::Scene)?.to_vec()) else {
        return Err(file.fault(Section::Scene, "it is not text"));
    };
    let has_meshes = file.sections.iter().any(|(s, _)| *s == Section::Meshes);
    let meshes = match has_meshes {
        true => meshes_of(file.bytes(Section::Meshes)?)
            .ok_or_else(|| file.fault(Section::Meshes, "invalid lengths"))?,
        false => Vec::new(),
    };
    Ok(VolumeFile {
        volume,
        scene_json,
        meshes,
    })
}
