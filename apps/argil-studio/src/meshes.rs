//! The meshes that the scene names: sampled beside the window; until they are there, and where they cannot be read, nothing
//! stands in for them.

use crate::app::Studio;
use crate::document::Document;
use crate::files::IS_PAGE;
use crate::jobs::{Aim, Loaded};
use argil::glam::{UVec3, Vec3};
use argil::{
    Aabb, Body, Brush, LoadedMesh, MeshFileError, NodeId, SampledGrid, Scene, Shape, is_image,
    load_meshes,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh's path and resolution, as a scene names it.
pub type Named = (String, u32);

/// Distances to nothing; of an image that is not there, flat ground.
pub fn nothing(path: &str) -> Arc<SampledGrid> {
    let flat = || SampledGrid::of_heights([2, 2], &[0.0; 4]);
    if let Some(flat) = is_image(path).then(flat).flatten() {
        return Arc::new(flat);
    }
    let far = |points: &[Vec3], out: &mut [f32]| {
        debug_assert_eq!(points.len(), out.len());
        out.fill(1.0);
    };
    let nowhere = Aabb::new(Vec3::ZERO, Vec3::ZERO);
    let grid = SampledGrid::sample(Vec3::splat(-0.5), 1.0, UVec3::ONE, nowhere, &far);
    Arc::new(grid)
}

/// Samples along the longest side where nothing else is said, or posts.
pub fn usual_resolution(path: &str) -> u32 {
    Shape::of_file(path).file().map_or(64, |(_, own, _)| own)
}

/// A scene of one brush.
pub fn scene_of((path, resolution): &Named) -> anyhow::Result<Scene> {
    let mut scene = Scene::new();
    let mut shape = Shape::of_file(path.clone());
    if let Some((_, own, _)) = shape.file_mut() {
        *own = *resolution;
    }
    scene.push(Brush::new(shape))?;
    Ok(scene)
}

/// What reads and samples the meshes of a scene.
pub type Load = Box<dyn FnMut(&mut Scene) -> Result<Vec<LoadedMesh>, MeshFileError> + Send>;

/// From files: beside a scene, and with `outside`, anywhere.
pub fn from_files(folder: PathBuf, outside: bool) -> Load {
    Box::new(move |scene| load_meshes(scene, &folder, outside))
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().unwrap_or(Path::new("."));
    if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    }
}

impl Studio {
    /// Where the scene's meshes are, as their paths say.
    pub(crate) fn mesh_folder(&self) -> PathBuf {
        self.document
            .path()
            .map_or(Path::new("."), folder_of)
            .into()
    }

    /// What to call a mesh's file in the scene: from the scene's own folder, if it is in it.
    pub(crate) fn mesh_name(&self, path: &Path) -> std::io::Result<String> {
        let absolute = std::path::absolute(path)?;
        let own = self.document.path().and_then(Path::parent);
        let within = match own.map(std::path::absolute) {
            Some(folder) => absolute.strip_prefix(folder?).ok(),
            None => None,
        };
        let named = within.unwrap_or(&absolute).to_string_lossy();
        Ok(named.replace('\\', "/"))
    }

