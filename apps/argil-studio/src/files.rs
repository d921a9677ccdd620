//! Files that are opened, saved, imported and exported.

use crate::app::Studio;
use crate::dialogs::{Dialog, Then};
use crate::document::Document;
use crate::jobs::{Aim, How};
use crate::meshes::{Load, folder_of, from_files, moved_paths, usual_resolution};
use crate::recovery::{Left, Recovery};
#[cfg(not(target_arch = "wasm32"))]
use argil::Format;
use argil::glam::Vec3;
use argil::{Brush, Journal, NodeId, Scene, Shape};
use std::path::{Path, PathBuf};

/// Whether it runs in a browser, which has no files: those that are opened are read whole, those that are written are downloads.
pub const IS_PAGE: bool = cfg!(target_arch = "wasm32");

/// What a file is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
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

impl Ask {
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
pub trait Files {
    /// A place; none where the asking was given up, or where what was chosen comes later, as bytes, by
    /// themselves. `name` is what is proposed.
    fn ask(&mut self, what: Ask, name: &str) -> Option<PathBuf>;

    /// Why nobody was asked the last time, once.
    fn take_fault(&mut self) -> Option<String> {
        None
    }
}

/// The system's own dialogs.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Default)]
pub struct Native {
    fault: Option<String>,
}

/// Nobody gives a dialog up so fast: there was none.
#[cfg(not(target_arch = "wasm32"))]
const UNSEEN: std::time::Duration = std::time::Duration::from_millis(100);

#[cfg(not(target_arch = "wasm32"))]
impl Files for Native {
    fn ask(&mut self, what: Ask, name: &str) -> Option<PathBuf> {
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
fn dialog(what: Ask, name: &str) -> Option<PathBuf> {
    let (kind, endings) = what.kind();
    let mut dialog = rfd::FileDialog::new();
    if !endings.is_empty() {
        dialog = dialog.add_filter(kind, endings);
    }
    match what {
        Ask::Open | Ask::Import => dialog.pick_file(),
        Ask::Turntable => dialog.pick_folder(),
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

impl Studio {
    /// Whether what is open may be put away now; else it is asked.
    pub(crate) fn may_leave(&mut self, then: Then) -> bool {
        let is_changed = self.document.is_changed();
        if is_changed {
            self.dialog = Some(Dialog::Unsaved(then));
        }
        !is_changed
    }

    /// Ask for a scene and open it.
    pub(crate) fn ask_to_open(&mut self) {
        if let Some(path) = self.ask(Ask::Open, "") {
            self.open(&path);
        }
    }

    /// Open a scene's file.
    pub(crate) fn open(&mut self, path: &Path) {
        self.open_with(path, false);
    }

    /// The same, with its meshes anywhere if so.
    pub(crate) fn open_with(&mut self, path: &Path, outside: bool) {
        self.attempt(|s| {
            let scene = Scene::open(path)?;
            // Meshes that lie elsewhere are read for scenes that were saved or opened here before.
            let known = std::path::absolute(path).is_ok_and(|p| s.preferences.recent.contains(&p));
            s.replace_scene(scene, Some(path.into()));
            s.document.reads_anywhere = known || outside;
            let wanted = s.document.take_wanted();
            s.load_missing(wanted, from_files(folder_of(path).into(), known || outside));
            s.preferences.remember(path);
            s.tell(format!("{} is open", path.display()));
            Ok(())
        });
    }

    /// A file that was dropped on the window.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn open_or_import(&mut self, path: &Path) {
        if Format::of(path).is_some() || argil::is_image(&path.to_string_lossy()) {
            self.attempt(|s| s.import(path));
        } else if self.may_leave(Then::Open(path.into())) {
            self.open(path);
        }
    }

    /// Save, asking where if that is not known.
    pub(crate) fn save_scene(&mut self, elsewhere: bool) -> bool {
        let known = self.document.path().filter(|_| !elsewhere);
        let path = match known.map(Path::to_path_buf) {
            Some(path) => Some(path),
            None => {
                let title = self.document.title();
                let name = title.strip_suffix(".json").unwrap_or(&title).to_owned();
                self.ask(Ask::Save, &format!("{name}.json"))
            }
        };
        let Some(path) = path else { return false };
        self.attempt(|s| {
            let is_elsewhere = !moved_paths(&s.document, &path).is_empty();
            anyhow::ensure!(
                !(is_elsewhere && s.jobs.are_meshes_read()),
                "meshes are being read from the folder that the scene is in: wait until that is done, or cancel it"
            );
            s.document.save(&path)?;
            if !IS_PAGE {
                s.preferences.remember(&path);
            }
            s.tell(format!("{} is saved", path.display()));
            Ok(())
        });
        !self.document.is_changed()
    }

    /// Ask for a mesh and import it.
    pub(crate) fn ask_to_import(&mut self) {
        if let Some(path) = self.ask(Ask::Import, "") {
            self.attempt(|s| s.import(&path));
        }
    }

    /// Put a mesh into the scene, sampled beside the window.
    pub(crate) fn import(&mut self, path: &Path) -> anyhow::Result<()> {
        let load = from_files(self.mesh_folder(), true);
        self.import_by(path, self.mesh_name(path)?, load)
    }

    /// The same, however it is read.
    pub(crate) fn import_by(
        &mut self,
        path: &Path,
        named: String,
        load: Load,
    ) -> anyhow::Result<()> {
        let stem = path.file_stem().unwrap_or_default();
        let aim = Aim::New(stem.to_string_lossy().into_owned());
        let job = format!("Importing {}", path.display());
        let own = self.document.id();
        let resolution = usual_resolution(&named);
        self.jobs
            .load(job, vec![(named, resolution)], load, (own, aim));
        Ok(())
    }

    /// Choose the file of a brush that is a mesh.
    pub(crate) fn relocate(&mut self, node: NodeId, resolution: u32) {
        if let Some(path) = self.ask(Ask::Import, "") {
            self.attempt(|s| {
                let named = (s.mesh_name(&path)?, resolution);
                s.resample(node, named, from_files(s.mesh_folder(), true));
                Ok(())
            });
        }
    }

    /// Put a shape where it is to be.
    pub(crate) fn add_shape(&mut self, shape: Shape, at: Vec3) -> anyhow::Result<()> {
        // As large as a fifth of what is in view.
        let size = (0.4 * self.eye.half_height()).clamp(1e-3, 1e3);
        let size = (size * 100.0).round() / 100.0;
        let brush = Brush::new(shape).scaled(size.max(0.01)).at(at.to_array());
        self.add_entry("Add shape", brush.into())
    }

    /// Ask for a place and export to it.
    pub(crate) fn export(&mut self, what: Ask) {
        if let Err(error) = self.ensure_whole() {
            return self.fail(&error);
        }
        let title = self.document.title();
        let stem = title.strip_suffix(".json").unwrap_or(&title);
        let endings = what.kind().1;
        let ending = endings.first().copied().unwrap_or("");
        let Some(path) = self.ask(what, &format!("{stem}.{ending}")) else {
            return;
        };
        let own = path.extension().unwrap_or_default().to_string_lossy();
        if !endings.is_empty() && !endings.contains(&own.to_ascii_lowercase().as_str()) {
            let known = endings.join(", .");
            let path = path.display();
            return self.fail(&anyhow::anyhow!("{path}: the name is to end in .{known}"));
        }
        let how = How {
            engine: self.export_engine.clone(),
            resolution: self.preferences.resolution,
            eye: self.eye,
        };
        let scene = self.document.scene().clone();
        self.jobs.export(what, scene, path, how);
    }

    /// Ask for a file, and say so where no dialog came.
    fn ask(&mut self, what: Ask, name: &str) -> Option<PathBuf> {
        let path = self.files.ask(what, name);
        if let Some(fault) = self.files.take_fault() {
            self.fail(&anyhow::anyhow!(fault));
        }
        path
    }

    /// Bring back what a session left.
    pub(crate) fn recover(&mut self, left: Left) -> anyhow::Result<()> {
        let left = left.claim()?;
        let recovered = Journal::recover(&left.journal)?;
        let edits = recovered.edits;
        let (scene, journal) = recovered.go_on()?;
        self.document.close();
        let journal = Recovery::of(journal);
        self.take_in(Document::recovered(scene, left.scene, journal));
        self.document.reads_anywhere = true;
        self.tell(format!("{edits} edits came back"));
        Ok(())
    }
}
