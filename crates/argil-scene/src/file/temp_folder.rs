//! Folders that are made under a temporary name.

#[cfg(target_arch = "wasm32")]
use super::TEMP_PREFIX;
use super::{TEMP_FILES, folder_of, remove_abandoned_files};
#[cfg(not(target_arch = "wasm32"))]
use super::{not_created, temp_builder};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::PoisonError;

/// A new folder that is removed with all that it holds, unless it gets a name: see `remove_temp_files`.
#[derive(Debug)]
pub struct TempFolder {
    path: PathBuf,
    /// While it is locked, other programs leave the folder alone.
    _lock: Option<std::fs::File>,
}

impl TempFolder {
    /// Creates a folder beside a path, in which files are made that are to be there. Removes what killed programs left there.
    ///
    /// # Errors
    /// If it cannot be created. A browser has no folders.
    pub fn beside(path: &Path) -> std::io::Result<Self> {
        let folder = folder_of(path);
        remove_abandoned_files(folder);
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        #[cfg(not(target_arch = "wasm32"))]
        let temp = temp_builder(0o777).tempdir_in(folder);
        #[cfg(not(target_arch = "wasm32"))]
        let path = temp.map_err(|error| not_created(&error, folder))?.keep();
        #[cfg(target_arch = "wasm32")]
        let path = folder.join(TEMP_PREFIX);
        // Systems that lock no folders never remove abandoned ones.
        let lock = std::fs::File::open(&path)
            .ok()
            .filter(|file| file.try_lock().is_ok());
        all.push(path.clone());
        Ok(Self { path, _lock: lock })
    }

    /// Creates a folder as [`TempFolder::beside`] does, for an export to a folder. An older folder may be replaced only if it
    /// is empty, or if its file `mark` tells that Argil generated it, and it holds nothing else.
    ///
    /// # Errors
    /// If there is something else at the path, or the folder cannot be created.
    pub fn for_export(path: &Path, mark: &str) -> std::io::Result<Self> {
        let is_generated = || {
            let text = std::fs::read_to_string(path.join(mark)).unwrap_or_default();
            text.contains("\"generator\"") && text.contains("\"argil ")
        };
        let is_empty = || std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
        // A link without a target exists, too.
        if std::fs::symlink_metadata(path).is_ok() && !is_generated() && !is_empty() {
            let reason = format!(
                "it exists, and there is no {mark} of Argil in it: choose another name, or remove it first"
            );
            return Err(std::io::Error::other(reason));
        }
        if let Some(foreign) = foreign_file(path, mark) {
            let reason = format!(
                "it holds {}, which is no part of an export: move that away, or choose another name",
                foreign.display()
            );
            return Err(std::io::Error::other(reason));
        }
        Self::beside(path)
    }

    /// Returns the path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the folder a name, in place of an older folder.
    ///
    /// # Errors
    /// If that cannot be replaced. The older folder stays then.
    pub fn persist(self, path: &Path) -> std::io::Result<()> {
        if !path.exists() {
            return std::fs::rename(&self.path, path);
        }
        // What a killed program leaves there is removed later.
        let aside = Self::beside(path)?;
        let old = aside.path.join("old");
        std::fs::rename(path, &old)?;
        std::fs::rename(&self.path, path).inspect_err(|_| {
            let _ = std::fs::rename(&old, path);
        })
    }
}

impl Drop for TempFolder {
    fn drop(&mut self) {
        let mut all = TEMP_FILES.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|path| *path != self.path);
        drop(all);
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Returns a file in a folder that no export writes: those are `mark`, and files whose names are numbers.
fn foreign_file(folder: &Path, mark: &str) -> Option<PathBuf> {
    let is_own = |path: &Path| {
        let stem = path.file_stem().and_then(OsStr::to_str).unwrap_or("?");
        let ending = path.extension().unwrap_or_default();
        let is_number = stem.bytes().all(|c| c.is_ascii_digit());
        path.file_name() == Some(OsStr::new(mark))
            || (is_number && ["", "glb", "subtree"].iter().any(|known| ending == *known))
    };
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                open.push(entry.path());
            } else if !is_own(&entry.path()) {
                return Some(entry.path());
            }
        }
    }
    None
}
