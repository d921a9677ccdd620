//! Mesh and image files that a scene names.

use argil::glam::{UVec3, Vec3};
use argil::math::Aabb;
use argil::scene::{Brush, NodeKind, SampledGrid, Scene, Shape, is_image};
use argil::{ExternalFiles, LoadedMesh, MeshFileError, load_meshes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh's path and resolution, as the scene names it.
pub(crate) type Named = (String, u32);

/// Returns an empty placeholder. For a missing image it is flat ground.
pub(crate) fn nothing(path: &str) -> Arc<SampledGrid> {
    let flat = || SampledGrid::from_heights([2, 2], &[0.0; 4]);
    if let Some(flat) = is_image(path).then(flat).flatten() {
        return Arc::new(flat);
    }
    let far = |points: &[Vec3], out: &mut [f32]| {
        debug_assert_eq!(points.len(), out.len());
        out.fill(1.0);
    };
    // Worlds need a box of some size.
    let place = Aabb::centered(Vec3::splat(0.5));
    let grid = SampledGrid::sample(place.min, 1.0, UVec3::ONE, place, &far);
    Arc::new(grid)
}

/// Returns the default resolution: samples of a mesh, or posts of a heightmap, along the longest side.
pub(crate) fn usual_resolution(path: &str) -> u32 {
    Shape::from_file(path)
        .file()
        .map_or(64, |(_, usual, _)| usual)
}

/// Creates a scene of one brush.
pub(crate) fn scene_of((path, resolution): &Named) -> anyhow::Result<Scene> {
    let mut scene = Scene::new();
    let mut shape = Shape::from_file(path.clone());
    if let Some((_, voxels, _)) = shape.file_mut() {
        *voxels = *resolution;
    }
    scene.push(Brush::new(shape))?;
    Ok(scene)
}

/// Loads and samples the meshes of a scene.
pub(crate) type Load = Box<dyn FnMut(&mut Scene) -> Result<Vec<LoadedMesh>, MeshFileError> + Send>;

/// Loads meshes from files in a scene's folder, and from external files.
pub(crate) fn from_files(folder: PathBuf, external: ExternalFiles) -> Load {
    Box::new(move |scene| load_meshes(scene, &folder, external.clone()))
}

/// Loads meshes from memory.
#[cfg(target_arch = "wasm32")]
pub(crate) fn from_bytes(files: Vec<crate::browser::NamedBytes>) -> Load {
    Box::new(move |scene| argil::load_meshes_from_bytes(scene, &files))
}

/// Returns the folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    let folder = path.parent().unwrap_or(Path::new("."));
    if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    }
}

/// Returns a brush's shape with another file. Its size stays the same if the kind is the same.
pub(crate) fn other_file(before: &NodeKind, mesh: &LoadedMesh) -> Shape {
    let shape = mesh.shape();
    let NodeKind::Shape(before) = before else {
        return shape;
    };
    let mut kept = before.clone();
    match (kept.file_mut(), shape.file()) {
        (Some((path, resolution, grid)), Some((to, size, loaded)))
            if is_image(path) == is_image(to) =>
        {
            (*path, *resolution, *grid) = (to.to_owned(), size, loaded.clone());
            kept
        }
        _ => shape,
    }
}

/// Rewrites a scene's mesh paths relative to another folder.
pub(crate) fn moved_paths(
    scene: &Scene,
    from: Option<&Path>,
    to: &Path,
) -> BTreeMap<String, String> {
    let Some(from) = from.map(folder_of) else {
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
    let paths = scene.known_mesh_paths();
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
    use crate::pipeline::Pipeline;
    use crate::viewport_camera::ViewportCamera;
    use argil::Engine;
    use argil::render::RenderMode;

    #[test]
    fn what_stands_in_is_seen_by_none() {
        let mut lone = Scene::new();
        lone.push(Brush::new(Shape::sphere(0.5))).expect("a ball");
        let mut scene = lone.clone();
        scene
            .push(Brush::new(Shape::mesh("gone.obj")))
            .expect("a mesh");
        scene.set_mesh_grid(
            "gone.obj",
            usual_resolution("gone.obj"),
            nothing("gone.obj"),
        );
        assert!(scene.missing_meshes().is_empty());
        for pipeline in Pipeline::all() {
            let hit = |scene: &Scene| {
                let built = Engine::cpu().build(scene);
                let world = built.and_then(|built| built.with_representation(pipeline.via(32)));
                let world = world.expect("a world");
                let settings = world.render_settings([60, 40], RenderMode::Normal);
                let drawn = world.render(&ViewportCamera::default().camera(), &settings);
                drawn.expect("a picture").hit_pixels as f64
            };
            let (with, without) = (hit(&scene), hit(&lone));
            assert!(without > 50.0, "{without}");
            // The voxel grid lies otherwise where the box is another.
            assert!(
                (with - without).abs() < 0.1 * without,
                "{pipeline:?}: {with} for {without}"
            );
        }
    }
}
