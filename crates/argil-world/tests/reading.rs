//! Finished worlds are read in parts, edited, and found whole.

use crate::common::{Fault, contents, plan, scene, store};
use argil::Engine;
use argil::math::Control;
use argil::prelude::Brush;
use argil::scene::{Scene, Shape};
use argil_world::{
    PlanOptions, ReadMode, Shard, Store, StoredWorld, TileCacheOptions, WorldPlan, bake, finish,
    status,
};
use object_store::ObjectStoreExt;
use object_store::memory::InMemory;
use object_store::path::Path;
use std::sync::Arc;

/// A view from afar fetches the coarse levels of tiles only. Tiles that come in the background make the same image.
#[test]
fn far_views_fetch_little() {
    let scene = scene();
    let plan = plan(&scene);
    let control = Control::default();
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    let done = bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    let slow = store(&inner, Fault::Delays);
    let draw = |size: [u32; 2], mode: ReadMode| {
        let stored = StoredWorld::of_scene(&plan, &scene, &slow, &TileCacheOptions::default());
        let stored = stored.expect("a world");
        let options = stored.levels_options();
        let built = stored.build(&Engine::cpu(), options, mode);
        let (_, mut world) = built.expect("a world");
        let settings = world.render_settings(size, argil::render::RenderMode::Normal);
        let camera = world.camera();
        let mut waited = 0;
        loop {
            world.render(&camera, &settings).expect("an image");
            let filled = world.fill_pages(f64::INFINITY).expect("pages");
            assert_eq!(filled.missing, 0);
            waited += filled.pending;
            if filled.answered == 0 && filled.pending == 0 {
                break;
            }
        }
        let image = world.render(&camera, &settings).expect("an image");
        (image.rgb.clone(), stored.fetched()[1], waited)
    };
    let (image, bytes, waited) = draw([64, 48], ReadMode::Wait);
    assert!(
        waited == 0 && bytes * 4 < done.bytes,
        "{bytes} of {}",
        done.bytes
    );
    let (later, _, waited) = draw([64, 48], ReadMode::Eventually);
    // Rays that meet coarse pages ask for others, so some pixels are of finer ones.
    let differing = later.iter().zip(&image).filter(|(a, b)| a != b).count();
    assert!(waited > 0 && differing * 50 < image.len(), "{differing}");
    let (_, some, _) = draw([240, 180], ReadMode::Wait);
    assert!(
        some > bytes && some * 2 < done.bytes,
        "{some} of {}",
        done.bytes
    );
    let (_, more, _) = draw([1600, 1200], ReadMode::Wait);
    assert!(more > 4 * bytes, "{more} and {bytes}");
}

fn refuse_wrong_edits(world: &mut StoredWorld) {
    for wrong in [
        "",
        "{",
        r#"{"edit":"remove","node":"brushes[7]"}"#,
        r#"{"edit":"insert","entry":{"shape":{"type":"mesh","path":"none.obj"}}}"#,
    ] {
        let error = world
            .save_edits(wrong, "wrong.jsonl")
            .expect_err(wrong)
            .to_string();
        assert!(error.starts_with("wrong.jsonl"), "{error}");
    }
}

