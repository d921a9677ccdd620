//! Dialogs over the window.

use crate::commands::Command;
use crate::recovery::RecoverableSession;
use std::path::PathBuf;

/// The open dialog. There is at most one.
pub(crate) enum Dialog {
    /// The document has unsaved changes.
    Unsaved(AfterDialog),
    /// Background jobs are running and the window is about to close. Contains the number of undo steps at that
    /// time.
    Unfinished(usize),
    /// An earlier session can be recovered.
    Recover(Vec<RecoverableSession>),
    /// The command palette.
    Palette {
        /// The search text.
        text: String,
        /// Index of the selected result.
        at: usize,
    },
    /// The list of shortcuts, and the command whose shortcut is being changed.
    Help(Option<Command>),
}

impl Dialog {
    /// Returns the palette with an empty search text.
    pub(crate) fn palette() -> Self {
        Self::Palette {
            text: String::new(),
            at: 0,
        }
    }
}

/// What happens after the question whether to save.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AfterDialog {
    /// A new document.
    New,
    /// The file dialog.
    Ask,
    /// A file is opened.
    Open(PathBuf),
    /// A scene's name and text, with meshes.
    #[cfg(target_arch = "wasm32")]
    NamedBytes(crate::browser::NamedBytes, Vec<crate::browser::NamedBytes>),
    /// A sample scene is opened.
    Sample(&'static str),
    /// The editor closes.
    Quit,
}
