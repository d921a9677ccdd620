//! Exports, against the field.

use argil::math::Control;
use argil::mesh::{MeshFormat, from_bytes};
use argil::scene::Scene;
use argil::{Engine, prelude::Brush, scene::Shape};
use argil_world::{
    PlanOptions, Shard, Store, StoredWorld, TileCacheOptions, WorldPlan, bake, finish,
};
use std::path::{Path, PathBuf};

/// A sphere and a slab with flat sides, away from the origin.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let sphere = Brush::new(Shape::sphere(0.5)).at([0.7, 0.1, -0.4]);
    scene.push(sphere).expect("a sphere");
    let slab = Brush::new(Shape::cuboid([0.9, 0.1, 0.3])).at([0.6, -0.4, -0.4]);
    scene.push(slab).expect("a slab");
    scene
}

const VOXEL: f32 = 0.004;

fn world(folder: &Path) -> StoredWorld {
    let scene = scene();
    let options = PlanOptions {
        voxel_size: VOXEL,
        ..PlanOptions::default()
    };
    let plan = WorldPlan::new(&scene, &options).expect("a plan");
    let store = Store::open(&folder.display().to_string()).expect("a store");
    let control = Control::default();
    bake(&plan, &scene, &store, Shard::WHOLE, &control).expect("tiles");
    finish(&plan, &scene, &store, false, &control).expect("a manifest");
    let address = folder.join(plan.hash()).display().to_string();
    StoredWorld::open(&address, &TileCacheOptions::default()).expect("a world")
}

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path
            .extension()
            .is_some_and(|extension| extension == ending)
        {
            found.push(path);
        }
    }
    found
}

#[test]
fn meshes_of_3d_tiles_lie_on_the_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(folder.path());
    let out = folder.path().join("tiles");
    let control = Control::default();
    let done = world.export_3d_tiles(&out, None, &control).expect("tiles");
    assert!(done.missing == 0 && done.levels > 2, "{done:?}");
    let meshes = files(&out, "glb");
    assert_eq!(meshes.len() as u64, done.files);
    let field = Engine::cpu().build(&scene()).expect("a field").field();
    let levels = std::fs::read_dir(out.join("content")).expect("levels");
    let finest = levels
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().parse::<u32>());
    let finest = finest.flatten().max().expect("a level");
    let mut triangles = 0;
    for path in meshes {
        let bytes = std::fs::read(&path).expect("a mesh");
        let mesh = from_bytes(&bytes, MeshFormat::Glb, &path)
            .expect("a mesh")
            .mesh;
        triangles += mesh.triangles.len() as u64;
        let place = path.strip_prefix(out.join("content")).expect("a place");
        let level: u32 = place
            .iter()
            .next()
            .and_then(|name| name.to_str())
            .expect("a level")
            .parse()
            .expect("a level");
        let voxel = VOXEL * (1 << (finest - level)) as f32;
        let points: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
        let mut d = vec![0.0; points.len()];
        field.query().distances(&points, &mut d);
        // Strips go two voxels inward from the borders. Edges are cut by up to half a voxel.
        let on = d.iter().filter(|d| d.abs() < 0.1 * voxel).count();
        assert!(2 * on > d.len(), "{place:?}: {on} of {}", d.len());
        assert!(
            d.iter().all(|&d| d < 0.8 * voxel && d > -2.9 * voxel),
            "{place:?}"
        );
        let far = mesh
            .normals
            .iter()
            .filter(|n| (n.length() - 1.0).abs() > 1e-3);
        assert_eq!(far.count(), 0, "{place:?}");
    }
    assert_eq!(triangles, done.triangles);

    // Coarser, in its place; but nothing that is no export is replaced.
    let coarse = world.export_3d_tiles(&out, Some(3.0 * VOXEL), &control);
    let coarse = coarse.expect("coarser tiles");
    assert_eq!(coarse.levels + 2, done.levels);
    assert!(8 * coarse.triangles < done.triangles);
    assert_eq!(files(&out, "glb").len() as u64, coarse.files);
    let coarsest = world.export_3d_tiles(&out, Some(1e6), &control);
    assert_eq!(coarsest.expect("the coarsest tiles").levels, 1);
    let other = folder.path().join("other");
    std::fs::create_dir(&other).expect("a folder");
    std::fs::write(other.join("tileset.json"), "{}").expect("a foreign file");
    let refused = world.export_3d_tiles(&other, None, &control);
    assert!(refused.is_err_and(|error| error.to_string().contains("tileset.json")));
    let canceled = Control::new();
    canceled.cancel();
    assert!(
        world
            .export_3d_tiles(folder.path().join("x"), None, &canceled)
            .is_err()
    );
    assert!(!folder.path().join("x").exists());
}

/// Conservative: where a tile is missing, the export is coarser, and it is counted. Without the coarsest there is nothing.
#[test]
fn missing_tiles_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = world(folder.path());
    let tiles = folder.path().join(world.plan().hash()).join("tiles/0");
    let largest = files_by_size(&tiles).pop().expect("a tile");
    std::fs::remove_file(largest).expect("removed");
    let out = folder.path().join("tiles3d");
    let whole = folder.path().join("whole");
    let done = world.export_3d_tiles(&out, None, &Control::default());
    let done = done.expect("tiles");
    assert_eq!(done.missing, 1);
    // The tile's own coarsest level comes from the one above it.
    std::fs::create_dir(&whole).expect("a folder");
    let all =
        self::world(&whole).export_3d_tiles(folder.path().join("all"), None, &Control::default());
    let all = all.expect("tiles");
    assert!(done.files < all.files && done.triangles < all.triangles);
    // It is not refined, so that no mesh below it is missing.
    let coarse = |folder: &Path| files(&folder.join("content/1"), "glb").len();
    assert!(coarse(&out) > 0);
    assert_eq!(coarse(&out), coarse(&folder.path().join("all")));
    let root = folder.path().join(world.plan().hash()).join("tiles/1");
    std::fs::remove_dir_all(root).expect("removed");
    let world = StoredWorld::open(
        &folder
            .path()
            .join(world.plan().hash())
            .display()
            .to_string(),
        &TileCacheOptions::default(),
    );
    let none = folder.path().join("none");
    let refused = world
        .expect("a world")
        .export_3d_tiles(&none, None, &Control::default());
    assert!(refused.is_err() && !none.exists(), "{refused:?}");
}

fn files_by_size(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let mut all: Vec<_> = entries
        .map(|entry| {
            (
                entry.metadata().map_or(0, |about| about.len()),
                entry.path(),
            )
        })
        .collect();
    all.sort();
    all.into_iter().map(|(_, path)| path).collect()
}
