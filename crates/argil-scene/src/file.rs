//! Scenes as JSON.
//!
//! *Theory.* Groups nest, thousands of levels where a tree was imported, so the document's skeleton is read token by
//! token with a stack on the heap. What hangs on it (shapes, modifiers, materials) is small and shallow; each such part
//! is copied out, at most [`MAX_PART_BYTES`] of it, and read by serde.
//!
//! *Practice.* A file that holds a scene is read as a whole, by all cores. Where that fails it is streamed: garbage is refused
//! at its first wrong byte, and every error knows its place: the reader's position, or, for a value that can be read but
//! not used, the place that another pass finds by the value's path.

mod document;
mod error;
mod explain;
mod quick;
pub(crate) mod read;
#[cfg(feature = "schema")]
mod schema;
mod tokens;
mod write;

use crate::{SampledGrid, Scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

pub(crate) use document::Item;
use error::MAX_QUICK_BYTES;
pub use error::{FORMAT_VERSION, FileError};
#[cfg(feature = "schema")]
pub use schema::schema;

impl Scene {
    /// Read a scene file.
    ///
    /// # Errors
    /// If the file cannot be read, is not valid JSON, or holds an invalid value. The error gives the line, the column and the path in the document.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::open_file(path.as_ref())
    }

    fn open_file(path: &Path) -> Result<Self, FileError> {
        let io = |source| FileError::Io {
            path: path.into(),
            source,
        };
        let open = || -> Result<tokens::Source<'_>, FileError> {
            Ok(Box::new(std::fs::File::open(path).map_err(io)?))
        };
        let about = std::fs::metadata(path).map_err(io)?;
        if about.is_dir() {
            return Err(io(std::io::Error::other("is a folder, not a scene file")));
        }
        // What is no regular file may be endless, and can be read once.
        if about.is_file() && about.len() <= MAX_QUICK_BYTES {
            let text = std::fs::read(path).map_err(io)?;
            if let Some(scene) = quick::read(&text) {
                return Ok(scene);
            }
        }
        read::read(path, open()?, &open)
    }

    /// Read a scene from text. `path` stands in messages only.
    ///
    /// # Errors
    /// If the text is not valid JSON or holds an invalid value. The error gives the line, the column and the path in the document.
    pub fn from_json(json: &str, path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::read_text(json.as_bytes(), path.as_ref())
    }

    fn read_text(json: &[u8], path: &Path) -> Result<Self, FileError> {
        if let Some(scene) = quick::read(json) {
            return Ok(scene);
        }
        read::read(path, Box::new(json), &|| Ok(Box::new(json)))
    }

    /// The scene as the text of a file.
    pub fn to_json(&self) -> String {
        let mut text = Vec::new();
        // A vector takes every byte, and every string here is UTF-8.
        let _ = write::write(self, &mut text);
        String::from_utf8_lossy(&text).into_owned()
    }

    /// Write a scene file, beside its place and then renamed into it, so that a failure leaves the old file whole. What is [sampled](crate::Shape::sampled) is written to files of its own
    /// beside it.
    ///
    /// # Errors
    /// If the file cannot be written. The old file stays unchanged.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        let path = path.as_ref();
        let fault = |path: &Path, source| FileError::Io {
            path: path.into(),
            source,
        };
        let mut grids: BTreeMap<&str, &SampledGrid> = BTreeMap::new();
        for (name, grid) in self.sampled() {
            let place = path.with_file_name("").join(name);
            let other = grids.insert(name, grid);
            if other.is_some_and(|other| !std::ptr::eq(other, grid) && other != grid) {
                let reason = "two brushes have this name, of different distances: give one another";
                return Err(fault(&place, std::io::Error::other(reason)));
            }
        }
        for (name, grid) in grids {
            let place = path.with_file_name("").join(name);
            save_grid(&place, name, grid).map_err(|source| fault(&place, source))?;
        }
        write_atomically(path, |out| write::write(self, out)).map_err(|source| fault(path, source))
    }
}

