//! Tiles on the disk.

use crate::tile_cache::tile_name;
use argil::scene::{TEMP_PREFIX, remove_abandoned_files};
use argil::volume::TileAddress;
use std::io::{Error, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

/// The folder in the user's folder that belongs to the cache alone.
const OWN_FOLDER: &str = "argil-tiles";
/// The file that marks it, and tells programs for backups to leave it out: see <https://bford.info/cachedir/>.
const MARK: &str = "CACHEDIR.TAG";
const MARK_TEXT: &str = "Signature: 8a477f597d28d172789f06886806bc55\n# Argil keeps tiles of worlds here. It removes the oldest ones by itself.\n";

/// The tiles of a world on the disk, as far as they were fetched from behind the network.
///
/// ```text
///   argil-tiles ┬ CACHEDIR.TAG
///               └ HASH of a world ─ tiles ─ TIER ─ X_Y_Z
/// ```
///
/// Files with other names are never removed.
#[derive(Debug)]
pub(crate) struct TileFolder {
    /// The folder of all worlds.
    root: PathBuf,
    /// The folder of this world.
    world: PathBuf,
    max_bytes: u64,
    /// Bytes that were written since the tiles were counted.
    written: AtomicU64,
}

impl TileFolder {
    /// Opens the folder of a world, below a folder that a user chose. It is marked, so that files of other programs are safe.
    ///
    /// # Errors
    /// If the folder cannot be created, or has files without the mark.
    pub(crate) fn open(folder: &Path, hash: &str, max_bytes: u64) -> Result<Self> {
        let root = folder.join(OWN_FOLDER);
        std::fs::create_dir_all(&root)?;
        let mark = root.join(MARK);
        if std::fs::read(&mark).unwrap_or_default() != MARK_TEXT.as_bytes() {
            // A program can be killed between the two steps.
            if std::fs::read_dir(&root)?
                .flatten()
                .any(|entry| entry.path() != mark)
            {
                return Err(Error::other("it has files, and no mark of the cache"));
            }
            std::fs::write(mark, MARK_TEXT)?;
        }
        Ok(Self {
            world: root.join(hash),
            root,
            max_bytes,
            written: AtomicU64::new(max_bytes),
        })
    }

    /// Returns the bytes of a tile, and notes that it was used.
    pub(crate) fn read(&self, address: TileAddress) -> Option<Vec<u8>> {
        let path = self.world.join(tile_name(address));
        let bytes = std::fs::read(&path).ok()?;
        // The oldest go first.
        let file = std::fs::File::options().append(true).open(&path);
        let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
        Some(bytes)
    }

    /// Keeps bytes of a tile, behind those that are there.
    ///
    /// # Errors
    /// If the disk cannot be written. That costs only time.
    pub(crate) fn write(&self, address: TileAddress, begin: u64, bytes: &[u8]) -> Result<()> {
        let path = self.world.join(tile_name(address));
        let Some(parent) = path.parent() else {
            return Ok(());
        };
        let before = match begin {
            0 => Vec::new(),
            _ => std::fs::read(&path).unwrap_or_default(),
        };
        let Some(before) = before.get(..begin as usize) else {
            return Ok(());
        };
        std::fs::create_dir_all(parent)?;
        let mut file = tempfile::Builder::new()
            .prefix(TEMP_PREFIX)
            .tempfile_in(parent)?;
        file.write_all(before)?;
        file.write_all(bytes)?;
        file.persist(&path).map_err(|error| error.error)?;
        let more = bytes.len() as u64;
        if self.written.fetch_add(more, Ordering::Relaxed) + more > self.max_bytes / 16 {
            self.written.store(0, Ordering::Relaxed);
            self.trim();
        }
        Ok(())
    }

    /// Removes the tiles that were not used for the longest time, of all worlds.
    fn trim(&self) {
        let mut files = Vec::new();
        for world in folders_in(&self.root) {
            for tier in folders_in(&world.join("tiles")) {
                remove_abandoned_files(&tier);
                files.extend(tiles_in(&tier));
            }
        }
        files.sort_unstable();
        let mut bytes: u64 = files.iter().map(|(_, length, _)| length).sum();
        for (_, length, path) in files {
            if bytes <= self.max_bytes {
                break;
            }
            if std::fs::remove_file(path).is_ok() {
                bytes -= length;
            }
        }
    }
}

/// Returns the folders in a folder, without links.
fn folders_in(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    folders.map(|entry| entry.path())
}

/// Returns the files of a tier that have names of tiles: when they were used, and their lengths in bytes.
fn tiles_in(tier: &Path) -> impl Iterator<Item = (SystemTime, u64, PathBuf)> {
    let entries = std::fs::read_dir(tier).into_iter().flatten().flatten();
    entries.filter_map(|entry| {
        let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
        let path = entry.path();
        let tier = path.parent()?.file_name()?.to_str()?;
        let name = format!("{tier}/{}", path.file_name()?.to_str()?);
        let address: TileAddress = name.parse().ok()?;
        (address.to_string() == name).then_some((about.modified().ok()?, about.len(), path))
    })
}
