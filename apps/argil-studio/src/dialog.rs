//! What can be asked or shown over the window.

use crate::commands::Command;
use crate::recovery::RecoverableSession;
use std::path::PathBuf;

/// Over the window there is at most one.
pub(crate) enum Dialog {
    /// Something is not saved.
    Unsaved(AfterDialog),
    /// Something is not finished, and the window is to be closed; how many steps there were then.
    Unfinished(usize),
    /// A session before has left something.
    Recover(Vec<RecoverableSession>),
    /// Commands by parts of their names.
    Palette {
        /// What is typed.
        text: String,
        /// Which of those that are found is chosen.
        at: usize,
    },
    /// All shortcuts; and the command that is given another.
    Help(Option<Command>),
}

impl Dialog {
    /// The palette with nothing typed.
    pub(crate) fn palette() -> Self {
        Self::Palette {
            text: String::new(),
            at: 0,
        }
    }
}

/// What comes after the question whether to save.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AfterDialog {
    /// Something new.
    New,
    /// The file that is asked for.
    Ask,
    /// A file.
    Open(PathBuf),
    /// A scene's name and text, with meshes.
    #[cfg(target_arch = "wasm32")]
    NamedBytes(crate::browser::NamedBytes, Vec<crate::browser::NamedBytes>),
    /// One of the scenes that come with the editor.
    Sample(&'static str),
    /// The end.
    Quit,
}
