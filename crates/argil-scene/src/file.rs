//! Scenes as JSON files.
//!
//! *Theory.* Groups nest, thousands of levels deep in imported trees. So the document's skeleton is read token by
//! token, with a stack on the heap. Shapes, modifiers and materials are small and shallow: each is copied out, up
//! to [`error::MAX_PART_BYTES`], and read by serde.
//!
//! *Practice.* All cores first read the whole file. If that fails, the file is streamed: it is refused at its first
//! wrong byte. Every error has a place. If a value can be read but not used, another pass finds the place from the
//! value's path.

mod document;
mod error;
mod explain;
mod quick;
pub(crate) mod read;
#[cfg(feature = "schema")]
mod schema;
mod temp_folder;
mod tokens;
mod write;

use crate::{NodeTree, SampledGrid, Scene};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

pub(crate) use document::Item;
use error::MAX_QUICK_BYTES;
pub use error::{FORMAT_VERSION, FileError};
pub(crate) use explain::explain_line;
#[cfg(feature = "schema")]
pub use schema::schema;
pub use temp_folder::TempFolder;

/// Reads a brush or a group as a scene file has it, however deep it nests. Materials are not checked.
pub(crate) fn read_tree(text: &str) -> Option<NodeTree> {
    let text = format!("{{\"argil\": {FORMAT_VERSION}, \"brushes\": [{text}]}}");
    let scene = read::unchecked(text.as_bytes())?;
    match scene.node(Scene::ROOT).children() {
        [one] => Some(scene.subtree(*one)),
        _ => None,
    }
}

/// Returns a brush or a group as a scene file has it, on one line, however deep it nests.
///
/// # Panics
/// Never: every entry is JSON.
pub(crate) fn tree_text(tree: &NodeTree) -> Box<RawValue> {
    let mut scene = Scene::new();
    let mut open = vec![(Scene::ROOT, tree)];
    while let Some((parent, tree)) = open.pop() {
        let node = scene.append(parent, tree.desc.clone());
        open.extend(tree.children.iter().rev().map(|child| (node, child)));
    }
    let mut text = Vec::new();
    // A vector takes every byte.
    let _ = write::write_items(&scene, &mut text);
    // Strings have no line ends of their own.
    let text = String::from_utf8_lossy(&text).replace('\n', "");
    RawValue::from_string(text.trim().to_owned()).expect("an entry is JSON")
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// If the file cannot be read, is not valid JSON, or holds a value out of range. The error gives the line, the
    /// column and the path in the document.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::open_file(path.as_ref())
    }

    fn open_file(path: &Path) -> Result<Self, FileError> {
        let io = |source| FileError::Io {
            path: path.into(),
            source,
        };
        let open = || -> Result<tokens::ByteSource<'_>, FileError> {
            Ok(Box::new(std::fs::File::open(path).map_err(io)?))
        };
        let about = std::fs::metadata(path).map_err(io)?;
        if about.is_dir() {
            return Err(io(std::io::Error::other("is a folder, not a scene file")));
        }
        // A pipe may be endless, and can be read only once.
        if about.is_file() && about.len() <= MAX_QUICK_BYTES {
            let text = std::fs::read(path).map_err(io)?;
            if let Some(scene) = quick::read(&text) {
                return Ok(scene);
            }
        }
        read::read(path, open()?, &open)
    }

    /// Reads a scene from JSON text. `path` appears only in messages.
    ///
    /// # Errors
    /// If the text is not valid JSON, or holds a value out of range. The error gives the line, the column and the
    /// path in the document.
    pub fn from_json(json: &str, path: impl AsRef<Path>) -> Result<Self, FileError> {
        Self::read_text(json.as_bytes(), path.as_ref())
    }

    fn read_text(json: &[u8], path: &Path) -> Result<Self, FileError> {
        if let Some(scene) = quick::read(json) {
            return Ok(scene);
        }
        read::read(path, Box::new(json), &|| Ok(Box::new(json)))
    }

    /// Returns the scene as JSON text.
    pub fn to_json(&self) -> String {
        let mut text = Vec::new();
        // A vector takes every byte, and every string here is UTF-8.
        let _ = write::write(self, &mut text);
        String::from_utf8_lossy(&text).into_owned()
    }

    /// Writes a scene file, atomically. [Sampled](crate::Shape::sampled) shapes
    /// go to files of their own next to it.
    ///
    /// # Errors
    /// If a file cannot be written. The old file stays unchanged.
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

/// Writes sampled distances into the scene's folder, unless they are there already.
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

/// Writes a file under a temporary name and renames it. Readers find either the old file or the new one, complete.
/// A browser has no files, which is an error.
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

