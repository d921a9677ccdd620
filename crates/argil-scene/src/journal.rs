//! A journal records a session's edits as they happen. After a crash, it restores the scene with its history.
//!
//! *Practice.* The first line holds the scene when the journal began. Each later line holds an edit with a
//! checksum. The system receives each line at once and complete. If the process dies, every recorded edit is there,
//! and at most the last line is torn. If the machine dies, lines that the system had not written yet are lost. The
//! scene's name is from the beginning, because it is not an edit.

mod error;
mod grids;

use crate::file::write_new;
use crate::{Action, Edit, EditOutcome, HistoryBake, Scene, write_atomically};
use error::VERSION;
use grids::{JournalGrid, sampled_shape};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use error::JournalError;

/// Hexadecimal digits of a checksum, and a space.
const SUM_BYTES: usize = 9;

#[derive(Serialize, Deserialize)]
struct JournalHead {
    journal: u32,
    scene: String,
    /// The samples of its sampled shapes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    grids: Vec<JournalGrid>,
}

/// A journal that is being written.
///
/// ```
/// use argil_scene::{Edit, Journal, Scene, Shape};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("session.journal");
/// let mut scene = Scene::new();
/// let mut journal = Journal::create(&path, &scene)?;
/// let desc = Shape::sphere(1.0).into();
/// journal.apply(&mut scene, Edit::Insert { parent: Scene::ROOT, index: 0, desc })?;
/// // After a crash:
/// let recovered = Journal::recover(&path)?;
/// assert_eq!(recovered.scene, scene);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    /// `None` until it is needed again.
    file: Option<File>,
    /// Bytes that are complete.
    length: u64,
    /// Lines that could not be written yet.
    unwritten: String,
    /// Checksums of recorded samples, by the names of their files.
    grids: BTreeMap<String, u32>,
}

/// A scene restored from a journal.
#[derive(Debug)]
pub struct RecoveredSession {
    /// The scene, with its history.
    pub scene: Scene,
    /// Number of lines that were replayed.
    pub edits: usize,
    /// Bytes of an incomplete last line, which was ignored.
    pub torn_bytes: u64,
    path: PathBuf,
    length: u64,
}

impl RecoveredSession {
    /// Continues the journal, after cutting off an incomplete last line.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn resume(self) -> Result<(Scene, Journal), JournalError> {
        let Self { path, scene, .. } = self;
        let journal = Journal::open(&path, self.length);
        let journal = journal.map_err(|source| JournalError::Io { path, source })?;
        Ok((scene, journal))
    }
}

impl Journal {
    /// Creates a journal of a scene's edits, and replaces a file at that path.
    ///
    /// # Errors
    /// If the file cannot be written, or the scene already has a history.
    pub fn create(path: impl AsRef<Path>, scene: &Scene) -> Result<Self, JournalError> {
        Self::begin_at(path.as_ref().into(), scene)
    }

