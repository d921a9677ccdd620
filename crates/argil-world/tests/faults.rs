//! Stores that fail, lose, cut and exchange what they are given.

use crate::common::{Fault, contents, plan, scene, store};
use argil::Engine;
use argil::math::Control;
use argil::scene::{Scene, Shape};
use argil::volume::TileAddress;
use argil_world::{
    ReadMode, Shard, Store, StoredWorld, TileCacheOptions, WorldError, WorldPlan, bake, finish,
    status,
};
use object_store::ObjectStoreExt;
use object_store::memory::InMemory;
use object_store::path::Path;
use std::sync::Arc;

#[test]
fn a_store_that_fails_now_and_then_gets_the_same_world() {
    let scene = scene();
    let plan = plan(&scene);
    let control = Control::default();
    let (good, bad) = (Arc::new(InMemory::new()), Arc::new(InMemory::new()));
    let done = bake(
        &plan,
        &scene,
        &store(&good, Fault::None),
        Shard::WHOLE,
        &control,
    );
    let done = done.expect("a world");
    assert!(done.baked > 8 && done.bricks > 1000, "{done:?}");
    let failing = store(&bad, Fault::Fails);
    for index in 0..3 {
        let shard = Shard { index, count: 3 };
        bake(&plan, &scene, &failing, shard, &control).expect("a part");
    }
    // Two workers at one shard, and all of it again: nothing changes.
    let again = bake(&plan, &scene, &failing, Shard::WHOLE, &control).expect("a world");
    assert_eq!((again.baked, again.present), (0, done.baked));
    finish(&plan, &scene, &store(&good, Fault::None), true, &control).expect("a manifest");
    finish(&plan, &scene, &failing, true, &control).expect("a manifest");
    finish(&plan, &scene, &failing, false, &control).expect("a manifest again");
    assert!(contents(&good) == contents(&bad));
    let hung = Arc::new(InMemory::new());
    let hanging = store(&hung, Fault::Hangs);
    bake(&plan, &scene, &hanging, Shard::WHOLE, &control).expect("a world");
    finish(&plan, &scene, &hanging, false, &control).expect("a manifest");
    assert!(contents(&good) == contents(&hung));
}

#[test]
fn errors_hold_no_secrets() {
    let scene = scene();
    let plan = plan(&scene);
    let forbidding = store(&Arc::new(InMemory::new()), Fault::Forbids);
    let failed = bake(
        &plan,
        &scene,
        &forbidding,
        Shard::WHOLE,
        &Control::default(),
    );
    let text = failed.expect_err("forbidden").to_string();
    assert!(text.contains("memory:"), "{text}");
    let error = WorldError::Store {
        place: String::new(),
        reason: String::new(),
    };
    assert!(!format!("{error} {text}").contains("hunter2"));
    let refused = Store::open("s3://user:hunter2@host/place?token=hunter2");
    let text = refused.map(|_| ()).err().map(|error| error.to_string());
    assert!(text.is_none_or(|text| !text.contains("hunter2")));
}

fn view(inner: &Arc<InMemory>, fault: Fault, scene: &Scene) -> (u64, usize, Vec<u8>) {
    let stored = StoredWorld::of_scene(
        &plan(scene),
        scene,
        &store(inner, fault),
        &TileCacheOptions::default(),
    );
    let stored = stored.expect("a world");
    let options = stored.levels_options();
    let built = stored.build(&Engine::cpu(), options, ReadMode::Wait);
    let (_, mut world) = built.expect("a world");
    let mode = argil::render::RenderMode::Normal;
    let settings = world.render_settings([160, 120], mode);
    let camera = world.camera();
    let done = world.refine(&camera, &settings).expect("a view");
    let image = world.render(&camera, &settings).expect("an image");
    (done.bricks, stored.problems().len(), image.rgb.clone())
}

/// Conservative: what cannot be read leaves what is coarser, and is reported.
#[test]
fn what_is_damaged_is_not_seen() {
    let scene = scene();
    let plan = plan(&scene);
    let control = Control::default();
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    finish(&plan, &scene, &good, false, &control).expect("a manifest");
    let (bricks, problems, image) = view(&inner, Fault::None, &scene);
    assert!(bricks > 100 && problems == 0);
    for fault in [Fault::Fails, Fault::Hangs, Fault::CutsOnce] {
        let (_, problems, picture) = view(&inner, fault, &scene);
        assert!(problems == 0 && picture == image, "{fault:?}");
    }
    for fault in [Fault::Cuts, Fault::Exchanges] {
        let (drawn, problems, _) = view(&inner, fault, &scene);
        assert!(
            drawn < bricks && problems > 0,
            "{fault:?}: {drawn}, {problems}"
        );
        let found = status(&plan, &scene, &store(&inner, fault), true, &control).expect("a status");
        assert!(!found.damaged.is_empty(), "{fault:?}");
    }
}

