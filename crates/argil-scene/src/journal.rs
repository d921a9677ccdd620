//! A journal of a session's edits, written as they are made, from which a scene comes back after a crash with all its
//! history.
//!
//! *Practice.* Its first line holds the scene as it was when the journal was begun, each further one an edit as a
//! [log](crate::LogError) has it, with a checksum before it. A line is handed to the system at once and whole: when the
//! process dies, all that was recorded is there, and at most the line in flight is torn, which is left out. When the machine
//! dies, lines that the system had not written yet are lost too. Name and view are those of the beginning: they are no edits.

use crate::{Edit, EditError, EditOutcome, FileError, LogError, Scene, write_atomically};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Version of the format.
const VERSION: u32 = 1;
/// Hexadecimal digits of a checksum and a space.
const SUM_BYTES: usize = 9;

#[derive(Serialize, Deserialize)]
struct Head {
    journal: u32,
    scene: String,
}

/// Why a journal could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// The file could not be written or read.
    #[error("{path}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The scene was edited already: what is undone later could not be replayed.
    #[error("a journal is to be begun before the first edit: this scene has {0} already")]
    TooLate(usize),
    /// It does not begin as a journal does.
    #[error("{0} is no journal of edits, or its beginning is damaged")]
    NoJournal(PathBuf),
    /// A newer program wrote it.
    #[error(
        "{path}: journal version {found} is newer than this program reads ({VERSION}): update argil"
    )]
    Newer {
        /// Which file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The scene at its beginning cannot be read.
    #[error(transparent)]
    Scene(#[from] FileError),
    /// A line that is not the last is damaged.
    #[error(
        "{path}:{line}: this line is damaged, and others come after it: what is before it comes back from a copy that is cut there"
    )]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
    /// An edit that is whole cannot be done.
    #[error("{path}:{line}")]
    Line {
        /// Which file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// Why not.
        source: LogError,
    },
    /// The edit itself was refused; nothing was recorded.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A line to replay was refused; nothing was recorded.
    #[error(transparent)]
    Replay(LogError),
}

/// A journal that is being written.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Bytes that are whole.
    length: u64,
    /// Lines that could not be written yet.
    unwritten: String,
}

/// What came back from a journal.
#[derive(Debug)]
pub struct RecoveredSession {
    /// The scene, with its history.
    pub scene: Scene,
    /// Lines that were replayed.
    pub edits: usize,
    /// Bytes of a line that was not whole and is left out.
    pub torn_bytes: u64,
    path: PathBuf,
    length: u64,
}

impl RecoveredSession {
    /// Go on with the journal, whose torn end is cut off.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn resume(self) -> Result<(Scene, Journal), JournalError> {
        let Self { path, .. } = self;
        let journal = Journal::open(&path, self.length);
        let journal = journal.map_err(|source| JournalError::Io { path, source })?;
        Ok((self.scene, journal))
    }
}

impl Journal {
    /// Begin a journal of a scene's edits. What was in its place is replaced at once and whole.
    ///
    /// # Errors
    /// If it cannot be written, or the scene has a history.
    pub fn create(path: impl AsRef<Path>, scene: &Scene) -> Result<Self, JournalError> {
        Self::begin_at(path.as_ref().into(), scene)
    }

    fn begin_at(path: PathBuf, scene: &Scene) -> Result<Self, JournalError> {
        let edits: usize = scene.undo_depth() + scene.redo_depth();
        if edits > 0 {
            return Err(JournalError::TooLate(edits));
        }
        let head = Head {
            journal: VERSION,
            scene: scene.to_json(),
        };
        let line = summed(&serde_json::to_string(&head).expect("a head is JSON"));
        write_atomically(&path, |out| out.write_all(line.as_bytes()))
            .and_then(|()| Self::open(&path, line.len() as u64))
            .map_err(|source| JournalError::Io { path, source })
    }

