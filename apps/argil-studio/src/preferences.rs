//! Preferences, which are saved between sessions.

use crate::commands::{self, Command, CommandInfo};
use crate::pipeline::Pipeline;
use argil::ExternalFiles;
use eframe::egui::{KeyboardShortcut, ThemePreference};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The preferences.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Preferences {
    /// Recently opened or saved scenes, latest first.
    pub recent: Vec<PathBuf>,
    /// Meshes that the user chose. Scenes may read them from outside of their folder.
    pub external: BTreeSet<PathBuf>,
    /// Shortcuts that differ from the defaults, by command name. Empty text means none.
    pub shortcuts: BTreeMap<String, String>,
    /// Whether the interface is dark. `None` follows the system.
    pub is_dark: Option<bool>,
    /// Scale of the interface.
    pub zoom: f32,
    /// The pipeline shown.
    pub pipeline: Pipeline,
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Whether the grid is shown.
    pub grid: bool,
    /// Whether statistics are shown.
    pub readings: bool,
    /// Whether gizmos snap.
    pub snap: bool,
    /// Snap step in scene units.
    pub snap_length: f32,
    /// Snap step in degrees.
    pub snap_degrees: f32,
}

const MAX_RECENT: usize = 10;

impl Default for Preferences {
    fn default() -> Self {
        Self {
            recent: Vec::new(),
            external: BTreeSet::new(),
            shortcuts: BTreeMap::new(),
            is_dark: None,
            zoom: 1.0,
            pipeline: Pipeline::default(),
            resolution: 128,
            grid: true,
            readings: true,
            snap: false,
            snap_length: 0.1,
            snap_degrees: 15.0,
        }
    }
}

impl Preferences {
    /// Repairs preferences of another version, or that were edited by hand.
    pub(crate) fn mended(mut self) -> Self {
        let usual = Self::default();
        let within = |value: f32, least: f32, most: f32, usual: f32| {
            if (least..=most).contains(&value) {
                value
            } else {
                usual
            }
        };
        self.zoom = within(self.zoom, 0.5, 3.0, usual.zoom);
        self.snap_length = within(self.snap_length, 1e-4, 1e3, usual.snap_length);
        self.snap_degrees = within(self.snap_degrees, 0.1, 180.0, usual.snap_degrees);
        if !(16..=1024).contains(&self.resolution) {
            self.resolution = usual.resolution;
        }
        self.recent.truncate(MAX_RECENT);
        self
    }

    /// Records an opened or saved file.
    pub(crate) fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        self.recent.retain(|known| *known != path);
        self.recent.insert(0, path);
        self.recent.truncate(MAX_RECENT);
    }

    /// Records a mesh that the user chose.
    pub(crate) fn allow_file(&mut self, path: &Path) {
        let mut files = self.external_files();
        files.allow(path);
        self.external.clone_from(files.listed());
    }

    /// Returns the files that scenes may read from outside of their folder.
    pub(crate) fn external_files(&self) -> ExternalFiles {
        self.external.iter().collect()
    }

    /// Returns a command's shortcut.
    pub(crate) fn shortcut(&self, entry: &CommandInfo) -> Option<KeyboardShortcut> {
        match self.shortcuts.get(entry.name) {
            Some(text) => commands::parse(text),
            None => entry.shortcut,
        }
    }

    /// Assigns a shortcut to a command, and takes it from any other. `None` removes it.
    pub(crate) fn bind(&mut self, command: Command, shortcut: Option<KeyboardShortcut>) {
        if let Some(shortcut) = shortcut {
            for other in commands::ALL {
                if other.command != command && self.shortcut(other) == Some(shortcut) {
                    self.shortcuts.insert(other.name.into(), String::new());
                }
            }
        }
        let text = shortcut.as_ref().map(commands::format_shortcut);
        let name = commands::info(command).name.into();
        self.shortcuts.insert(name, text.unwrap_or_default());
    }

    /// Returns the theme for egui.
    pub(crate) fn theme(&self) -> ThemePreference {
        match self.is_dark {
            None => ThemePreference::System,
            Some(true) => ThemePreference::Dark,
            Some(false) => ThemePreference::Light,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Key, Modifiers};

    #[test]
    fn a_shortcut_belongs_to_one_command() {
        let mut preferences = Preferences::default();
        let undo = commands::info(Command::Undo);
        let theirs = preferences.shortcut(undo).expect("there is one");
        preferences.bind(Command::Delete, Some(theirs));
        assert_eq!(preferences.shortcut(undo), None);
        assert_eq!(
            preferences.shortcut(commands::info(Command::Delete)),
            Some(theirs)
        );
        let other = KeyboardShortcut::new(Modifiers::ALT, Key::U);
        preferences.bind(Command::Undo, Some(other));
        let text = serde_json::to_string(&preferences).expect("text");
        let again: Preferences = serde_json::from_str(&text).expect("the same");
        assert_eq!(again.shortcut(undo), Some(other));
    }

    #[test]
    fn what_is_kept_is_mended() {
        let bad: Preferences =
            serde_json::from_str(r#"{"zoom": 1e30, "resolution": 0}"#).expect("numbers");
        let mended = bad.mended();
        assert_eq!((mended.zoom, mended.resolution), (1.0, 128));
    }
}
