//! How files are asked for.

use std::path::PathBuf;

/// Whether it runs in a browser, which has no files: those that are opened are read whole, those that are written are downloads.
pub(crate) const IS_PAGE: bool = cfg!(target_arch = "wasm32");

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// A scene to open.
    Open,
    /// Where to save a scene.
    Save,
    /// A mesh to import.
    Import,
    /// Where to write triangles.
    Mesh,
    /// Where to write a picture.
    Picture,
    /// A folder for the pictures of a turntable.
    Turntable,
    /// Where to write a volume.
    Volume,
}

impl FileRequest {
    /// What kind of file it is, with the endings of its name.
    pub fn kind(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Open | Self::Save => ("Scene", &["json"]),
            Self::Import => ("Mesh or heightmap", &["obj", "glb", "ply", "stl", "png"]),
            Self::Mesh => ("Mesh", &["glb", "obj", "ply", "stl"]),
            Self::Picture => ("PNG picture", &["png"]),
            Self::Turntable if IS_PAGE => ("Archive", &["zip"]),
            Self::Turntable => ("Folder", &[]),
            Self::Volume => ("Volume", &["argil"]),
        }
    }
}

/// How files are asked for.
pub trait FileAccess {
    /// A place; none where the asking was given up, or where what was chosen comes later, as bytes, by
    /// themselves. `name` is what is proposed.
    fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf>;

    /// Why nobody was asked the last time, once.
    fn take_fault(&mut self) -> Option<String> {
        None
    }
}

/// The system's own dialogs.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Default)]
pub(crate) struct Native {
    fault: Option<String>,
}

/// Nobody gives a dialog up so fast: there was none.
#[cfg(not(target_arch = "wasm32"))]
const UNSEEN: std::time::Duration = std::time::Duration::from_millis(100);

#[cfg(not(target_arch = "wasm32"))]
impl FileAccess for Native {
    fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf> {
        let start = std::time::Instant::now();
        let path = dialog(what, name);
        if path.is_none() && start.elapsed() < UNSEEN {
            let fault = "the system shows no dialog for files: on Linux that takes a desktop portal or zenity (on Debian and Ubuntu: xdg-desktop-portal-gtk, or zenity)";
            self.fault = Some(fault.into());
        }
        path
    }

    fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn dialog(what: FileRequest, name: &str) -> Option<PathBuf> {
    let (kind, endings) = what.kind();
    let mut dialog = rfd::FileDialog::new();
    if !endings.is_empty() {
        dialog = dialog.add_filter(kind, endings);
    }
    match what {
        FileRequest::Open | FileRequest::Import => dialog.pick_file(),
        FileRequest::Turntable => dialog.pick_folder(),
        _ => {
            let path = dialog.set_file_name(name).save_file()?;
            // Some dialogs leave the ending out.
            match (path.extension(), endings.first()) {
                (None, Some(ending)) => may_replace(path.with_extension(ending)),
                _ => Some(path),
            }
        }
    }
}

/// A place of another name than the dialog has asked about.
#[cfg(not(target_arch = "wasm32"))]
fn may_replace(path: PathBuf) -> Option<PathBuf> {
    if !path.exists() {
        return Some(path);
    }
    let answer = rfd::MessageDialog::new()
        .set_title("Argil Studio")
        .set_description(format!("{} is there. Replace it?", path.display()))
        .set_buttons(rfd::MessageButtons::YesNo)
        .show();
    (answer == rfd::MessageDialogResult::Yes).then_some(path)
}