/// Edits are saved beside a world. Its tiles stay, and what is read is the edited scene.
#[test]
fn edits_lie_over_tiles() {
    let mut scene = scene();
    // Where no edit reaches.
    let far = Brush::new(Shape::sphere(0.5)).at([4.0, 0.0, 0.0]);
    scene.push(far).expect("a sphere");
    let plan = plan(&scene);
    let control = Control::default();
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().display().to_string();
    let store = Store::open(&place).expect("a store");
    bake(&plan, &scene, &store, Shard::WHOLE, &control).expect("a world");
    finish(&plan, &scene, &store, false, &control).expect("a manifest");
    let address = format!("{place}/{}", plan.hash());
    let open = || StoredWorld::open(&address, &TileCacheOptions::default()).expect("a world");
    let cut = r#"{"edit":"insert","entry":{"operator":"subtract","shape":{"type":"sphere","radius":0.2},"modifiers":[{"type":"translate","by":[0.2,0.2,0.35]}]}}"#;
    // A stroke without an end ends with its file.
    let stroke = format!("{{\"edit\":\"begin_stroke\"}}\n{cut}");
    let (mut one, mut two) = (open(), open());
    // Some web servers answer with nothing for whatever they do not have.
    let first = folder.path().join(plan.hash()).join("edits/000001.jsonl");
    std::fs::create_dir_all(first.parent().expect("a folder")).expect("a folder");
    for nothing in ["", "\n ", "<html>"] {
        std::fs::write(&first, nothing).expect("a file");
        assert_eq!(open().deltas().len(), 0);
    }
    std::fs::remove_file(&first).expect("no file");
    assert_eq!(
        one.save_edits(&stroke, "cut").expect("saved"),
        "edits/000001.jsonl"
    );
    // Somebody else has saved in the meantime.
    let second = cut.replace("0.35", "-0.35");
    assert_eq!(
        two.save_edits(&second, "second").expect("saved"),
        "edits/000002.jsonl"
    );
    refuse_wrong_edits(&mut two);
    let mut edited = scene.clone();
    edited.apply_log_line(cut).expect("an edit");
    edited.apply_log_line(&second).expect("an edit");
    let found = open();
    assert_eq!(found.scene().undo_depth(), 2);
    assert_eq!(
        (found.deltas().len(), found.scene().to_json()),
        (2, edited.to_json())
    );
    let image = |world: &mut argil::World| {
        let settings = world.render_settings([480, 360], argil::render::RenderMode::Shaded);
        let camera = world.camera();
        world.refine(&camera, &settings).expect("a view");
        world
            .render(&camera, &settings)
            .expect("an image")
            .rgb
            .clone()
    };
    let options = found.levels_options();
    let built = found.build(&Engine::cpu(), options, ReadMode::Wait);
    let (mut current, mut built) = built.expect("a world");
    let picture = image(&mut built);
    let of_scene = |scene: &Scene| {
        let built = Engine::cpu().build(scene).expect("a field");
        image(&mut built.with_representation(options).expect("levels"))
    };
    assert!(picture == of_scene(&edited) && picture != of_scene(&scene));
    assert!(found.fetched()[0] > 0);
    // And it is edited further.
    current
        .apply_log_line(r#"{"edit":"undo"}"#)
        .expect("an undo");
    let report = built.apply(&current).expect("an edit");
    assert_eq!(report.reason, None);
    edited
        .apply_log_line(r#"{"edit":"undo"}"#)
        .expect("an undo");
    assert!(image(&mut built) == of_scene(&edited));
}

/// Empty tiles are not stored. What there must be is found from the tiles above, and nothing is missed without those.
#[test]
fn empty_tiles_are_not_stored() {
    // Noise, whose bounds are loose.
    let mut scene = Scene::new();
    let rough = argil::scene::Modifier::Displace {
        amplitude: 0.2,
        frequency: 3.0,
        seed: 4,
        octaves: 2,
    };
    let sphere = Brush::new(Shape::sphere(0.7)).with_modifier(rough);
    scene.push(sphere).expect("a sphere");
    let options = PlanOptions {
        voxel_size: 0.003,
        ..PlanOptions::default()
    };
    let plan = WorldPlan::new(&scene, &options).expect("a plan");
    let control = Control::default();
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    let done = bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    assert!(
        done.empty > 0 && done.baked + done.empty == done.tiles,
        "{done:?}"
    );
    let found = status(&plan, &scene, &good, true, &control).expect("a status");
    assert_eq!((found.tiles, found.present), (done.baked, done.baked));
    let tiles: Vec<_> = contents(&inner)
        .into_iter()
        .filter(|(name, _)| name.contains("tiles/"))
        .collect();
    assert_eq!(tiles.len() as u64, done.baked);
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    let runtime = runtime.expect("a runtime");
    let remove = |name: &str| {
        let place = Path::from(name);
        runtime.block_on(inner.delete(&place)).expect("removed");
    };
    let missing = || {
        let found = status(&plan, &scene, &good, false, &control).expect("a status");
        found.tiles - found.present
    };
    // One of the finest: it alone is missing. One above it: all that it may refine.
    let (fine, _) = tiles
        .iter()
        .find(|(name, _)| name.contains("tiles/0/"))
        .expect("a tile");
    remove(fine);
    assert_eq!(missing(), 1);
    let (coarse, _) = tiles
        .iter()
        .find(|(name, _)| name.contains("tiles/1/"))
        .expect("a tile");
    remove(coarse);
    assert!(missing() > 2);
    let again = bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    assert_eq!((again.baked, missing()), (2, 0));
    assert_eq!(
        finish(&plan, &scene, &good, true, &control)
            .expect("a manifest")
            .tiles,
        done.baked
    );
}
