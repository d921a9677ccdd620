//! What is open: the document, what draws it, what runs beside it, and what is said of it.

use crate::commands::Command;
use crate::dialog::Dialog;
use crate::document::Document;
use crate::files::FileAccess;
use crate::jobs::Jobs;
use crate::picking::Picker;
use crate::preferences::Preferences;
use crate::recovery::Recovery;
use crate::render_thread::RenderThread;
use argil::Engine;
use argil::scene::{NodeId, Scene};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// See the module's page.
pub(crate) struct Session {
    /// The document.
    pub document: Document,
    /// Actions of the document since it was opened, and a thousand for each document before.
    pub version: u64,
    /// What draws it.
    pub renderer: RenderThread,
    /// What rays meet of it.
    pub picker: Picker,
    /// What was chosen for all documents.
    pub preferences: Preferences,
    /// What is asked or shown over the window.
    pub dialog: Option<Dialog>,
    /// The last thing that went wrong, or was done.
    pub note: Option<Note>,
    /// What runs beside the window.
    pub jobs: Jobs,
    /// Meshes that were read since it was begun, as scenes name them.
    pub read_meshes: BTreeSet<String>,
    /// What exported pictures are drawn on.
    pub export_engine: Engine,
    /// How files are asked for.
    pub files: Box<dyn FileAccess>,
    /// Where journals are kept, if they are.
    pub recovery_folder: Option<PathBuf>,
    /// Whether the window may be closed without a question.
    pub may_close: bool,
    /// Commands that would do something now.
    pub can: BTreeSet<Command>,
    /// Commands whose switch is on now.
    pub is_on: BTreeSet<Command>,
    /// What the editor's other parts are to do, in this order.
    pub requests: Vec<Request>,
    /// What the browser keeps of it.
    #[cfg(target_arch = "wasm32")]
    pub keeper: crate::local_storage::LocalStorage,
}

/// What another part of the editor is to do.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Request {
    /// Do a command.
    Run(Command),
    /// Show a document that was opened, in full.
    ShowAll,
    /// Show what was put in, where little of it would be seen.
    ShowNew,
    /// Have a node's row in sight.
    Reveal(NodeId),
    /// Close a group's row.
    Fold(NodeId),
    /// Strokes are painted with the second material where they were with the first, which is gone.
    Rename([String; 2]),
}

/// Something to be told.
pub(crate) struct Note {
    /// In words.
    pub text: String,
    /// Whether it went wrong.
    pub is_fault: bool,
    /// When.
    pub told: web_time::Instant,
}

impl Session {
    /// Have a scene in place of the one that is open.
    pub(crate) fn replace_scene(&mut self, scene: Scene, path: Option<PathBuf>) {
        self.document.close();
        let recovery = match &self.recovery_folder {
            Some(folder) => Recovery::within(folder.clone()),
            None => Recovery::off(),
        };
        self.set_document(Document::new(scene, path, recovery));
    }

    /// Have a document that is as it should be.
    pub(crate) fn set_document(&mut self, document: Document) {
        self.document = document;
        self.version += 1000;
        self.picker.forget();
        self.renderer.load(self.document.scene(), self.version);
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

    /// Do, and tell what goes wrong.
    pub(crate) fn attempt(&mut self, what: impl FnOnce(&mut Self) -> anyhow::Result<()>) {
        let was_in_stroke = self.document.is_in_stroke();
        if let Err(error) = what(self) {
            // Half of a step is not what anybody wants.
            if !was_in_stroke {
                self.document.cancel_stroke();
            }
            self.fail(&error);
        }
    }

    /// Hand on what was done.
    pub(crate) fn forward_edits(&mut self) {
        self.load_wanted();
        let actions = self.document.take_actions();
        self.version += actions.len() as u64;
        self.renderer.follow(actions);
    }
}