    /// Creates a journal of a scene's edits, unless there is one. It appears as a whole, and only one of several processes creates
    /// it. A file of no bytes is replaced.
    ///
    /// # Errors
    /// If there is a file with something in it, the file cannot be written, or the scene already has a history.
    pub fn create_new(path: impl AsRef<Path>, scene: &Scene) -> Result<Self, JournalError> {
        let path = path.as_ref();
        let line = Self::head_line(scene)?;
        let journal =
            write_new(path, line.as_bytes()).and_then(|()| Self::open(path, line.len() as u64));
        journal.map_err(|source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => JournalError::Exists(path.into()),
            _ => JournalError::Io {
                path: path.into(),
                source,
            },
        })
    }

    fn begin_at(path: PathBuf, scene: &Scene) -> Result<Self, JournalError> {
        let line = Self::head_line(scene)?;
        write_atomically(&path, |out| out.write_all(line.as_bytes()))
            .and_then(|()| Self::open(&path, line.len() as u64))
            .map_err(|source| JournalError::Io { path, source })
    }

    /// Returns the first line of a journal.
    fn head_line(scene: &Scene) -> Result<String, JournalError> {
        let edits: usize = scene.undo_depth() + scene.redo_depth();
        if edits > 0 {
            return Err(JournalError::HistoryNotEmpty(edits));
        }
        let grids = JournalGrid::all_of(scene);
        let head = JournalHead {
            // As old programs read it, where they can.
            journal: if grids.is_empty() { 1 } else { VERSION },
            scene: scene.to_json(),
            grids,
        };
        Ok(summed(
            &serde_json::to_string(&head).expect("a head is JSON"),
        ))
    }

    /// Restores a scene from a journal, which stays unchanged.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged before its last line.
    pub fn recover(path: impl AsRef<Path>) -> Result<RecoveredSession, JournalError> {
        Self::recover_file(path.as_ref())
    }

    fn recover_file(path: &Path) -> Result<RecoveredSession, JournalError> {
        let io = |source| JournalError::Io {
            path: path.into(),
            source,
        };
        let mut bytes = Vec::new();
        let read = |bytes| File::open(path)?.read_to_end(bytes);
        read(&mut bytes).map_err(io)?;
        if bytes.is_empty() {
            return Err(JournalError::Empty(path.into()));
        }
        let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
        let head = lines.next().and_then(whole);
        let head: Option<JournalHead> =
            head.and_then(|text| serde_json::from_slice(text.as_bytes()).ok());
        let head = head.ok_or_else(|| JournalError::NoJournal(path.into()))?;
        if head.journal > VERSION {
            return Err(JournalError::Newer {
                path: path.into(),
                found: head.journal,
            });
        }
        let inside = format!("{}, its scene", path.display());
        let mut scene = Scene::from_json(&head.scene, inside)?;
        let mut grids = Vec::new();
        for grid in head.grids {
            if !grid.load_into(&mut scene) {
                return Err(JournalError::NoJournal(path.into()));
            }
            grids.push(grid);
        }
        let mut length = bytes
            .iter()
            .position(|&b| b == b'\n')
            .map_or(0, |at| at + 1);
        let damaged = |line| JournalError::Damaged {
            path: path.into(),
            line,
        };
        let (mut edits, mut number) = (0, 1);
        for line in lines {
            let Some(text) = whole(line) else {
                if length + line.len() < bytes.len() {
                    return Err(damaged(number + 1));
                }
                break;
            };
            number += 1;
            if let Some(grid) = JournalGrid::from_line(text) {
                if !grid.load_into(&mut scene) {
                    return Err(damaged(number));
                }
                grids.push(grid);
            } else {
                let replayed = scene.apply_log_line(text);
                replayed.map_err(|source| JournalError::Line {
                    path: path.into(),
                    line: number,
                    source,
                })?;
                edits += 1;
            }
            length += line.len();
        }
        grids.iter().for_each(|grid| grid.forget(&mut scene));
        let torn_bytes = (bytes.len() - length) as u64;
        Ok(RecoveredSession {
            scene,
            edits,
            torn_bytes,
            path: path.into(),
            length: length as u64,
        })
    }

    fn open(path: &Path, length: u64) -> std::io::Result<Self> {
        Ok(Self {
            path: path.into(),
            file: Some(open_at(path, length)?),
            length,
            unwritten: String::new(),
            grids: BTreeMap::new(),
        })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Applies an edit to a scene and records it.
    ///
    /// # Errors
    /// If the edit is refused; then nothing is recorded. If it cannot be written; then the edit is applied, the
    /// file stays unchanged, and the next record also writes this line.
    pub fn apply(&mut self, scene: &mut Scene, edit: Edit) -> Result<EditOutcome, JournalError> {
        let line = scene.log_line(&edit);
        let sampled = match &edit {
            Edit::Insert { desc, .. } | Edit::Replace { desc, .. } => sampled_shape(scene, desc),
            _ => None,
        };
        let sampled = sampled.and_then(|(file, resolution, grid)| {
            let sum = grid.checksum();
            let is_known = self.grids.get(file) == Some(&sum);
            (!is_known).then(|| (JournalGrid::of(file, resolution, grid), sum))
        });
        let edited = scene.apply(edit)?;
        if let Some((grid, sum)) = sampled {
            self.unwritten.push_str(&summed(&grid.to_line()));
            self.grids.insert(grid.file, sum);
        }
        self.append(&line)?;
        Ok(edited)
    }

    /// Folds a scene's history, and begins the journal again with the scene as it is then. Nothing before the fold can be undone
    /// afterwards, as after a crash.
    ///
    /// # Errors
    /// If an entry changed since the bake, or the file cannot be written. Then the scene and the journal stay as they were.
    pub fn fold_history(
        &mut self,
        scene: &mut Scene,
        bake: &HistoryBake,
    ) -> Result<(), JournalError> {
        let mut folded = scene.snapshot();
        folded.fold_history(bake)?;
        folded.forget_history(0);
        let mut text = Self::head_line(&folded)?;
        let is_stroke = scene.history.is_stroke;
        if is_stroke {
            text.push_str(&summed(&scene.action_line(&Action::BeginStroke)));
        }
        // Windows replaces no file that is open.
        self.file = None;
        let path = &self.path;
        write_atomically(path, |out| out.write_all(text.as_bytes())).map_err(|source| {
            JournalError::Io {
                path: path.clone(),
                source,
            }
        })?;
        self.length = text.len() as u64;
        self.unwritten.clear();
        self.grids.clear();
        scene.fold_history(bake)?;
        scene.forget_history(0);
        if is_stroke {
            scene.begin_stroke();
        }
        Ok(())
    }

    /// Performs the action on a line of a log and records it.
    ///
    /// # Errors
    /// If the action is refused; then nothing is recorded. If it cannot be written; then the next record also
    /// writes this line.
    pub fn replay(
        &mut self,
        scene: &mut Scene,
        line: &str,
    ) -> Result<Option<EditOutcome>, JournalError> {
        let edited = scene.apply_log_line(line).map_err(JournalError::Replay)?;
        // A line of the journal must not contain a line end.
        let line = line.replace(['\n', '\r'], " ");
        self.record(&line)?;
        Ok(edited)
    }

    /// Records a line that was already performed, by [`Scene::apply_log_line`]. Samples of shapes are not recorded so, only by
    /// [`Journal::apply`].
    ///
    /// # Errors
    /// If it cannot be written. Then the next record also writes this line.
    pub fn record(&mut self, line: &str) -> Result<(), JournalError> {
        // The line may rename files.
        self.grids.clear();
        self.append(line)
    }

    fn append(&mut self, line: &str) -> Result<(), JournalError> {
        self.unwritten.push_str(&summed(line));
        let written = match self.file.take() {
            Some(file) => Ok(file),
            None => open_at(&self.path, self.length),
        };
        let written = written.and_then(|file| {
            let file = self.file.insert(file);
            file.write_all(self.unwritten.as_bytes()).inspect_err(|_| {
                // Half a line would hide the lines after it. If this fails too, the next line's checksum reveals it.
                let _ = file.set_len(self.length);
                let _ = file.seek(SeekFrom::Start(self.length));
            })
        });
        written.map_err(|source| JournalError::Io {
            path: self.path.clone(),
            source,
        })?;
        self.length += self.unwritten.len() as u64;
        self.unwritten.clear();
        Ok(())
    }

    /// Removes the journal, after the scene was saved.
    ///
    /// # Errors
    /// If the file cannot be removed.
    pub fn remove(self) -> Result<(), JournalError> {
        // Windows removes no open file: the journal is closed here.
        let path = self.into_path();
        std::fs::remove_file(&path).map_err(|source| JournalError::Io { path, source })
    }

    fn into_path(self) -> PathBuf {
        self.path
    }
}