/// Write sampled distances, if they are not there already: into the scene's own folder, never elsewhere.
fn save_grid(place: &Path, name: &str, grid: &SampledGrid) -> std::io::Result<()> {
    let is_name = Path::new(name).file_name() == Some(std::ffi::OsStr::new(name));
    if !is_name {
        if place.exists() {
            return Ok(());
        }
        let reason =
            "sampled distances are written beside the scene: their name may have no folder";
        return Err(std::io::Error::other(reason));
    }
    let bytes = grid.to_bytes();
    if std::fs::read(place).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    write_atomically(place, |out| std::io::Write::write_all(out, &bytes))
}

/// Write a file beside its place and rename it into it, so that whoever looks finds the old file or the new one, whole. In a
/// browser there are no files, and that is the error.
///
/// # Errors
/// If a folder or the file cannot be written, or `write` fails. The old file stays unchanged.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut std::io::BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    #[cfg(target_arch = "wasm32")]
    {
        let mut file = std::fs::File::create(path)?;
        write(&mut std::io::BufWriter::new(&mut file))
    }
    #[cfg(not(target_arch = "wasm32"))]
    replace(path, write)
}

/// How old a file must be that was being written before it is taken for one whose program was killed.
#[cfg(not(target_arch = "wasm32"))]
const ABANDONED_AFTER: std::time::Duration = std::time::Duration::from_secs(24 * 3600);

/// Remove what programs that were killed have left in a folder.
#[cfg(not(target_arch = "wasm32"))]
fn remove_abandoned(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_own = name
            .to_str()
            .and_then(|name| name.strip_prefix(".argil-"))
            .is_some_and(|rest| rest.len() == 6 && rest.chars().all(char::is_alphanumeric));
        let age = entry.metadata().ok().filter(std::fs::Metadata::is_file);
        let age = age.and_then(|about| about.modified().ok()?.elapsed().ok());
        if is_own && age.is_some_and(|age| age > ABANDONED_AFTER) {
            // If it cannot be, it stays.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn replace(
    path: &Path,
    write: impl FnOnce(&mut std::io::BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    remove_abandoned(folder);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".argil-");
    // Like any file that a program makes: readable by others as far as the user's mask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let begun = TempFile::begin(|| builder.tempfile_in(folder));
    // The name that it would have had until then says nothing to a user.
    let (mut file, unfinished) = begun.map_err(|error| {
        let reason = format!(
            "no file can be made in {}: {}",
            folder.display(),
            reason_of(error.kind())
        );
        std::io::Error::new(error.kind(), reason)
    })?;
    let mut out = std::io::BufWriter::new(file.as_file_mut());
    write(&mut out)?;
    std::io::Write::flush(&mut out)?;
    drop(out);
    // A name must not come to stand for what the disk does not hold yet.
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    drop(unfinished);
    Ok(())
}

/// Why the system refuses something, without a place.
#[cfg(not(target_arch = "wasm32"))]
fn reason_of(kind: std::io::ErrorKind) -> String {
    match kind {
        std::io::ErrorKind::NotFound => "there is no such folder".into(),
        std::io::ErrorKind::PermissionDenied => "the folder cannot be written to".into(),
        other => other.to_string(),
    }
}

/// Files that are being written beside their places.
static TEMP_FILES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Remove what [`write_atomically`] has not finished, and let it begin nothing more: for programs that are told to stop in the middle of
/// it, and end now.
pub fn remove_temp_files() {
    let all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
    for path in all.iter() {
        // It may have been renamed this very moment.
        let _ = std::fs::remove_file(path);
    }
    // Whoever would begin another waits until the program has ended.
    std::mem::forget(all);
}

#[cfg(not(target_arch = "wasm32"))]
struct TempFile(PathBuf);

#[cfg(not(target_arch = "wasm32"))]
impl TempFile {
    /// Make a file, and take note of it before anybody can be told to stop.
    fn begin(
        make: impl FnOnce() -> std::io::Result<tempfile::NamedTempFile>,
    ) -> std::io::Result<(tempfile::NamedTempFile, Self)> {
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        let file = make()?;
        all.push(file.path().into());
        let own = Self(file.path().into());
        Ok((file, own))
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl Drop for TempFile {
    fn drop(&mut self) {
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|path| *path != self.0);
    }
}