    /// What reads meshes of the scene once more.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn load_again<'a>(&self, _: impl Iterator<Item = &'a str>) -> Load {
        from_files(self.mesh_folder(), true)
    }

    /// The same, from what the browser has kept.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn load_again<'a>(&self, paths: impl Iterator<Item = &'a str>) -> Load {
        let name = |path: &'a str| path.rsplit('/').next().unwrap_or(path);
        let kept = paths.filter_map(|path| crate::page::kept_mesh(name(path)));
        crate::given::from_bytes(kept.collect())
    }

    /// Sample meshes that came to be missing, by an undo or as something was pasted, and have nothing stand in for them.
    pub(crate) fn load_wanted(&mut self) {
        let wanted = self.document.take_wanted();
        if wanted.is_empty() {
            return;
        }
        self.reload();
        let is_read = |(path, _): &Named| self.read_meshes.contains(path);
        let may = self.document.reads_anywhere || wanted.iter().all(is_read);
        let load = if IS_PAGE || may {
            self.load_again(wanted.iter().map(|(path, _)| path.as_str()))
        } else {
            from_files(self.mesh_folder(), false)
        };
        self.load_missing(wanted, load);
    }

    /// Sample meshes that are missing.
    pub(crate) fn load_missing(&mut self, wanted: Vec<Named>, load: Load) {
        if !wanted.is_empty() {
            let name = format!("Reading {}", self.document.title());
            self.jobs
                .load(name, wanted, load, (self.document.id(), Aim::Known));
        }
    }

    /// Have a brush be of another mesh, or of the same at another resolution, once it is sampled.
    pub(crate) fn resample(&mut self, node: NodeId, named: Named, load: Load) {
        let name = format!("Sampling {}", named.0);
        let aim = (self.document.id(), Aim::Brush(node));
        self.jobs.load(name, vec![named], load, aim);
    }

    /// Have the distances that came.
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
            // Others mean other files in other folders.
            if Path::new(&mesh.path).is_absolute() {
                self.read_meshes.insert(mesh.path.clone());
            }
            self.document
                .know_mesh(&mesh.path, mesh.resolution, mesh.grid.clone());
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
        // What was left out of it, or filled.
        let warnings = mesh.warnings().join("; ");
        match aim {
            Aim::Known => {}
            Aim::Brush(node) => {
                anyhow::ensure!(
                    !self.document.is_locked(node),
                    "what is to be changed is locked"
                );
                let mut entry = self.document.scene().node(node).entry().clone();
                entry.body = Body::Shape(other_file(&entry.body, &mesh));
                self.document.replace("Change mesh", node, entry)?;
                if !warnings.is_empty() {
                    self.tell(format!("{}: {warnings}", mesh.path));
                }
            }
            Aim::New(name) => {
                let brush = Brush::new(mesh.shape()).named(name);
                self.add_entry("Import mesh", brush.into())?;
                self.frame_what_is_off();
                self.tell(if warnings.is_empty() {
                    format!("{} is in the scene", mesh.path)
                } else {
                    format!("{} is in the scene: {warnings}", mesh.path)
                });
            }
        }
        Ok(())
    }

    /// Have what is drawn and picked be of the document as it is, with all that no line says.
    pub(crate) fn reload(&mut self) {
        self.version += 1000;
        // What was done in this frame is in the scene already.
        drop(self.document.take_lines());
        self.renderer.load(self.document.scene(), self.version);
        self.picker.forget();
    }

    /// Look at what is selected where little of it would be seen: it came in its own unit.
    fn frame_what_is_off(&mut self) {
        let Some(node) = self.document.active() else {
            return;
        };
        let Some(own) = self.picker.box_of(self.document.scene(), node) else {
            return;
        };
        let in_view = self.eye.half_height();
        let is_near = own.center().distance(self.eye.target) < in_view;
        if !is_near || !(0.05..=1.0).contains(&(own.half_diagonal() / in_view)) {
            self.eye.frame(own);
        }
    }

    /// Whether all meshes are there, for work that would leave out those that are not.
    pub(crate) fn ensure_whole(&self) -> anyhow::Result<()> {
        match self.document.missing_meshes().first() {
            None => Ok(()),
            Some((path, _)) => anyhow::bail!(
                "the mesh {path} is not there: choose its file in the inspector, or take its brush out"
            ),
        }
    }
}

/// What a brush is of another file: as long and high as before, if it is of the same kind.
fn other_file(before: &Body, mesh: &LoadedMesh) -> Shape {
    let own = mesh.shape();
    let Body::Shape(before) = before else {
        return own;
    };
    let mut kept = before.clone();
    match (kept.file_mut(), own.file()) {
        (Some((path, resolution, grid)), Some((to, size, loaded)))
            if is_image(path) == is_image(to) =>
        {
            (*path, *resolution, *grid) = (to.to_owned(), size, loaded.clone());
            kept
        }
        _ => own,
    }
}

/// Give the paths of a scene's meshes as they are to be from another folder.
pub fn moved_paths(document: &Document, to: &Path) -> BTreeMap<String, String> {
    let Some(from) = document.path().map(folder_of) else {
        return BTreeMap::new();
    };
    let (Ok(from), Ok(to)) = (
        std::path::absolute(from),
        std::path::absolute(folder_of(to)),
    ) else {
        return BTreeMap::new();
    };
    if from == to {
        return BTreeMap::new();
    }
    let paths = document.scene().known_mesh_paths();
    paths
        .filter(|path| Path::new(path).is_relative())
        .map(|path| {
            let place = from.join(path);
            let named = place.strip_prefix(&to).unwrap_or(&place);
            let named = named.to_string_lossy().replace('\\', "/");
            (path.to_owned(), named)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::Eye;
    use crate::painter::Pipeline;
    use argil::{Engine, Show};

    #[test]
    fn what_stands_in_is_seen_by_none() {
        let mut lone = Scene::new();
        lone.push(Brush::new(Shape::sphere(0.5))).expect("a ball");
        let mut scene = lone.clone();
        scene
            .push(Brush::new(Shape::mesh("gone.obj")))
            .expect("a mesh");
        scene.set_mesh(
            "gone.obj",
            usual_resolution("gone.obj"),
            nothing("gone.obj"),
        );
        assert!(scene.missing_meshes().is_empty());
        for pipeline in Pipeline::ALL {
            let hit = |scene: &Scene| {
                let built = Engine::cpu().build(scene);
                let world = built.and_then(|built| built.via(pipeline.via(32)));
                let world = world.expect("a world");
                let settings = world.settings([60, 40], Show::Normal);
                let drawn = world.draw(&Eye::default().camera(), &settings);
                drawn.expect("a picture").hit_pixels as f64
            };
            let (with, without) = (hit(&scene), hit(&lone));
            assert!(without > 50.0, "{without}");
            // The lattice lies otherwise where the box is another.
            assert!(
                (with - without).abs() < 0.1 * without,
                "{pipeline:?}: {with} for {without}"
            );
        }
    }
}
