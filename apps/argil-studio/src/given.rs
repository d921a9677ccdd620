//! Files of which there are only the names and the bytes: those that a browser gives.

use crate::app::Studio;
use crate::dialogs::Then;
use crate::files::mesh_brush;
use anyhow::Context;
use argil::{Format, Scene, load_meshes_of};
use std::path::Path;

/// A file's name and what is in it.
pub type Given = (String, Vec<u8>);

impl Studio {
    /// Take a scene with the meshes that it names, meshes that what is open lacks, or others to be imported.
    pub(crate) fn open_bytes(&mut self, files: Vec<Given>) {
        let is_mesh = |name: &str| Format::of(Path::new(name)).is_some();
        let (meshes, scenes): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|(name, _)| is_mesh(name));
        if let Some(scene) = scenes.into_iter().next() {
            if self.may_leave(Then::Given(scene.clone(), meshes.clone())) {
                self.open_given(&scene, &meshes);
            }
            return;
        }
        self.attempt(|s| {
            let mut scene = s.document.scene().clone();
            let found = load_meshes_of(&mut scene, &meshes)?;
            for mesh in &found {
                s.have_mesh(&mesh.path, mesh.resolution, mesh.grid.clone());
                s.tell(format!("{} is there again", mesh.path));
            }
            for given in &meshes {
                s.attempt(|_| crate::page::keep_mesh(given));
            }
            for (name, bytes) in meshes {
                let is_name = |path: &str| Path::new(path).file_name() == Some(name.as_ref());
                if !found.iter().any(|mesh| is_name(&mesh.path)) {
                    let mesh = mesh_brush(Path::new(&name), name.clone())?;
                    s.jobs.import(&name.clone(), mesh, move |scene| {
                        load_meshes_of(scene, &[(name, bytes)])?;
                        Ok(())
                    });
                }
            }
            Ok(())
        });
    }

    /// Open a scene's text, with the meshes that were given with it.
    pub(crate) fn open_given(&mut self, (name, text): &Given, meshes: &[Given]) {
        self.attempt(|s| {
            let text = std::str::from_utf8(text).with_context(|| format!("{name} is no text"))?;
            let mut scene = Scene::from_json(text, name)?;
            load_meshes_of(&mut scene, meshes)?;
            for given in meshes {
                s.attempt(|_| crate::page::keep_mesh(given));
            }
            s.replace_scene(scene, Some(name.into()));
            s.tell(format!("{name} is open"));
            s.tell_missing();
            Ok(())
        });
    }

    /// Open what another visit of the page has left.
    pub(crate) fn open_kept(&mut self, mut scene: Scene) {
        let missing = scene.missing_meshes();
        let is_named = |name: &str| {
            let mut files = missing.iter().map(|(path, _)| Path::new(path).file_name());
            files.any(|own| own == Some(name.as_ref()))
        };
        let meshes = crate::page::kept_meshes(is_named);
        self.attempt(|_| Ok(drop(load_meshes_of(&mut scene, &meshes)?)));
        self.replace_scene(scene, None);
        if crate::page::Keeper::is_unsaved() {
            self.document.is_unsaved();
        }
        self.tell_missing();
    }

    /// Say which meshes are not there.
    fn tell_missing(&mut self) {
        let missing = self.document.scene().missing_meshes();
        if let Some((path, _)) = missing.first() {
            self.fail(&anyhow::anyhow!(
                "the mesh {path} is not there: open it too, or drop it on the page"
            ));
        }
    }
}
