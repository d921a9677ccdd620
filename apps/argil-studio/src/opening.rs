//! Opens, saves, imports and exports files.

use crate::dialog::{AfterDialog, Dialog};
use crate::document::Document;
use crate::files::*;
use crate::jobs::{ExportOptions, JobTarget};
use crate::mesh_files::{Load, folder_of, from_files, moved_paths, usual_resolution};
use crate::recovery::{RecoverableSession, Recovery};
use crate::session::Session;
use crate::viewport_camera::ViewportCamera;
#[cfg(not(target_arch = "wasm32"))]
use argil::mesh::MeshFormat;
use argil::scene::{Journal, NodeId, Scene};
use eframe::egui;
use std::path::{Path, PathBuf};

impl Session {
    /// Returns true if the document can be closed now. Otherwise asks whether to save it.
    pub(crate) fn may_leave(&mut self, then: AfterDialog) -> bool {
        let is_changed = self.document.is_changed();
        if is_changed {
            self.dialog = Some(Dialog::Unsaved(then));
        }
        !is_changed
    }

    /// Closes the document, after asking whether to save changes, and continues.
    pub(crate) fn leave_for(&mut self, ctx: &egui::Context, then: AfterDialog) {
        if self.may_leave(then.clone()) {
            self.go_on(ctx, then);
        }
    }

    /// Asks for a scene and opens it.
    pub(crate) fn ask_to_open(&mut self) {
        if let Some(path) = self.ask(FileRequest::Open, "") {
            self.open(&path);
        }
    }

    /// Opens a scene file.
    pub(crate) fn open(&mut self, path: &Path) {
        self.open_with(path, false);
    }

    /// Opens a scene file. If `outside` is true, its meshes may lie anywhere.
    pub(crate) fn open_with(&mut self, path: &Path, outside: bool) {
        self.attempt(|s| {
            #[cfg(not(target_arch = "wasm32"))]
            if crate::world_files::is_world(path) {
                return s.open_world(path);
            }
            let mut scene = Scene::open(path)?;
            let external = match outside {
                true => true.into(),
                false => s.preferences.external_files(),
            };
            let images = argil::load_images(&mut scene, folder_of(path), external.clone());
            s.replace_scene(scene, Some(path.into()));
            s.document.external = external.clone();
            let wanted = s.document.take_wanted();
            s.load_missing(wanted, from_files(folder_of(path).into(), external));
            s.preferences.remember(path);
            s.show_note(format!("Opened {}", path.display()));
            // What is missing is gray.
            Ok(images?)
        });
    }

