//! Files that are opened, saved, imported and exported.

use crate::app::Studio;
use crate::dialogs::{Dialog, Then};
use crate::document::Document;
use crate::jobs::How;
use crate::recovery::{Left, Recovery};
use anyhow::Context;
#[cfg(not(target_arch = "wasm32"))]
use argil::Format;
use argil::glam::Vec3;
use argil::{Brush, Journal, SampledGrid, Scene, Shape, load_meshes};
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
            Self::Import => ("Mesh", &["obj", "glb", "ply", "stl"]),
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
}

/// The system's own dialogs.
#[cfg(not(target_arch = "wasm32"))]
pub struct Native;

#[cfg(not(target_arch = "wasm32"))]
impl Files for Native {
    fn ask(&mut self, what: Ask, name: &str) -> Option<PathBuf> {
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
        if let Some(path) = self.files.ask(Ask::Open, "") {
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
            let mut scene = Scene::open(path)?;
            // Meshes that lie elsewhere are read for scenes that were saved or opened here before.
            let known = std::path::absolute(path).is_ok_and(|p| s.preferences.recent.contains(&p));
            load_meshes(&mut scene, folder_of(path), known || outside)?;
            s.replace_scene(scene, Some(path.into()));
            s.preferences.remember(path);
            s.tell(format!("{} is open", path.display()));
            Ok(())
        });
    }

    /// A file that was dropped on the window.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn open_or_import(&mut self, path: &Path) {
        if Format::of(path).is_some() {
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
                self.files.ask(Ask::Save, &format!("{name}.json"))
            }
        };
        let Some(path) = path else { return false };
        self.attempt(|s| {
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
        if let Some(path) = self.files.ask(Ask::Import, "") {
            self.attempt(|s| s.import(&path));
        }
    }

    /// Put a mesh into the scene, sampled beside the window.
    pub(crate) fn import(&mut self, path: &Path) -> anyhow::Result<()> {
        let own = self.document.path().and_then(Path::parent);
        let absolute = std::path::absolute(path)?;
        let named = own
            .and_then(|folder| {
                absolute
                    .strip_prefix(std::path::absolute(folder).ok()?)
                    .ok()
            })
            .unwrap_or(&absolute);
        let named = named.to_string_lossy().replace('\\', "/");
        let folder = own.unwrap_or(Path::new(".")).to_path_buf();
        let scene = mesh_brush(path, named)?;
        self.jobs
            .import(&path.display().to_string(), scene, move |scene| {
                load_meshes(scene, &folder, true)?;
                Ok(())
            });
        Ok(())
    }

    /// Have a mesh's distances, here and where it is drawn.
    pub(crate) fn have_mesh(&mut self, path: &str, resolution: u32, grid: Arc<SampledGrid>) {
        self.document.know_mesh(path, resolution, grid);
        // The copy that is drawn is to know it too.
        self.version += 1000;
        // What was done in this frame is in the scene already.
        drop(self.document.take_lines());
        self.renderer.load(self.document.scene(), self.version);
        self.picker.forget();
    }

    /// A mesh has been sampled: put it in, as large as what is there.
    pub(crate) fn imported(&mut self, scene: &Scene) -> anyhow::Result<()> {
        let grids = scene
            .walk()
            .find_map(|n| match &scene.node(n).entry().body {
                argil::Body::Shape(Shape::Mesh {
                    path,
                    resolution,
                    grid,
                }) => Some((path.clone(), *resolution, grid.0.clone()?)),
                _ => None,
            });
        let (path, resolution, grid) = grids.context("the mesh has no samples")?;
        self.have_mesh(&path, resolution, grid);
        let node = scene.node(Scene::ROOT).children()[0];
        let entry = scene.node(node).entry().clone();
        self.add_entry("Import mesh", entry)?;
        self.tell(format!("{path} is in the scene"));
        Ok(())
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
        let title = self.document.title();
        let stem = title.strip_suffix(".json").unwrap_or(&title);
        let ending = what.kind().1.first().copied().unwrap_or("");
        if let Some(path) = self.files.ask(what, &format!("{stem}.{ending}")) {
            let how = How {
                engine: self.export_engine.clone(),
                resolution: self.preferences.resolution,
                eye: self.eye,
            };
            let scene = self.document.scene().clone();
            self.jobs.export(what, scene, path, how);
        }
    }

    /// Bring back what a session left.
    pub(crate) fn recover(&mut self, left: Left) -> anyhow::Result<()> {
        let recovered = Journal::recover(&left.journal)?;
        let edits = recovered.edits;
        let (mut scene, journal) = recovered.go_on()?;
        if !scene.missing_meshes().is_empty() {
            let beside = left.scene.as_deref().map_or(Path::new("."), folder_of);
            load_meshes(&mut scene, beside, true)?;
        }
        self.document.close();
        self.take_in(Document::recovered(
            scene,
            left.scene,
            Recovery::of(journal),
        ));
        self.tell(format!("{edits} edits came back"));
        Ok(())
    }
}

/// A scene of one brush: a mesh that is named so.
pub(crate) fn mesh_brush(path: &Path, named: String) -> anyhow::Result<Scene> {
    let mut scene = Scene::new();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    scene.push(Brush::new(Shape::mesh(named)).named(stem))?;
    Ok(scene)
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().unwrap_or(Path::new("."));
    if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    }
}