/// Writes a new file, which appears as a whole. A file of no bytes is replaced.
///
/// # Errors
/// If there is a file with something in it, or it cannot be written.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if std::fs::metadata(path).is_ok_and(|about| about.is_file() && about.len() == 0) {
        std::fs::remove_file(path)?;
    }
    let (mut file, unfinished) = begin_beside(path)?;
    std::io::Write::write_all(&mut file, bytes)?;
    file.as_file().sync_all()?;
    file.persist_noclobber(path).map_err(|e| e.error)?;
    drop(unfinished);
    Ok(())
}

#[cfg(target_arch = "wasm32")]
pub(crate) fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    std::io::Write::write_all(&mut std::fs::File::create_new(path)?, bytes)
}

/// A temporary file is this old before another program looks whether its own is alive: it is locked by then.
const ABANDONED_AFTER: std::time::Duration = std::time::Duration::from_secs(60);

/// Removes temporary files and folders that killed programs left in a folder. Those of programs that are alive are locked.
pub fn remove_abandoned_files(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_own = name
            .to_str()
            .and_then(|name| name.strip_prefix(TEMP_PREFIX))
            .is_some_and(|rest| rest.len() == 6 && rest.chars().all(char::is_alphanumeric));
        let about = entry.metadata().ok().filter(|_| is_own);
        let age = about.and_then(|about| about.modified().ok()?.elapsed().ok());
        if age.is_none_or(|age| age < ABANDONED_AFTER) {
            continue;
        }
        let path = entry.path();
        // What cannot be locked or removed stays.
        let is_left = std::fs::File::open(&path).is_ok_and(|file| file.try_lock().is_ok());
        if is_left {
            let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
        }
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn replace(
    path: &Path,
    write: impl FnOnce(&mut std::io::BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let (mut file, unfinished) = begin_beside(path)?;
    let mut out = std::io::BufWriter::new(file.as_file_mut());
    write(&mut out)?;
    std::io::Write::flush(&mut out)?;
    drop(out);
    // Write the contents to disk before the name refers to them.
    file.as_file().sync_all()?;
    file.persist(path).map_err(|e| e.error)?;
    drop(unfinished);
    Ok(())
}

/// Creates a temporary file in the folder of another one.
#[cfg(not(target_arch = "wasm32"))]
fn begin_beside(path: &Path) -> std::io::Result<(tempfile::NamedTempFile, TempFile)> {
    let folder = folder_of(path);
    remove_abandoned_files(folder);
    let begun = TempFile::begin(|| temp_builder(0o666).tempfile_in(folder));
    // The temporary name would not help a user.
    begun.map_err(|error| not_created(&error, folder))
}

/// Returns a builder of temporary files or folders. Others can read them as far as the user's mask allows, as what is new in general.
#[cfg(not(target_arch = "wasm32"))]
fn temp_builder(mode: u32) -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMP_PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
    #[cfg(not(unix))]
    let _ = mode;
    builder
}

/// Returns the reason why nothing can be created in a folder.
#[cfg(not(target_arch = "wasm32"))]
fn not_created(error: &std::io::Error, folder: &Path) -> std::io::Error {
    let reason = format!(
        "no file can be created in {}: {}: choose another folder",
        folder.display(),
        reason_of(error.kind())
    );
    std::io::Error::new(error.kind(), reason)
}

/// Describes a system error, without a path.
#[cfg(not(target_arch = "wasm32"))]
fn reason_of(kind: std::io::ErrorKind) -> String {
    match kind {
        std::io::ErrorKind::NotFound => "there is no such folder".into(),
        std::io::ErrorKind::PermissionDenied => "the folder cannot be written to".into(),
        other => other.to_string(),
    }
}

/// Names of temporary files and folders begin so, and end in six letters or digits. No user's file has such a name.
#[doc(hidden)]
pub const TEMP_PREFIX: &str = ".argil-unfinished-";

/// Temporary files that are being written.
static TEMP_FILES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes unfinished files of [`write_atomically`], and prevents new ones. A program calls this when it must end
/// at once.
pub fn remove_temp_files() {
    let all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
    for path in all.iter() {
        // It may have been renamed just now. Other threads may still write into a folder.
        for _ in 0..20 {
            let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir_all(path));
            if !path.exists() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
    // Writers wait on this lock until the program ends.
    std::mem::forget(all);
}

/// Returns the folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

#[cfg(not(target_arch = "wasm32"))]
struct TempFile(PathBuf);

#[cfg(not(target_arch = "wasm32"))]
impl TempFile {
    /// Creates a temporary file and registers it.
    fn begin(
        make: impl FnOnce() -> std::io::Result<tempfile::NamedTempFile>,
    ) -> std::io::Result<(tempfile::NamedTempFile, Self)> {
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        let file = make()?;
        // Systems that lock no files keep abandoned ones.
        let _ = file.as_file().try_lock();
        all.push(file.path().into());
        let guard = Self(file.path().into());
        Ok((file, guard))
    }
}

#[cfg(not(target_arch = "wasm32"))]
impl Drop for TempFile {
    fn drop(&mut self) {
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|path| *path != self.0);
    }
}
