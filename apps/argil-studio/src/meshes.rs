//! Meshes of the scene. They are sampled in the background; until they are ready, and if they cannot be read,
//! placeholders stand in.

use crate::jobs::{JobTarget, Loaded};
use crate::mesh_files::other_file;
use crate::mesh_files::*;
use crate::session::{Request, Session};
use argil::scene::{Brush, NodeId, NodeKind};
use std::path::Path;

impl Session {
    /// Returns a loader that reads the scene's meshes again.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn load_again<'a>(&self, _: impl Iterator<Item = &'a str>) -> Load {
        let folder = self.document.mesh_folder();
        from_files(folder, self.document.external.clone())
    }

    /// Returns a loader that reads the meshes from the browser's storage.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn load_again<'a>(&self, paths: impl Iterator<Item = &'a str>) -> Load {
        let name = |path: &'a str| path.rsplit('/').next().unwrap_or(path);
        let kept = paths.filter_map(|path| crate::local_storage::kept_mesh(name(path)));
        crate::mesh_files::from_bytes(kept.collect())
    }

    /// Samples meshes that became missing through an undo or a paste, and inserts placeholders.
    pub(crate) fn load_wanted(&mut self) {
        let wanted = self.document.take_wanted();
        if wanted.is_empty() {
            return;
        }
        self.reload();
        // What was read in this session may be pasted into another scene.
        for (path, _) in &wanted {
            if self.read_meshes.contains(path) {
                self.document.allow_file(Path::new(path));
            }
        }
        let load = self.load_again(wanted.iter().map(|(path, _)| path.as_str()));
        self.load_missing(wanted, load);
    }

    /// Samples missing meshes.
    pub(crate) fn load_missing(&mut self, wanted: Vec<Named>, load: Load) {
        if !wanted.is_empty() {
            let name = format!("Reading {}", self.document.title());
            self.jobs
                .load(name, wanted, load, (self.document.id(), JobTarget::Known));
        }
    }

    /// Gives a brush another mesh, or another resolution, once it is sampled.
    pub(crate) fn resample(&mut self, node: NodeId, named: Named, load: Load) {
        let name = format!("Sampling {}", named.0);
        let aim = (self.document.id(), JobTarget::Brush(node));
        self.jobs.load(name, vec![named], load, aim);
    }

    /// Inserts sampled meshes.
    pub(crate) fn have_meshes(&mut self, loaded: Loaded) -> anyhow::Result<()> {
        let Loaded {
            meshes,
            faults,
            document,
            aim,
        } = loaded;
        if document != self.document.id() {
            return Ok(());
        }
        for mesh in &meshes {
            // An absolute path in another folder is another file.
            if Path::new(&mesh.path).is_absolute() {
                self.read_meshes.insert(mesh.path.clone());
            }
            let place = self.document.mesh_folder().join(&mesh.path);
            self.document.allow_file(&place);
            self.document
                .add_mesh_grid(&mesh.path, mesh.resolution, mesh.grid.clone());
        }
        if !meshes.is_empty() {
            self.reload();
        }
        for fault in &faults {
            self.fail(fault);
            self.stay_open();
        }
        let Some(mesh) = meshes.into_iter().next() else {
            return Ok(());
        };
        // Removed parts and closed holes.
        let warnings = mesh.warnings().join("; ");
        match aim {
            JobTarget::Known => {}
            JobTarget::Brush(node) => {
                anyhow::ensure!(
                    !self.document.is_locked(node),
                    "the node to change is locked"
                );
                let mut entry = self.document.scene().node(node).desc().clone();
                entry.kind = NodeKind::Shape(other_file(&entry.kind, &mesh));
                self.document.replace("Change mesh", node, entry)?;
                if !warnings.is_empty() {
                    self.show_note(format!("{}: {warnings}", mesh.path));
                }
            }
            JobTarget::New(name) => {
                let brush = Brush::new(mesh.shape()).with_name(name);
                self.document.add_entry("Import mesh", brush.into())?;
                self.requests.push(Request::ShowNew);
                self.show_note(if warnings.is_empty() {
                    format!("Imported {}", mesh.path)
                } else {
                    format!("Imported {}: {warnings}", mesh.path)
                });
            }
        }
        Ok(())
    }

    /// Reloads the renderer and the picker with the whole document, including state that the log does not contain.
    pub(crate) fn reload(&mut self) {
        self.version += 1000;
        // The scene already contains the actions of this frame.
        drop(self.document.take_actions());
        self.renderer
            .load(self.document.scene(), self.version, None);
        self.picker.forget();
    }
}