/// Opens a file to write behind its first bytes.
fn open_at(path: &Path, length: u64) -> std::io::Result<File> {
    let mut file = File::options().write(true).open(path)?;
    file.set_len(length)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}

/// Returns a line with its checksum and line end.
fn summed(text: &str) -> String {
    format!("{:08x} {text}\n", crc32fast::hash(text.as_bytes()))
}

/// Returns the contents of a line, if it is complete.
fn whole(line: &[u8]) -> Option<&str> {
    let line = line.strip_suffix(b"\n")?;
    let (sum, text) = line.split_at_checked(SUM_BYTES)?;
    let sum = std::str::from_utf8(sum).ok()?.strip_suffix(' ')?;
    let is_whole = u32::from_str_radix(sum, 16).ok()? == crc32fast::hash(text);
    is_whole.then(|| std::str::from_utf8(text).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_not_be_written_is_written_with_the_next() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("full.journal");
        let mut scene = Scene::new();
        let mut journal = Journal::create(&path, &scene).expect("a journal");
        let insert = r#"{"edit":"insert","entry":{"shape":{"type":"sphere","radius":0.1}}}"#;
        // A file that is open for reading takes no line.
        let read_only = File::open(&path).expect("a file");
        let writable = journal.file.replace(read_only);
        for _ in 0..2 {
            let refused = journal.replay(&mut scene, insert);
            assert!(matches!(refused, Err(JournalError::Io { .. })));
        }
        assert_eq!(Journal::recover(&path).expect("a journal").edits, 0);
        journal.file = writable;
        journal.replay(&mut scene, insert).expect("room");
        let recovered = Journal::recover(&path).expect("a journal");
        assert_eq!((recovered.edits, recovered.torn_bytes), (3, 0));
        assert!(recovered.scene == scene);
    }
}
