//! Journals of what is being edited, from which it comes back after a crash.

use anyhow::Context;
use argil::scene::{Journal, Scene};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// The journal of one document: a file in a folder of its own, removed when the document is closed.
#[derive(Debug, Default)]
pub struct Recovery {
    folder: Option<PathBuf>,
    journal: Option<Journal>,
    /// Why nothing is journalled.
    pub fault: Option<String>,
}

/// What a session that ended badly has left.
#[derive(Debug)]
pub(crate) struct RecoverableSession {
    /// The journal.
    pub journal: PathBuf,
    /// The scene's own file, if it had one.
    pub scene: Option<PathBuf>,
}

impl RecoverableSession {
    /// Have it be this process's, so that no other is offered it.
    ///
    /// # Errors
    /// If it is another's by now.
    pub(crate) fn claim(self) -> anyhow::Result<Self> {
        let folder = self.journal.parent().unwrap_or(Path::new("."));
        let journal = folder.join(own_name());
        std::fs::rename(&self.journal, &journal)
            .with_context(|| format!("{}: another window may have it", self.journal.display()))?;
        for ending in [ORIGIN, SAVED] {
            // It need not be there.
            let _ = std::fs::rename(
                self.journal.with_extension(ending),
                journal.with_extension(ending),
            );
        }
        Ok(Self { journal, ..self })
    }
}

/// The name of a journal of this process that begins now.
fn own_name() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    let stamp = since.map_or(0, |since| since.as_nanos());
    format!("{}-{stamp}.{ENDING}", std::process::id())
}

const ENDING: &str = "journal";
/// Beside a journal: where its scene is from.
const ORIGIN: &str = "origin";
/// Beside a journal: how many lines it had when its scene was saved last.
const SAVED: &str = "saved";

impl Recovery {
    /// In a folder.
    pub fn within(folder: PathBuf) -> Self {
        Self {
            folder: Some(folder),
            ..Self::default()
        }
    }

    /// Nothing is kept.
    pub fn off() -> Self {
        Self::default()
    }

    /// Go on with a journal that was brought back.
    pub fn of(journal: Journal) -> Self {
        let folder = journal.path().parent().map(Path::to_path_buf);
        Self {
            folder,
            journal: Some(journal),
            fault: None,
        }
    }

    /// Begin with a scene, in place of what was journalled before.
    pub fn begin(&mut self, scene: &Scene, path: Option<&Path>) {
        self.end();
        let Some(folder) = &self.folder else { return };
        let file = folder.join(own_name());
        let made = std::fs::create_dir_all(folder)
            .and_then(|()| match path {
                // Relative ones mean nothing to a session that begins elsewhere.
                Some(path) => std::fs::write(
                    file.with_extension(ORIGIN),
                    std::path::absolute(path)?.to_string_lossy().as_bytes(),
                ),
                None => Ok(()),
            })
            .map_err(|e| e.to_string())
            .and_then(|()| Journal::create(&file, scene).map_err(|e| e.to_string()));
        match made {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => self.fault = Some(format!("{}: {error}", file.display())),
        }
    }

    /// The scene was saved to a file: what was done so far need not be brought back.
    pub fn note_saved(&mut self, path: &Path) {
        let Some(journal) = &self.journal else { return };
        let file = journal.path();
        let noted = std::path::absolute(path)
            .and_then(|path| {
                let origin = path.to_string_lossy().into_owned();
                std::fs::write(file.with_extension(ORIGIN), origin)
            })
            .and_then(|()| std::fs::write(file.with_extension(SAVED), lines_of(file).to_string()));
        if let Err(error) = noted {
            self.fault = Some(format!("{}: {error}", file.display()));
        }
    }

    /// Write what was done.
    pub fn record(&mut self, line: &str) {
        if let Some(journal) = &mut self.journal
            && let Err(error) = journal.record(line)
        {
            self.fault = Some(error.to_string());
        }
    }

    /// Nothing is to be brought back.
    pub fn end(&mut self) {
        if let Some(journal) = self.journal.take() {
            let path = journal.path().to_path_buf();
            let _ = journal.remove();
            remove_beside(&path);
        }
    }
}

/// What sessions that are over have left in a folder, the newest first.
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
        let scene = std::fs::read_to_string(path.with_extension(ORIGIN)).ok();
        let left = RecoverableSession {
            journal: path,
            scene: scene.map(PathBuf::from),
        };
        all.push((time.unwrap_or(UNIX_EPOCH), left));
    }
    all.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
    all.into_iter().map(|(_, left)| left).collect()
}

/// Whether something was done since the scene, which is the first line, or since it was saved.
fn has_edits(journal: &Path) -> bool {
    let saved = std::fs::read_to_string(journal.with_extension(SAVED)).ok();
    let known = saved.and_then(|text| text.parse().ok()).unwrap_or(1);
    lines_of(journal) > known
}

/// Lines of a file, none where it cannot be read.
fn lines_of(path: &Path) -> usize {
    let file = std::fs::File::open(path).map(std::io::BufReader::new);
    file.map_or(0, |file| std::io::BufRead::split(file, b'\n').count())
}

fn remove_beside(journal: &Path) {
    for ending in [ORIGIN, SAVED] {
        // It need not be there.
        let _ = std::fs::remove_file(journal.with_extension(ending));
    }
}

/// Forget what was left.
pub(crate) fn discard(left: &RecoverableSession) {
    let _ = std::fs::remove_file(&left.journal);
    remove_beside(&left.journal);
}

/// Whether the process that writes a journal is this one, or one that still runs.
fn is_alive(journal: &Path) -> bool {
    let stem = journal.file_stem().unwrap_or_default().to_string_lossy();
    let Some(id) = stem.split('-').next().and_then(|id| id.parse::<u32>().ok()) else {
        return false;
    };
    is_running(id)
}

/// A browser has no processes, nor journals.
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
