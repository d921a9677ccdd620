//! Journals of open documents, for recovery after a crash.

use anyhow::Context;
use argil::scene::{Journal, Scene};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// The journal of one document, which is removed when the document is closed.
#[derive(Debug, Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    journal: Option<Journal>,
    /// The scene's file, and files outside of its folder that it may read.
    scene: Option<PathBuf>,
    external: BTreeSet<PathBuf>,
    /// Why the journal cannot be written.
    pub fault: Option<String>,
}

/// A session that did not end normally.
#[derive(Debug)]
pub(crate) struct RecoverableSession {
    /// Path of the journal.
    pub journal: PathBuf,
    /// Path of the scene's file, if it had one.
    pub scene: Option<PathBuf>,
    /// Files that the scene was allowed to read.
    pub external: BTreeSet<PathBuf>,
}

impl RecoverableSession {
    /// Claims the journal for this process, so that no other process offers it.
    ///
    /// # Errors
    /// If another process claimed it first.
    pub(crate) fn claim(self) -> anyhow::Result<Self> {
        let folder = self.journal.parent().unwrap_or(Path::new("."));
        let journal = folder.join(own_name());
        std::fs::rename(&self.journal, &journal).with_context(|| {
            format!(
                "{}: another window may use this session",
                self.journal.display()
            )
        })?;
        for ending in [ORIGIN, SAVED] {
            // This file may not exist.
            let _ = std::fs::rename(
                self.journal.with_extension(ending),
                journal.with_extension(ending),
            );
        }
        Ok(Self { journal, ..self })
    }
}

/// Returns the name of a new journal of this process.
fn own_name() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let stamp = since.map_or(0, |since| since.as_nanos());
    format!("{}-{stamp}.{ENDING}", std::process::id())
}

const ENDING: &str = "journal";
/// Suffix of the file with the scene's path, and the paths of files that it was allowed to read, one on each line.
const ORIGIN: &str = "origin";
/// Suffix of the file with the number of journal lines at the last save.
const SAVED: &str = "saved";

impl Recovery {
    /// Writes journals to a folder.
    pub fn within(folder: PathBuf) -> Self {
        Self {
            folder: Some(folder),
            ..Self::default()
        }
    }

    /// Writes no journals.
    pub fn off() -> Self {
        Self::default()
    }

    /// Continues a recovered journal.
    pub fn of(journal: Journal) -> Self {
        let folder = journal.path().parent().map(Path::to_path_buf);
        Self {
            folder,
            journal: Some(journal),
            ..Self::default()
        }
    }

    /// Returns the same journal of a scene that may read some files.
    pub fn with_external(self, external: BTreeSet<PathBuf>) -> Self {
        Self { external, ..self }
    }

    /// Begins a journal with a scene, and removes the one before.
    pub fn begin(&mut self, scene: &Scene, path: Option<&Path>) {
        self.end();
        let Some(folder) = &self.folder else { return };
        let file = folder.join(own_name());
        self.scene = path.map(Path::to_path_buf);
        self.external.clear();
        let made = std::fs::create_dir_all(folder)
            .and_then(|()| self.write_origin(&file))
            .map_err(|e| e.to_string())
            .and_then(|()| Journal::create(&file, scene).map_err(|e| e.to_string()));
        match made {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => self.fault = Some(format!("{}: {error}", file.display())),
        }
    }

    /// Records that the scene was saved. Earlier edits need no recovery.
    pub fn note_saved(&mut self, path: &Path) {
        self.scene = Some(path.into());
        self.note(|keeper, file| {
            keeper.write_origin(file)?;
            std::fs::write(file.with_extension(SAVED), lines_of(file).to_string())
        });
    }

    /// Records that the scene may read a file.
    pub fn note_external(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        if self.external.insert(path) {
            self.note(Self::write_origin);
        }
    }

    fn note(&mut self, write: impl FnOnce(&Self, &Path) -> std::io::Result<()>) {
        let Some(journal) = &self.journal else { return };
        let file = journal.path();
        if let Err(error) = write(self, file) {
            self.fault = Some(format!("{}: {error}", file.display()));
        }
    }

