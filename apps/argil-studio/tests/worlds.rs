//! Worlds in stores: shown from their tiles, edited, and saved beside them.

use crate::common::{Begin, Desk};
use argil::math::Control;
use argil::scene::{Scene, Shape};
use argil_world::{PlanOptions, Shard, Store, WorldPlan, bake, finish};
use std::path::{Path, PathBuf};

/// Bakes a world. Returns its folder.
fn baked(folder: &Path) -> PathBuf {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.5)).expect("a sphere");
    let options = PlanOptions {
        voxel_size: 0.004,
        ..PlanOptions::default()
    };
    let plan = WorldPlan::new(&scene, &options).expect("a plan");
    let store = Store::create(&folder.display().to_string()).expect("a store");
    let control = Control::default();
    bake(&plan, &scene, &store, Shard::WHOLE, &control).expect("tiles");
    finish(&plan, &scene, &store, false, &control).expect("a manifest");
    folder.join(plan.hash())
}

fn open(world: &Path) -> Desk {
    let mut desk = Desk::new(Begin {
        scene: Some(world.to_owned()),
        is_drawn: true,
        ..Begin::default()
    });
    desk.settle();
    assert_eq!(desk.fault(), None);
    desk
}

#[test]
fn worlds_are_opened_edited_and_saved_beside_their_tiles() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = baked(folder.path());
    let mut desk = open(&world);
    let note = desk.studio().note().unwrap_or_default().to_owned();
    assert!(note.starts_with("Opened "), "{note}");
    assert_eq!(
        (desk.scene().brush_count(), desk.studio().lost_pages()),
        (1, 0)
    );
    desk.choose("File", "Save");
    desk.until_told("no new edits");

    desk.click("Add Sphere");
    desk.settle();
    assert_eq!(desk.scene().brush_count(), 2);
    assert!(desk.studio().document().is_changed());
    desk.choose("File", "Save");
    desk.until_told("edits/000001.jsonl");
    assert!(!desk.studio().document().is_changed());
    let saved = std::fs::read_to_string(world.join("edits/000001.jsonl")).expect("the edits");
    assert!(saved.contains("insert"), "{saved}");

    // Another window removes it again. Both files are read.
    let mut other = open(&world.join("manifest.json"));
    assert_eq!(other.scene().to_json(), desk.scene().to_json());
    assert!(!other.studio().document().is_changed());
    other.window.state_mut().document_mut().undo();
    other.settle();
    assert_eq!(other.scene().brush_count(), 1);
    other.choose("File", "Save");
    other.until_told("edits/000002.jsonl");
    // The first window does not know of it, and adds a brush behind the one that is gone.
    desk.click("Add Box");
    desk.choose("File", "Save");
    desk.until_told("Others have saved edits that these do not fit");
    assert!(desk.studio().document().is_changed());
    let last = open(&world);
    assert_eq!(last.scene().brush_count(), 1);
}

/// Where tiles are missing, the picture is coarser, says so, and comes to rest.
#[test]
fn missing_tiles_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = baked(folder.path());
    std::fs::remove_dir_all(world.join("tiles/0")).expect("tiles");
    let desk = open(&world);
    assert!(desk.studio().lost_pages() > 0);
}

#[test]
fn what_is_no_world_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("manifest.json"), "{}").expect("a file");
    let desk = open(folder.path());
    let note = desk.studio().note().unwrap_or_default();
    assert!(note.contains("no manifest of a world"), "{note}");
}
