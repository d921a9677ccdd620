//! A mesh file, and the files that it names.

use super::address::decoded;
use super::error::{MeshReadError, ReadFault};
use super::file::MeshFile;
use super::parse::parse;
use crate::MeshFormat;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Maximum bytes of a mesh file.
const MAX_BYTES: u64 = 4 << 30;

/// A mesh file in memory, with the files that it names: a `.gltf` file has its numbers in others.
///
/// ```
/// # use argil_mesh::{MeshFormat, MeshSource};
/// let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let source = MeshSource::new(&text[..], MeshFormat::Obj, "a.obj".as_ref());
/// assert_eq!(source.read()?.mesh.triangles.len(), 1);
/// # Ok::<(), argil_mesh::MeshReadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MeshSource<'a> {
    path: &'a Path,
    format: MeshFormat,
    bytes: Cow<'a, [u8]>,
    /// Other files, by their addresses.
    files: Vec<(String, Vec<u8>)>,
}

impl<'a> MeshSource<'a> {
    /// Wraps bytes of a file that names no others. `path` appears only in messages.
    pub fn new(bytes: impl Into<Cow<'a, [u8]>>, format: MeshFormat, path: &'a Path) -> Self {
        Self {
            path,
            format,
            bytes: bytes.into(),
            files: Vec::new(),
        }
    }

    /// Reads a file's bytes, and the bytes of the files that it names. They must lie in its folder.
    ///
    /// # Errors
    /// If a file cannot be read, or lies outside the folder.
    pub fn open(path: &'a Path) -> Result<Self, MeshReadError> {
        let format =
            MeshFormat::from_path(path).ok_or_else(|| MeshReadError::UnknownFormat(path.into()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let find = |name: &str| match path_within(folder, Path::new(name)) {
            Some(place) => bytes(&place),
            None => Err(MeshReadError::Unsupported {
                path: path.into(),
                what: format!(
                    "the file \"{name}\", which it names, is outside its folder: move it there"
                ),
            }),
        };
        Self::new(bytes(path)?, format, path).with_files(find)
    }

    /// Adds the files that the file names, by their paths relative to its folder.
    ///
    /// # Errors
    /// If the names cannot be read, or `find` fails.
    pub fn with_files(
        mut self,
        find: impl Fn(&str) -> Result<Vec<u8>, MeshReadError>,
    ) -> Result<Self, MeshReadError> {
        for uri in self.named().map_err(|fault| self.error(fault))? {
            let file = find(&decoded(&uri))?;
            self.files.push((uri, file));
        }
        Ok(self)
    }

    #[cfg(feature = "files")]
    fn named(&self) -> Result<Vec<String>, ReadFault> {
        match self.format {
            MeshFormat::Glb | MeshFormat::Gltf => super::gltf::files(&self.bytes),
            _ => Ok(Vec::new()),
        }
    }

    #[cfg(not(feature = "files"))]
    fn named(&self) -> Result<Vec<String>, ReadFault> {
        Ok(Vec::new())
    }

    /// Returns the format.
    pub fn format(&self) -> MeshFormat {
        self.format
    }

    /// Iterates over the bytes of all files.
    pub fn parts(&self) -> impl Iterator<Item = &[u8]> {
        let files = self.files.iter().map(|(_, bytes)| &bytes[..]);
        std::iter::once(&self.bytes[..]).chain(files)
    }

    /// Reads all triangles.
    ///
    /// # Errors
    /// If the bytes are not a mesh of this format.
    pub fn read(&self) -> Result<MeshFile, MeshReadError> {
        parse(&self.bytes, self.format, &self.files).map_err(|fault| self.error(fault))
    }

    /// Returns a fault with the file's path.
    fn error(&self, fault: ReadFault) -> MeshReadError {
        let path = PathBuf::from(self.path);
        match fault {
            ReadFault::Damaged(reason) => MeshReadError::Damaged {
                path,
                kind: self.format.name(),
                reason,
            },
            ReadFault::Unsupported(what) => MeshReadError::Unsupported { path, what },
            ReadFault::TooLarge(what) => MeshReadError::TooLarge { path, what },
        }
    }
}

/// Reads a mesh file's bytes.
///
/// # Errors
/// If the file cannot be read, or is too large.
pub fn bytes(path: &Path) -> Result<Vec<u8>, MeshReadError> {
    let io = |source| MeshReadError::Io {
        path: path.into(),
        source,
    };
    let about = std::fs::metadata(path).map_err(io)?;
    if about.is_dir() {
        return Err(io(std::io::Error::other("is a folder, not a mesh file")));
    }
    // A pipe that nobody writes to would never end.
    if !about.is_file() {
        return Err(io(std::io::Error::other("is not a regular file")));
    }
    if about.len() > MAX_BYTES {
        let what = format!("{} bytes, and {MAX_BYTES} can be read", about.len());
        return Err(MeshReadError::TooLarge {
            path: path.into(),
            what,
        });
    }
    std::fs::read(path).map_err(io)
}

/// Returns the place of a file in a folder, or `None` if it is outside, even by a link. A file that is missing is reported
/// when it is read.
pub fn path_within(folder: &Path, path: &Path) -> Option<PathBuf> {
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if !path.components().all(is_plain) {
        return None;
    }
    let place = folder.join(path);
    match (place.canonicalize(), folder.canonicalize()) {
        (Ok(place), Ok(folder)) if !place.starts_with(&folder) => None,
        _ => Some(place),
    }
}
