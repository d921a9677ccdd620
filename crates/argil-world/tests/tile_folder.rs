//! Tiles on the disk, among files of others.

use crate::common::{Fault, plan, scene, store};
use argil::Engine;
use argil::math::Control;
use argil::render::RenderMode;
use argil_world::{ReadMode, Shard, Store, StoredWorld, TileCacheOptions, bake};
use object_store::memory::InMemory;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Draws a world from behind a network, with its tiles in a folder. Returns the bytes that the store sent.
fn draw(inner: &Arc<InMemory>, folder: &Path, disk_bytes: u64) -> u64 {
    let (scene, plan) = (scene(), plan(&scene()));
    let store = Store::of(inner.clone(), Default::default(), "memory://there").expect("a store");
    let options = TileCacheOptions {
        folder: Some(folder.into()),
        disk_bytes,
        ..TileCacheOptions::default()
    };
    let stored = StoredWorld::of_scene(&plan, &scene, &store, &options).expect("a world");
    let built = stored.build(&Engine::cpu(), stored.levels_options(), ReadMode::Wait);
    let (_, mut world) = built.expect("a world");
    let settings = world.render_settings([320, 240], RenderMode::Normal);
    let camera = world.camera();
    world.refine(&camera, &settings).expect("a view");
    stored.fetched()[1]
}

fn files_below(folder: &Path) -> Vec<(PathBuf, u64)> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let about = entry.metadata().expect("about it");
        match about.is_dir() {
            true => files.extend(files_below(&entry.path())),
            false => files.push((entry.path(), about.len())),
        }
    }
    files
}

#[test]
fn only_tiles_are_removed() {
    let inner = Arc::new(InMemory::new());
    let (scene, control) = (scene(), Control::default());
    let plan = plan(&scene);
    let good = store(&inner, Fault::None);
    bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    let here = tempfile::tempdir().expect("a folder");
    let most = draw(&inner, here.path(), 1 << 30);
    assert!(most > 0 && draw(&inner, here.path(), 1 << 30) == 0);

    // What a user has there, long before any tile, also in folders that could be a world's.
    let cache = here.path().join("argil-tiles");
    let hash = plan.hash();
    let foreign = [
        here.path().join("photo.jpg"),
        here.path().join("0/1_1_1"),
        here.path().join(hash).join("tiles/0/1_1_1"),
        cache.join("notes.txt"),
        cache.join("0/1_1_1"),
        cache.join(hash).join("tiles/0/1_1_1.bak"),
        cache.join(hash).join("tiles/0/01_1_1"),
        cache.join(hash).join("tiles/notes/1_1_1"),
        cache.join(hash).join("1_1_1"),
    ];
    for path in &foreign {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, [7; 5000]).expect("a file");
        let file = std::fs::File::options().append(true).open(path);
        let long_ago = std::time::SystemTime::UNIX_EPOCH;
        let dated = file.expect("it").set_modified(long_ago);
        dated.expect("a date");
    }
    // One tile is gone, so that another is written and the folder is trimmed.
    let tile = files_below(&cache.join(hash).join("tiles"))
        .into_iter()
        .find(|(path, _)| !foreign.contains(path));
    std::fs::remove_file(tile.expect("a tile").0).expect("removed");
    assert!(draw(&inner, here.path(), most / 4) > 0);
    for path in &foreign {
        assert!(path.exists(), "{}", path.display());
    }
    let tiles = files_below(&cache)
        .into_iter()
        .filter(|(path, _)| !foreign.contains(path));
    let bytes: u64 = tiles.map(|(_, length)| length).sum();
    assert!(bytes < most / 2, "{bytes} of {most}");
}

#[test]
fn folders_without_the_mark_are_not_used() {
    let inner = Arc::new(InMemory::new());
    let (scene, control) = (scene(), Control::default());
    let plan = plan(&scene);
    let good = store(&inner, Fault::None);
    bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    let here = tempfile::tempdir().expect("a folder");
    let cache = here.path().join("argil-tiles");
    let foreign = cache.join(plan.hash()).join("tiles/0/1_1_1");
    std::fs::create_dir_all(foreign.parent().expect("a folder")).expect("a folder");
    std::fs::write(&foreign, [7; 5000]).expect("a file");
    assert!(draw(&inner, here.path(), 1) > 0);
    assert_eq!(files_below(here.path()), [(foreign, 5000)]);
}
