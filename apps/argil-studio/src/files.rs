//! File dialogs.

use std::path::PathBuf;

/// Whether the editor runs in a browser. There, opened files are read completely, and written files are downloads.
pub(crate) const IS_PAGE: bool = cfg!(target_arch = "wasm32");

/// The purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileRequest {
    /// Open a scene.
    Open,
    /// Save a scene.
    Save,
    /// Import a mesh.
    Import,
    /// Export triangles.
    Mesh,
    /// Export an image.
    Picture,
    /// Export the images of a turntable to a folder.
    Turntable,
    /// Export a volume.
    Volume,
}

impl FileRequest {
    /// Returns the kind of file, and its extensions.
    pub fn kind(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Open | Self::Save => ("Scene", &["json"]),
            Self::Import => (
                "Mesh, volume or heightmap",
                &[
                    "glb", "gltf", "obj", "ply", "stl", "3mf", "vdb", "nvdb", "npy", "nrrd", "png",
                ],
            ),
            Self::Mesh => ("Mesh", &["glb", "gltf", "obj", "ply", "stl", "3mf"]),
            Self::Picture => ("PNG image", &["png"]),
            Self::Turntable if IS_PAGE => ("Archive", &["zip"]),
            Self::Turntable => ("Folder", &[]),
            Self::Volume => ("Volume", &["argil", "vdb", "nvdb", "npy", "nrrd", "png"]),
        }
    }
}

/// Access to file dialogs.
pub trait FileAccess {
    /// Asks for a path. Returns `None` if the user cancels, or if the contents arrive later, as in a browser.
    /// `name` is the suggestion.
    fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf>;

    /// Returns the reason why the last dialog failed, once.
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

/// Duration below which a dialog cannot have been visible.
#[cfg(not(target_arch = "wasm32"))]
const UNSEEN: std::time::Duration = std::time::Duration::from_millis(100);

#[cfg(not(target_arch = "wasm32"))]
impl FileAccess for Native {
    fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf> {
        let start = std::time::Instant::now();
        let path = dialog(what, name);
        if path.is_none() && start.elapsed() < UNSEEN {
            let fault = "the system has no file dialog: on Linux it needs a desktop portal or zenity (on Debian and Ubuntu: xdg-desktop-portal-gtk, or zenity)";
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
            // Some dialogs omit the extension.
            match (path.extension(), endings.first()) {
                (None, Some(ending)) => may_replace(path.with_extension(ending)),
                _ => Some(path),
            }
        }
    }
}

/// Asks before replacing a file other than the one that the dialog asked about.
#[cfg(not(target_arch = "wasm32"))]
fn may_replace(path: PathBuf) -> Option<PathBuf> {
    if !path.exists() {
        return Some(path);
    }
    let answer = rfd::MessageDialog::new()
        .set_title("Argil Studio")
        .set_description(format!("{} exists. Replace it?", path.display()))
        .set_buttons(rfd::MessageButtons::YesNo)
        .show();
    (answer == rfd::MessageDialogResult::Yes).then_some(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil::mesh::MeshFormat;

    #[test]
    fn dialogs_list_all_formats_of_meshes() {
        for format in MeshFormat::all() {
            for request in [FileRequest::Import, FileRequest::Mesh] {
                assert!(request.kind().1.contains(&format.extension()), "{format:?}");
            }
        }
    }
}
