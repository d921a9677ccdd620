//! The session: the document, its rendering, background jobs and messages.

use crate::commands::Command;
use crate::dialog::Dialog;
use crate::document::Document;
use crate::files::FileAccess;
use crate::jobs::Jobs;
use crate::open_world::OpenWorld;
use crate::picking::Picker;
use crate::preferences::Preferences;
use crate::recovery::Recovery;
use crate::render_thread::RenderThread;
use argil::Engine;
use argil::scene::{NodeId, Scene};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The session.
pub(crate) struct Session {
    /// The document.
    pub document: Document,
    /// The world in a store that the document edits.
    pub world: Option<OpenWorld>,
    /// Version of the document: its actions, plus a thousand per earlier document.
    pub version: u64,
    /// The render thread.
    pub renderer: RenderThread,
    /// The picker.
    pub picker: Picker,
    /// The preferences.
    pub preferences: Preferences,
    /// The open dialog.
    pub dialog: Option<Dialog>,
    /// The last message.
    pub note: Option<Note>,
    /// Background jobs.
    pub jobs: Jobs,
    /// Meshes read in this session, as scenes name them.
    pub read_meshes: BTreeSet<String>,
    /// The engine that renders exported images.
    pub export_engine: Engine,
    /// File dialogs.
    pub files: Box<dyn FileAccess>,
    /// Folder of journals, if they are kept.
    pub recovery_folder: Option<PathBuf>,
    /// Whether the window may close without a question.
    pub may_close: bool,
    /// Available commands.
    pub can: BTreeSet<Command>,
    /// Commands whose switch is on.
    pub is_on: BTreeSet<Command>,
    /// Requests to other parts of the editor, in order.
    pub requests: Vec<Request>,
    /// The browser's storage of the scene.
    #[cfg(target_arch = "wasm32")]
    pub keeper: crate::local_storage::LocalStorage,
}

/// A request to another part of the editor.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Request {
    /// Run a command.
    Run(Command),
    /// Frame an opened document.
    ShowAll,
    /// Frame a new node if little of it would be visible.
    ShowNew,
    /// Scroll to a node's row.
    Reveal(NodeId),
    /// Collapse a group's row.
    Fold(NodeId),
    /// Replace a material of strokes that was renamed, from the first name to the second.
    Rename([String; 2]),
}

/// A message.
pub(crate) struct Note {
    /// The text.
    pub text: String,
    /// Whether it reports an error.
    pub is_fault: bool,
    /// When it appeared.
    pub told: web_time::Instant,
}

impl Session {
    /// Replaces the open scene.
    pub(crate) fn replace_scene(&mut self, scene: Scene, path: Option<PathBuf>) {
        self.replace_with(scene, path, None);
    }

    /// Replaces the open scene, with one whose world is in a store.
    pub(crate) fn replace_with(
        &mut self,
        scene: Scene,
        path: Option<PathBuf>,
        world: Option<OpenWorld>,
    ) {
        self.document.close();
        let recovery = match &self.recovery_folder {
            Some(folder) => Recovery::within(folder.clone()),
            None => Recovery::off(),
        };
        self.set_document(Document::new(scene, path, recovery), world);
    }

    /// Replaces the document.
    pub(crate) fn set_document(&mut self, document: Document, world: Option<OpenWorld>) {
        self.document = document;
        self.document.external = self.preferences.external_files();
        self.version += 1000;
        self.picker.forget();
        let pages = world.as_ref().map(|world| world.pages.clone());
        self.renderer
            .load(self.document.scene(), self.version, pages);
        self.world = world;
        self.requests.push(Request::ShowAll);
    }

    pub(crate) fn show_note(&mut self, text: impl Into<String>) {
        self.say(text.into(), false);
    }

    pub(crate) fn fail(&mut self, error: &anyhow::Error) {
        self.say(format!("{error:#}"), true);
    }

    pub(crate) fn say(&mut self, text: String, is_fault: bool) {
        let told = web_time::Instant::now();
        self.note = Some(Note {
            text,
            is_fault,
            told,
        });
    }

    /// Runs an operation, and reports its error.
    pub(crate) fn attempt(&mut self, what: impl FnOnce(&mut Self) -> anyhow::Result<()>) {
        let was_in_stroke = self.document.is_in_stroke();
        if let Err(error) = what(self) {
            // Undo an incomplete step.
            if !was_in_stroke {
                self.document.cancel_stroke();
            }
            self.fail(&error);
        }
    }

    /// Forwards actions to the render thread.
    pub(crate) fn forward_edits(&mut self) {
        self.load_wanted();
        let actions = self.document.take_actions();
        self.version += actions.len() as u64;
        self.renderer.follow(actions);
    }
}