    /// Bring a scene back. The file is left as it is.
    ///
    /// # Errors
    /// If it cannot be read, or something other than its end is damaged.
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
        let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
        let head = lines.next().and_then(whole);
        let head: Option<Head> = head.and_then(|text| serde_json::from_slice(text.as_bytes()).ok());
        let head = head.ok_or_else(|| JournalError::NoJournal(path.into()))?;
        if head.journal > VERSION {
            return Err(JournalError::Newer {
                path: path.into(),
                found: head.journal,
            });
        }
        let inside = format!("{}, its scene", path.display());
        let mut scene = Scene::from_json(&head.scene, inside)?;
        let mut length = bytes
            .iter()
            .position(|&b| b == b'\n')
            .map_or(0, |at| at + 1);
        let mut edits = 0;
        for line in lines {
            let Some(text) = whole(line) else {
                if length + line.len() < bytes.len() {
                    return Err(JournalError::Damaged {
                        path: path.into(),
                        line: edits + 2,
                    });
                }
                break;
            };
            let replayed = scene.apply_log_line(text);
            replayed.map_err(|source| JournalError::Line {
                path: path.into(),
                line: edits + 2,
                source,
            })?;
            length += line.len();
            edits += 1;
        }
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
        let mut file = File::options().write(true).open(path)?;
        file.set_len(length)?;
        file.seek(SeekFrom::End(0))?;
        Ok(Self {
            path: path.into(),
            file,
            length,
            unwritten: String::new(),
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Do an edit and record it.
    ///
    /// # Errors
    /// If the edit is refused: nothing is recorded then. Or if it cannot be written: the edit is done all the same, the file
    /// is as it was, and the next edit's line is written together with this one.
    pub fn apply(&mut self, scene: &mut Scene, edit: Edit) -> Result<EditOutcome, JournalError> {
        let line = scene.log_line(&edit);
        let edited = scene.apply(edit)?;
        self.record(&line)?;
        Ok(edited)
    }

    /// Do what a line of a log says and record it: edits, undo and redo, the beginnings and ends of strokes.
    ///
    /// # Errors
    /// As [`Journal::apply`].
    pub fn replay(
        &mut self,
        scene: &mut Scene,
        line: &str,
    ) -> Result<Option<EditOutcome>, JournalError> {
        let edited = scene.apply_log_line(line).map_err(JournalError::Replay)?;
        // A journal's line has no end within it.
        let line = line.replace(['\n', '\r'], " ");
        self.record(&line)?;
        Ok(edited)
    }

    /// Record a line that was done already, by [`Scene::apply_log_line`].
    ///
    /// # Errors
    /// If it cannot be written; it is written together with the next one then.
    pub fn record(&mut self, line: &str) -> Result<(), JournalError> {
        self.unwritten.push_str(&summed(line));
        let written = self.file.write_all(self.unwritten.as_bytes());
        written.map_err(|source| {
            // Half a line would hide what comes after it; if this fails too, the next line's checksum tells.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
            JournalError::Io {
                path: self.path.clone(),
                source,
            }
        })?;
        self.length += self.unwritten.len() as u64;
        self.unwritten.clear();
        Ok(())
    }

    /// Remove it: the scene is saved, and nothing is left to bring back.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn remove(self) -> Result<(), JournalError> {
        let Self { path, file, .. } = self;
        drop(file);
        std::fs::remove_file(&path).map_err(|source| JournalError::Io { path, source })
    }
}

/// A line with its checksum and end.
fn summed(text: &str) -> String {
    format!("{:08x} {text}\n", crc32fast::hash(text.as_bytes()))
}

/// What a line says, if it is whole.
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
        let writable = std::mem::replace(&mut journal.file, read_only);
        for _ in 0..2 {
            let refused = journal.replay(&mut scene, insert);
            assert!(matches!(refused, Err(JournalError::Io { .. })));
        }
        assert_eq!(Journal::recover(&path).expect("a journal").edits, 0);
        journal.file = writable;
        journal.replay(&mut scene, insert).expect("room");
        let found = Journal::recover(&path).expect("a journal");
        assert_eq!((found.edits, found.torn_bytes), (3, 0));
        assert!(found.scene == scene);
    }
}