    /// Writes which scene a journal is of.
    fn write_origin(&self, journal: &Path) -> std::io::Result<()> {
        if self.scene.is_none() && self.external.is_empty() {
            return Ok(());
        }
        let mut lines = vec![match &self.scene {
            // A relative path is meaningless in another session.
            Some(path) => std::path::absolute(path)?.to_string_lossy().into_owned(),
            None => String::new(),
        }];
        let external = self.external.iter().map(|path| path.to_string_lossy());
        // No path of several lines becomes several paths.
        lines.extend(external.filter(|path| !path.contains('\n')).map(Into::into));
        std::fs::write(journal.with_extension(ORIGIN), lines.join("\n"))
    }

    /// Writes an action.
    pub fn record(&mut self, line: &str) {
        if let Some(journal) = &mut self.journal
            && let Err(error) = journal.record(line)
        {
            self.fault = Some(error.to_string());
        }
    }

    /// Removes the journal.
    pub fn end(&mut self) {
        if let Some(journal) = self.journal.take() {
            let path = journal.path().to_path_buf();
            let _ = journal.remove();
            remove_beside(&path);
        }
    }
}

/// Returns the sessions in a folder that did not end normally, latest first.
pub(crate) fn left_in(folder: &Path) -> Vec<RecoverableSession> {
    let Ok(files) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut all: Vec<(SystemTime, RecoverableSession)> = Vec::new();
    for file in files.flatten() {
        let path = file.path();
        if path.extension().is_none_or(|e| e != ENDING) || is_alive(&path) {
            continue;
        }
        if !has_edits(&path) {
            continue;
        }
        let time = file.metadata().and_then(|m| m.modified());
        let origin = std::fs::read_to_string(path.with_extension(ORIGIN)).unwrap_or_default();
        let mut lines = origin.lines().map(PathBuf::from);
        let scene = lines.next().filter(|scene| !scene.as_os_str().is_empty());
        let left = RecoverableSession {
            journal: path,
            scene,
            external: lines.collect(),
        };
        all.push((time.unwrap_or(UNIX_EPOCH), left));
    }
    all.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
    all.into_iter().map(|(_, left)| left).collect()
}

/// Returns true if edits follow the scene, which is the first line, or the last save.
fn has_edits(journal: &Path) -> bool {
    let saved = std::fs::read_to_string(journal.with_extension(SAVED)).ok();
    let known = saved.and_then(|text| text.parse().ok()).unwrap_or(1);
    lines_of(journal) > known
}

/// Returns the number of lines of a file, or 0 if it cannot be read.
fn lines_of(path: &Path) -> usize {
    let file = std::fs::File::open(path).map(std::io::BufReader::new);
    file.map_or(0, |file| std::io::BufRead::split(file, b'\n').count())
}

fn remove_beside(journal: &Path) {
    for ending in [ORIGIN, SAVED] {
        // This file may not exist.
        let _ = std::fs::remove_file(journal.with_extension(ending));
    }
}

/// Deletes a session's journal.
pub(crate) fn discard(left: &RecoverableSession) {
    let _ = std::fs::remove_file(&left.journal);
    remove_beside(&left.journal);
}

/// Returns true if the process that writes a journal is running.
fn is_alive(journal: &Path) -> bool {
    let stem = journal.file_stem().unwrap_or_default().to_string_lossy();
    let Some(id) = stem.split('-').next().and_then(|id| id.parse::<u32>().ok()) else {
        return false;
    };
    is_running(id)
}

/// A browser has no processes and no journals.
#[cfg(target_arch = "wasm32")]
fn is_running(_: u32) -> bool {
    false
}

#[cfg(not(target_arch = "wasm32"))]
fn is_running(id: u32) -> bool {
    let id = sysinfo::Pid::from_u32(id);
    let mut system = sysinfo::System::new();
    system.refresh_processes(sysinfo::ProcessesToUpdate::Some(&[id]), true);
    system.process(id).is_some()
}