#[test]
fn damaged_tiles_are_baked_again() {
    let scene = scene();
    let plan = plan(&scene);
    let control = Control::default();
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    let incomplete = finish(&plan, &scene, &good, false, &control);
    assert!(matches!(incomplete, Err(WorldError::Incomplete { .. })));
    bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    let before = contents(&inner);
    let tile = before
        .iter()
        .rfind(|(name, content)| name.contains("tiles/0") && content.len() > 1000);
    let (name, bytes) = tile.expect("a tile").clone();
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    let mut wrong = bytes.to_vec();
    wrong[500] ^= 4;
    let place = Path::from(name.as_str());
    let put = inner.put(&place, wrong.into());
    runtime.expect("a runtime").block_on(put).expect("written");
    let found = status(&plan, &scene, &good, true, &control).expect("a status");
    let address_of_tile: TileAddress = name
        .rsplit_once("tiles/")
        .expect("a tile")
        .1
        .parse()
        .expect("a place");
    assert_eq!(
        found.damaged.first().map(|(address, _)| *address),
        Some(address_of_tile)
    );
    let refused = finish(&plan, &scene, &good, true, &control);
    assert!(
        matches!(refused, Err(WorldError::Damaged { damaged: 1, .. })),
        "{refused:?}"
    );
    let again = bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    assert_eq!(again.baked, 1);
    assert!(contents(&inner) == before);
    finish(&plan, &scene, &good, true, &control).expect("a manifest");
    // What tiles share is mended, too.
    let whole = contents(&inner);
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    let runtime = runtime.expect("a runtime");
    for (name, _) in whole.iter().filter(|(name, _)| name.ends_with(".json")) {
        let place = Path::from(name.as_str());
        let put = inner.put(&place, "{".into());
        runtime.block_on(put).expect("written");
    }
    finish(&plan, &scene, &good, true, &control).expect("a manifest");
    assert!(contents(&inner) == whole);
}

#[test]
fn another_scene_is_refused() {
    let mut scene = scene();
    let plan = plan(&scene);
    scene.push(Shape::sphere(0.2)).expect("a sphere");
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    let done = bake(&plan, &scene, &good, Shard::WHOLE, &Control::default());
    assert!(matches!(done, Err(WorldError::Changed(_))));
    assert!(contents(&inner).is_empty());
    let text = plan.to_json();
    assert_eq!(WorldPlan::from_json(&text, "plan").expect("a plan"), plan);
    for (from, to) in [
        ("\"bits\": 16", "\"bits\": 8"),
        ("0.003", "0.005"),
        ("\"argil_world\": 1", "\"argil_world\": 2"),
    ] {
        let changed = text.replace(from, to);
        assert_ne!(changed, text);
        let error = WorldPlan::from_json(&changed, "plan").expect_err("a changed plan");
        assert!(error.to_string().starts_with("plan: "), "{error}");
    }
    for text in ["", "{}", "[]", "{\"argil_world\":1}", "\u{0}"] {
        assert!(WorldPlan::from_json(text, "plan").is_err());
    }
}

/// Bodies without an end are cut where objects end at the latest, and are not asked for again and again.
#[test]
fn bodies_have_an_end() {
    let (scene, control) = (scene(), Control::default());
    let plan = plan(&scene);
    let inner = Arc::new(InMemory::new());
    let good = store(&inner, Fault::None);
    bake(&plan, &scene, &good, Shard::WHOLE, &control).expect("a world");
    let endless = store(&inner, Fault::Endless);
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let name = format!("{}/plan.json", plan.hash());
    for limit in [0, 1000, 5 << 20] {
        let found = runtime.block_on(endless.get(&name, limit));
        let error = found.expect_err("an error").to_string();
        assert!(
            error.contains("more than") && error.contains("plan.json"),
            "{error}"
        );
    }
    let short = runtime.block_on(good.get(&name, 10)).expect_err("an error");
    assert!(short.to_string().contains("more than 10 bytes"), "{short}");
    let part = runtime.block_on(endless.get_part(&name, 0..100, 1 << 20));
    assert!(part.is_err());
    assert!(runtime.block_on(good.get_part(&name, 0..100, 0)).is_ok());
}