    /// Opens or imports a file that was dropped on the window.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn open_or_import(&mut self, path: &Path) {
        let is_sampled = MeshFormat::from_path(path).is_some() || argil::is_volume_file(path);
        if is_sampled || argil::scene::is_image(&path.to_string_lossy()) {
            self.attempt(|s| s.import(path));
        } else if self.may_leave(AfterDialog::Open(path.into())) {
            self.open(path);
        }
    }

    /// Saves the document. Asks for a path if it has none.
    pub(crate) fn save_scene(&mut self, elsewhere: bool) -> bool {
        if self.world.is_some() && !elsewhere {
            self.attempt(Self::save_world);
            return !self.document.is_changed();
        }
        let known = self.document.path().filter(|_| !elsewhere);
        let path = match known.map(Path::to_path_buf) {
            Some(path) => Some(path),
            None => {
                let title = self.document.title();
                let name = title.strip_suffix(".json").unwrap_or(&title).to_owned();
                self.ask(FileRequest::Save, &format!("{name}.json"))
            }
        };
        let Some(path) = path else { return false };
        self.attempt(|s| {
            let is_elsewhere =
                !moved_paths(s.document.scene(), s.document.path(), &path).is_empty();
            anyhow::ensure!(
                !(is_elsewhere && s.jobs.are_meshes_read()),
                "meshes of the scene are still loading: wait, or cancel the job"
            );
            if is_elsewhere {
                // They were in the scene's folder, or chosen.
                for place in s.document.loaded_mesh_places() {
                    s.allow_file(&place);
                }
            }
            s.document.save(&path)?;
            if !IS_PAGE {
                s.preferences.remember(&path);
            }
            s.show_note(format!("Saved {}", path.display()));
            Ok(())
        });
        !self.document.is_changed()
    }

    /// Asks for a mesh and imports it.
    pub(crate) fn ask_to_import(&mut self) {
        if let Some(path) = self.ask(FileRequest::Import, "") {
            self.attempt(|s| s.import(&path));
        }
    }

    /// Allows scenes to read a file that the user chose, now and when they are opened again.
    fn allow_file(&mut self, path: &Path) {
        self.preferences.allow_file(path);
        self.document.allow_file(path);
    }

    /// Imports a mesh, which is sampled in the background.
    pub(crate) fn import(&mut self, path: &Path) -> anyhow::Result<()> {
        self.allow_file(path);
        let load = from_files(self.document.mesh_folder(), self.document.external.clone());
        self.import_by(path, self.document.mesh_name(path)?, load)
    }

    /// Imports a mesh through a loader.
    pub(crate) fn import_by(
        &mut self,
        path: &Path,
        named: String,
        load: Load,
    ) -> anyhow::Result<()> {
        let stem = path.file_stem().unwrap_or_default();
        let aim = JobTarget::New(stem.to_string_lossy().into_owned());
        let job = format!("Importing {}", path.display());
        let document = self.document.id();
        let resolution = usual_resolution(&named);
        self.jobs
            .load(job, vec![(named, resolution)], load, (document, aim));
        Ok(())
    }

    /// Chooses another file for a mesh brush.
    pub(crate) fn relocate(&mut self, node: NodeId, resolution: u32) {
        if let Some(path) = self.ask(FileRequest::Import, "") {
            self.attempt(|s| {
                let named = (s.document.mesh_name(&path)?, resolution);
                s.allow_file(&path);
                let external = s.document.external.clone();
                s.resample(node, named, from_files(s.document.mesh_folder(), external));
                Ok(())
            });
        }
    }

    /// Asks for a path and exports to it.
    pub(crate) fn export(&mut self, what: FileRequest, eye: ViewportCamera) {
        if let Err(error) = self.document.ensure_whole() {
            return self.fail(&error);
        }
        let title = self.document.title();
        let stem = title.strip_suffix(".json").unwrap_or(&title);
        let endings = what.kind().1;
        let ending = endings.first().copied().unwrap_or("");
        let Some(path) = self.ask(what, &format!("{stem}.{ending}")) else {
            return;
        };
        let given = path.extension().unwrap_or_default().to_string_lossy();
        if !endings.is_empty() && !endings.contains(&given.to_ascii_lowercase().as_str()) {
            let known = endings.join(", .");
            let path = path.display();
            return self.fail(&anyhow::anyhow!("{path}: the name must end in .{known}"));
        }
        let how = ExportOptions {
            engine: self.export_engine.clone(),
            resolution: self.preferences.resolution,
            eye,
        };
        let scene = self.document.scene().clone();
        self.jobs.export(what, scene, path, how);
    }

    /// Asks for a file, and reports if no dialog appeared.
    pub(crate) fn ask(&mut self, what: FileRequest, name: &str) -> Option<PathBuf> {
        let path = self.files.ask(what, name);
        if let Some(fault) = self.files.take_fault() {
            self.fail(&anyhow::anyhow!(fault));
        }
        path
    }

    /// Recovers an earlier session.
    pub(crate) fn recover(&mut self, left: RecoverableSession) -> anyhow::Result<()> {
        let left = left.claim()?;
        let recovered = Journal::recover(&left.journal)?;
        let edits = recovered.edits;
        let (scene, journal) = recovered.resume()?;
        self.document.close();
        let journal = Recovery::of(journal);
        let journal = journal.with_external(left.external.clone());
        self.set_document(Document::recovered(scene, left.scene, journal), None);
        for file in &left.external {
            self.document.allow_file(file);
        }
        self.show_note(match edits {
            1 => "Restored 1 edit".to_owned(),
            _ => format!("Restored {edits} edits"),
        });
        Ok(())
    }
}
