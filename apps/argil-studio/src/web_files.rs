//! Files that consist of a name and bytes, as a browser provides them.

use crate::browser::NamedBytes;
use crate::dialog::AfterDialog;
use crate::document::Document;
use crate::mesh_files::from_bytes;
use crate::session::Session;
use anyhow::Context;
use argil::mesh::MeshFormat;
use argil::scene::{Scene, is_image};
use std::path::Path;

impl Session {
    /// Opens a scene with its meshes, or adds missing meshes, or imports other meshes.
    pub(crate) fn open_bytes(&mut self, files: Vec<NamedBytes>) {
        let is_mesh = |name: &str| {
            let path = Path::new(name);
            MeshFormat::from_path(path).is_some() || argil::is_volume_file(path) || is_image(name)
        };
        let (meshes, scenes): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|(name, _)| is_mesh(name));
        if let Some(scene) = scenes.into_iter().next() {
            if self.may_leave(AfterDialog::NamedBytes(scene.clone(), meshes.clone())) {
                self.open_given(&scene, &meshes);
            }
            return;
        }
        self.attempt(|s| {
            let missing = s.document.missing_meshes();
            let is_missing = |name: &str| missing.iter().any(|(path, _)| is_file(path, name));
            let meshes: Vec<NamedBytes> = meshes
                .into_iter()
                .map(|given_name| s.document.own_name(given_name))
                .collect();
            for given in &meshes {
                s.attempt(|_| crate::local_storage::keep_mesh(given));
            }
            let (found, new): (Vec<_>, Vec<_>) =
                meshes.into_iter().partition(|(name, _)| is_missing(name));
            if !found.is_empty() {
                let wanted = missing.into_iter();
                let wanted =
                    wanted.filter(|(path, _)| found.iter().any(|(name, _)| is_file(path, name)));
                s.load_missing(wanted.collect(), from_bytes(found.clone()));
            }
            for (name, bytes) in new {
                let load = from_bytes(vec![(name.clone(), bytes)]);
                s.import_by(Path::new(&name), name.clone(), load)?;
            }
            Ok(())
        });
    }

    /// Opens a scene's text, with the meshes given with it.
    pub(crate) fn open_given(&mut self, (name, text): &NamedBytes, meshes: &[NamedBytes]) {
        self.attempt(|s| {
            let text = std::str::from_utf8(text).with_context(|| format!("{name} is not text"))?;
            let scene = Scene::from_json(text, name)?;
            for given in meshes {
                s.attempt(|_| crate::local_storage::keep_mesh(given));
            }
            s.replace_scene(scene, Some(name.into()));
            s.show_note(format!("Opened {name}"));
            let wanted = s.document.take_wanted();
            s.load_missing(wanted, from_bytes(meshes.to_vec()));
            Ok(())
        });
    }

    /// Opens the scene stored by an earlier visit.
    pub(crate) fn open_kept(&mut self, scene: Scene) {
        let missing = scene.missing_meshes();
        let is_named = |name: &str| missing.iter().any(|(path, _)| is_file(path, name));
        let meshes = crate::local_storage::kept_meshes(is_named);
        self.replace_scene(scene, None);
        if crate::local_storage::LocalStorage::is_unsaved() {
            self.document.is_unsaved();
        }
        let wanted = self.document.take_wanted();
        self.load_missing(wanted, from_bytes(meshes));
    }
}

impl Document {
    /// Renames a mesh to a name that is unique in the scene, because a browser gives files without their folders.
    pub(crate) fn own_name(&self, (name, bytes): NamedBytes) -> NamedBytes {
        let scene = self.scene();
        let missing = self.missing_meshes();
        let is_free = |name: &str| {
            let is_known = scene.known_mesh_paths().any(|path| is_file(path, name));
            let is_missing = missing.iter().any(|(path, _)| is_file(path, name));
            let is_same =
                || crate::local_storage::kept_mesh(name).is_some_and(|(_, stored)| stored == bytes);
            !is_known || is_missing || is_same()
        };
        let path = Path::new(&name);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let others = (2..).map(|i| format!("{stem}-{i}.{ending}"));
        let free = std::iter::once(name.clone())
            .chain(others)
            .find(|name| is_free(name));
        (free.unwrap_or(name), bytes)
    }
}

/// Returns true if a path ends in a file name.
fn is_file(path: &str, name: &str) -> bool {
    Path::new(path).file_name() == Some(name.as_ref())
}
