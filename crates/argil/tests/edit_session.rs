//! Tests worlds that follow the edits of their scenes.
//!
//! *Length.* A test for each kind of change that a world follows, with the scenes that they share.

use argil::math::Aabb;
use argil::scene::{Brush, Edit, Material, Modifier, Scene, Shape};
use argil::volume::{Band, SampleFormat, Volume};
use argil::{Backend, BricksOptions, EditBudget, Engine, World};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn shipped(name: &str) -> String {
    format!(
        "{}/../../scenes/{name}.json",
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).display()
    )
}

fn world_of(engine: Engine, scene: &mut Scene, resolution: u32) -> World {
    let mut options = BricksOptions {
        resolution,
        ..BricksOptions::default()
    };
    // So that a small volume has many blocks.
    options.settings.brick_size_voxels = 4;
    let world = engine.build(scene).and_then(|w| w.bricks(options));
    world.expect("a world")
}

fn moved(scene: &mut Scene, index: usize, by: [f32; 3]) {
    let node = scene.node(Scene::ROOT).children()[index];
    let by = Modifier::Translate { by };
    scene.apply(Edit::Transform { node, by }).expect("an edit");
}

/// Returns the mean distance of some cells' centers from a point.
fn distance_of(world: &World, cells: &[[i32; 3]], eye: [f32; 3]) -> f32 {
    let volume = world.volume().expect("a volume").expect("a volume");
    let Volume::Bricks(bricks) = &*volume else {
        panic!("bricks are kept");
    };
    let layout = bricks.layout();
    let middle = |&at: &[i32; 3]| layout.cell_box(at.into()).center();
    let all = cells.iter().map(|at| middle(at).distance(eye.into()));
    all.sum::<f32>() / cells.len() as f32
}

/// Returns the samples of the cells' bricks.
fn cells(world: &World) -> BTreeMap<[i32; 3], Vec<u8>> {
    let volume = world.volume().expect("a volume").expect("a volume");
    let Volume::Bricks(bricks) = &*volume else {
        panic!("bricks are kept");
    };
    let bytes = bricks.layout().brick_bytes() as usize;
    let held = |(brick, &owner): (usize, &u32)| {
        let cell = bricks.cell_at(owner as usize).to_array();
        (
            cell,
            bricks.pool().bytes()[brick * bytes..][..bytes].to_vec(),
        )
    };
    bricks
        .cell_of_brick()
        .iter()
        .enumerate()
        .map(held)
        .collect()
}

/// A large edit is processed in parts, nearest to the camera first. Each cell is always in its old or its new
/// state.
#[test]
fn edits_keep_to_a_budget() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let is_gpu = engine.gpu_kind().is_some();
        let resolution = if is_gpu { 96 } else { 256 };
        let mut scene = Scene::open(shipped("csg20"))?;
        let mut world = world_of(engine, &mut scene, resolution);
        let told = Arc::new(Mutex::new(Vec::<Aabb>::new()));
        let heard = told.clone();
        let listener = world.subscribe(move |boxes| heard.lock().expect("a lock").extend(boxes));
        let before = cells(&world);
        moved(&mut scene, 16, [0.2, 0.1, 0.0]);
        let mut fresh = scene.clone();
        let after = cells(&world_of(world.engine().clone(), &mut fresh, resolution));

        let pace = EditBudget {
            max_ms: 0.1,
            priority_point: [3.0, 0.0, 0.0],
        };
        let layout = world
            .volume_info()?
            .and_then(|info| info.bricks)
            .expect("bricks")
            .layout;
        let block = 4.0 * 1.74 * layout.cell_length();
        let mut left = u64::MAX;
        let (mut calls, mut halves) = (0, 0);
        while left > 0 {
            let applied = world.apply_within(&scene, pace)?;
            // A block can take several calls.
            assert!(!applied.rebuilt && applied.remaining_blocks <= left);
            left = applied.remaining_blocks;
            calls += 1;
            assert_eq!(told.lock().expect("a lock").is_empty(), left > 0);
            if calls % (if is_gpu { 3 } else { 6 }) == 1 {
                let now = cells(&world);
                let all: BTreeSet<[i32; 3]> = [&now, &before, &after]
                    .iter()
                    .flat_map(|cells| cells.keys().copied())
                    .collect();
                let (mut news, mut olds) = (Vec::new(), Vec::new());
                for at in all {
                    let [now, before, after] = [&now, &before, &after].map(|cells| cells.get(&at));
                    assert!(now == before || now == after);
                    if before != after {
                        let side = if now == after { &mut news } else { &mut olds };
                        side.push(at);
                    }
                }
                if !news.is_empty() && !olds.is_empty() {
                    halves += 1;
                    let [done, left] =
                        [news, olds].map(|c| distance_of(&world, &c, pace.priority_point));
                    // The cells of a block come in the order of their numbers.
                    assert!(done < left + block, "{done} {left}");
                }
            }
        }
        assert!(calls > 3 && halves > 0, "{calls} calls, {halves}");
        assert!(told.lock().expect("a lock")[0].contains([0.1, 0.0, 0.0].into()));
        assert_eq!(world.diff_from_rebuild()?, Some(0));

        // Edits go on while others are not done.
        moved(&mut scene, 16, [-0.3, 0.0, 0.1]);
        assert!(world.apply_within(&scene, pace)?.remaining_blocks > 0);
        // A file would hold a scene that its volume has not caught up with.
        let refused = world.write(&mut Vec::new()).map_err(|e| e.to_string());
        assert!(refused.is_err_and(|reason| reason.contains("World::flush")));
        moved(&mut scene, 3, [0.0, 0.1, 0.0]);
        let dent = Brush::new(Shape::sphere(0.1)).at([0.5, 0.0, 0.2]);
        scene.push(dent.subtract().smooth(0.03))?;
        assert!(world.apply_within(&scene, pace)?.remaining_blocks > 0);
        assert!(world.unsubscribe(listener) && !world.unsubscribe(listener));
        let count = told.lock().expect("a lock").len();
        world.flush()?;
        assert_eq!(told.lock().expect("a lock").len(), count);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// The GPU does the same as the CPU, and its unused memory can be released.
#[test]
fn odd_edits_are_right_or_refused() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.8)))?;
        scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
        let mut world = world_of(engine, &mut scene, 64);
        let bytes = world.memory_bytes();
        let check = |world: &mut World, scene: &Scene| -> Outcome {
            let applied = world.apply(scene)?;
            assert!(!applied.rebuilt);
            world.flush()?;
            assert_eq!(world.diff_from_rebuild()?, Some(0));
            Ok(())
        };
        // Outside the box, over its side, and far away.
        for at in [[3.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.5]] {
            scene.push(Brush::new(Shape::sphere(0.3)).at(at))?;
            check(&mut world, &scene)?;
        }
        // So far away that voxels cannot be counted, and back.
        scene.push(Brush::new(Shape::sphere(0.3)).at([0.0, 9e5, 0.0]))?;
        assert!(world.apply(&scene).is_err());
        scene.undo();
        assert!(world.apply(&scene)?.rebuilt);
        // Of two edits at once one is refused, and taken back: the other one is there.
        moved(&mut scene, 0, [0.0, 0.07, 0.0]);
        scene.push(Brush::new(Shape::sphere(0.3)).at([0.0, 9e5, 0.0]))?;
        assert!(world.apply(&scene).is_err());
        scene.undo();
        world.apply(&scene)?;
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        // What is no number is refused, and nothing changes.
        let lengths = [scene.undo_depth(), scene.redo_depth()];
        for wrong in [f32::NAN, f32::INFINITY, 1e30] {
            let ball = Brush::new(Shape::sphere(0.1)).at([0.0, wrong, 0.0]);
            assert!(scene.push(ball).is_err());
            assert!(scene.push(Brush::new(Shape::sphere(wrong))).is_err());
        }
        assert_eq!([scene.undo_depth(), scene.redo_depth()], lengths);
        assert_eq!(world.apply(&scene)?.dirty_box, Aabb::EMPTY);

        // Everything is removed, and comes back.
        for _ in 0..4 {
            let node = scene.node(Scene::ROOT).children()[0];
            scene.apply(Edit::Remove { node })?;
        }
        check(&mut world, &scene)?;
        assert_eq!(
            world
                .volume_info()?
                .and_then(|i| i.bricks)
                .map(|s| s.bricks),
            Some(0)
        );
        assert_eq!(world.render_view([16, 16])?.hit_pixels, 0);
        while scene.undo().is_some() {}
        scene.redo();
        check(&mut world, &scene)?;
        world.shrink_to_fit()?;
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        // On a GPU within a page: the pool is whole layers, and the stack of free bricks is there.
        let page = if world.engine().gpu_kind().is_some() {
            16_384 + bytes / 16
        } else {
            0
        };
        // The table reaches as far as the farthest brush did.
        let reach = 128 << 10;
        let now = world.memory_bytes();
        assert!(now <= bytes + page + reach, "{now} bytes, {bytes} at first");
    }
    Ok(())
}

/// A build that needs too much memory is refused for all representations of bricks, and later calls succeed. An
/// edited world can change its representation.
#[test]
fn a_pool_that_is_full_refuses() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.3)))?;
        scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
        let roomy = world_of(engine.clone(), &mut scene, 64);
        let mut options = BricksOptions {
            resolution: 64,
            memory_budget: Some(2 * roomy.memory_bytes()),
            ..BricksOptions::default()
        };
        options.settings.brick_size_voxels = 4;
        let mut world = engine.build(&scene)?.bricks(options)?;
        let before = cells(&world);
        let drawn = world.render_view([32, 32])?.hit_pixels;
        for at in [
            [0.5, 0.5, 0.0],
            [-0.5, 0.5, 0.1],
            [0.5, -0.5, 0.2],
            [-0.5, -0.5, 0.3],
        ] {
            scene.push(Brush::new(Shape::sphere(0.48)).at(at))?;
        }
        let refused = world.apply(&scene);
        assert!(refused.is_err(), "{refused:?}");
        assert!(cells(&world) == before);
        assert_eq!(world.render_view([32, 32])?.hit_pixels, drawn);
        assert!(world.apply(&scene).is_err());
        while scene.undo_depth() > 1 {
            scene.undo();
        }
        world.apply(&scene)?;
        assert!(cells(&world) == before);
        scene.push(Brush::new(Shape::sphere(0.1)).at([0.3, 0.0, 0.0]))?;
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));

        options.settings.brick_size_voxels = 8;
        let mut world = world.rebuilt_as(&scene, options.into())?;
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        scene.push(
            Brush::new(Shape::sphere(0.1))
                .at([-0.3, 0.0, 0.0])
                .subtract(),
        )?;
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// Changes between creating a world and building its volume are part of it.
#[test]
fn a_scene_can_change_before_its_volume_is_built() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let mut scene = Scene::open(shipped("melting"))?;
        let world = engine.build(&scene)?.field();
        scene.set_time(2.0);
        scene.push(Brush::new(Shape::sphere(0.2)).at([0.6, 0.3, 0.0]))?;
        let mut world = world.rebuilt_as(&scene, BricksOptions::from(48).into())?;
        // What is no edit, too.
        scene.name = "melted".into();
        world = world.rebuilt_as(&scene, BricksOptions::from(48).into())?;
        assert_eq!(world.scene().name, "melted");
        assert!(world.distance([0.6, 0.3, 0.0]) < -0.1);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// One step of the history needs one pass, and equals a fresh bake.
#[test]
fn a_stroke_of_ten_thousand_points_is_one_step() -> Outcome {
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::sphere(0.8)))?;
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let mut world = world_of(Engine::cpu(), &mut scene, 128);
    let before = cells(&world);
    scene.begin_stroke();
    for i in 0..10_000 {
        let t = i as f32 * 1e-3;
        let [x, z] = [(3.0 * t).cos(), (3.0 * t).sin()];
        let y = 0.1 * t - 0.5;
        let ball = Brush::new(Shape::sphere(0.03)).at([0.8 * x, y, 0.8 * z]);
        scene.push(ball.subtract().smooth(0.01))?;
    }
    scene.end_stroke();
    let applied = world.apply(&scene)?;
    assert!(!applied.rebuilt);
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    assert_eq!(scene.undo_depth(), 2);
    assert!(scene.undo().is_some());
    assert!(!world.apply(&scene)?.rebuilt);
    assert!(cells(&world) == before);
    Ok(())
}

/// A brush whose copies can jump makes no other brush more expensive. It is added and removed in place, and distant
/// edits stay as cheap as without it.
#[test]
fn jumps_cost_only_where_they_are() -> Outcome {
    let spread = |i: u32, k: u32| 0.02 * ((i * k) % 101) as f32 - 1.0;
    let shapes = [
        r#"{"type":"ellipsoid","radii":[0.1,0.2,0.15]}"#,
        r#"{"type":"box_frame","half_size":[0.15,0.12,0.1],"half_thickness":0.02}"#,
        r#"{"type":"bezier_tube","from":[0,0,0],"control":[0.1,0.1,0],"to":[0.2,0,0.1],"from_radius":0.04,"to_radius":0.03}"#,
    ];
    let copies = [
        r#"{"type":"radial_repeat","count":5}"#,
        r#"{"type":"repeat","spacing":[0.15,0.1,0.1],"count":[5,1,1]}"#,
        r#"{"type":"repeat","spacing":[0.15,0.15,0.15],"count":[7,4,1]}"#,
    ];
    let mut scene = Scene::new();
    for i in 0..150 {
        let ball = Brush::new(Shape::sphere(0.06)).at([spread(i, 7), spread(i, 31), spread(i, 57)]);
        scene.push(ball.smooth(0.01 * (i % 3) as f32))?;
    }
    let mut world = world_of(Engine::cpu(), &mut scene, 224);
    let drag = |scene: &mut Scene, world: &mut World| -> Result<_, Box<dyn std::error::Error>> {
        let mut done = Vec::new();
        let is_far = |&i: &u32| spread(i, 7) < -0.8;
        for index in (0..150).filter(is_far).map(|i| i as usize) {
            moved(scene, index, [0.02, 0.0, 0.01]);
            let applied = world.apply(scene)?;
            assert!(!applied.rebuilt, "{:?}", applied.reason);
            done.push(world.flush()?.filled);
            scene.undo();
            assert!(!world.apply(scene)?.rebuilt);
            world.flush()?;
        }
        Ok(done)
    };
    let without = drag(&mut scene, &mut world)?;
    assert!(without.len() > 3, "{without:?}");
    let bricks = cells(&world).len();
    for (index, shape) in shapes.iter().enumerate() {
        for copies in &copies {
            let text = format!(
                r#"{{"edit":"insert","entry":{{"shape":{shape},"modifiers":[
                    {{"type":"displace","amplitude":0.01,"frequency":9}},{copies},
                    {{"type":"translate","by":[0.9,0.8,-0.8]}}],"blend":0.0{index}}}}}"#
            );
            scene.apply_log_line(&text.replace('\n', ""))?;
            let applied = world.apply(&scene)?;
            assert!(!applied.rebuilt, "{:?}", applied.reason);
            world.flush()?;
            assert_eq!(world.diff_from_rebuild()?, Some(0), "{text}");
            let with = cells(&world).len();
            assert!(with < 2 * bricks, "{with} bricks, {bricks} without: {text}");
            let far = drag(&mut scene, &mut world)?;
            let [far, alone] = [far, without.clone()].map(|all| all.iter().sum::<u64>());
            assert!(5 * far <= 6 * alone, "{far} {alone}: {text}");
            assert!(scene.undo().is_some());
            let applied = world.apply(&scene)?;
            assert!(!applied.rebuilt, "{:?}", applied.reason);
            assert_eq!(world.diff_from_rebuild()?, Some(0), "{text}, undone");
        }
    }
    assert_eq!(cells(&world).len(), bricks);
    Ok(())
}

/// Brushes of several materials with hard joints, one or several per edit, equal a fresh bake, for all brick sizes
/// and bands.
#[test]
fn hard_brushes_change_bricks_as_a_fresh_bake_does() -> Outcome {
    let cpu = Engine::cpu();
    for (engine, brick, bits, band) in [
        (&cpu, 4, SampleFormat::Snorm16, 4.0),
        (&cpu, 8, SampleFormat::Snorm16, 4.0),
        (&cpu, 8, SampleFormat::Snorm8, 24.0),
        (&cpu, 16, SampleFormat::Snorm8, 4.0),
        (
            &Engine::with_backend(Backend::Gpu)?,
            8,
            SampleFormat::Snorm16,
            4.0,
        ),
    ] {
        let mut scene = Scene::new();
        for (name, base_color) in [("red", [0.8, 0.1, 0.1]), ("blue", [0.1, 0.1, 0.8])] {
            let material = Material {
                base_color,
                ..Material::default()
            };
            scene.set_material(name, material)?;
        }
        scene.push(Brush::new(Shape::cuboid([1.0, 0.6, 1.0])))?;
        let mut options = BricksOptions {
            resolution: 96,
            ..BricksOptions::default()
        };
        options.settings.brick_size_voxels = brick;
        options.settings.encoding.format = bits;
        options.settings.encoding.band = Band::Voxels(band);
        let mut world = engine.build(&scene)?.bricks(options)?;
        let count = if engine.gpu_kind().is_some() { 96 } else { 160 };
        for i in 0..count {
            let along = |k: u32| 2.4 * ((i * k) % 211) as f32 / 211.0 - 1.2;
            let size = 0.03 + 0.27 * ((i * 67) % 211) as f32 / 211.0;
            let brush = match i % 3 {
                0 => Brush::new(Shape::sphere(size)),
                1 => Brush::new(Shape::cuboid([size; 3])),
                _ => Brush::new(Shape::torus(0.2, 0.05)),
            };
            let brush = match i % 4 {
                0 => brush.with_material("red"),
                1 => brush.with_material("blue"),
                _ => brush,
            };
            let brush = brush.at([along(37), along(91), along(150)]);
            scene.push(if i % 5 < 3 { brush } else { brush.subtract() })?;
            // Now and then several come together.
            if i % 6 < 4 || i % 32 == 31 {
                assert!(!world.apply(&scene)?.rebuilt);
            }
            if i % 32 == 31 {
                let differing = world.diff_from_rebuild()?;
                assert_eq!(differing, Some(0), "{brick} {bits:?} {band} {i}");
            }
        }
    }
    Ok(())
}

/// Hundreds of carves and fills of one place, with undo and moves in between, equal a fresh bake.
#[test]
fn carving_one_place_again_and_again_stays_right() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let is_gpu = engine.gpu_kind().is_some();
        let (count, resolution) = if is_gpu { (100, 64) } else { (320, 96) };
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::cuboid([0.6, 0.4, 0.6])))?;
        let mut world = world_of(engine, &mut scene, resolution);
        for i in 0..count {
            let along = |k: u32| 0.9 * ((i * k) % 211) as f32 / 211.0 - 0.45;
            let at = [along(37), 0.3 * along(91) + 0.2, along(150)];
            let brush = match i % 7 {
                3 => Brush::new(Shape::rounded_box([0.05; 3], 0.01)).smooth(0.01),
                5 => Brush::new(Shape::sphere(0.04)).smooth(0.02),
                _ => Brush::new(Shape::sphere(0.06))
                    .subtract()
                    .smooth(0.005 * (i % 3) as f32),
            };
            scene.push(brush.at(at))?;
            let applied = world.apply(&scene)?;
            assert!(!applied.rebuilt, "{i}: {:?}", applied.reason);
            match i % 40 {
                19 => {
                    for _ in 0..5 {
                        assert!(scene.undo().is_some());
                        assert!(!world.apply(&scene)?.rebuilt);
                    }
                }
                29 => {
                    // The middle of the list, and the middle of the place.
                    let index = scene.node(Scene::ROOT).children().len() / 2;
                    moved(&mut scene, index, [0.05, 0.0, 0.0]);
                    assert!(!world.apply(&scene)?.rebuilt);
                }
                35 => {
                    // Several at once, one of them large.
                    for radius in [0.03, 0.2, 0.05] {
                        let hole = Brush::new(Shape::sphere(radius)).at([at[0], -0.3, at[2]]);
                        scene.push(hole.subtract())?;
                    }
                    assert!(!world.apply(&scene)?.rebuilt);
                }
                39 if !is_gpu || i % 80 == 79 => {
                    assert_eq!(world.diff_from_rebuild()?, Some(0), "after {i}");
                }
                _ => {}
            }
        }
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// A copy of the bricks can follow edits by their list of changes.
#[test]
fn changes_of_bricks_are_listed() -> Outcome {
    fn bricks(world: &World) -> argil::volume::Bricks {
        match world
            .volume()
            .expect("a volume")
            .expect("a volume")
            .into_owned()
        {
            Volume::Bricks(bricks) => bricks,
            _ => panic!("bricks are kept"),
        }
    }
    let mut scene = Scene::open(shipped("csg20"))?;
    let mut world = world_of(Engine::cpu(), &mut scene, 96);
    assert_eq!(world.take_brick_changes(), Some(Default::default()));
    let before = bricks(&world);
    let size = before.layout().brick_bytes() as usize;
    let mut pool = before.pool().bytes().to_vec();
    let mut words = before.words().to_vec();
    for (index, by) in [(16, [0.02, 0.0, 0.0]), (3, [0.0, 0.01, 0.0])] {
        moved(&mut scene, index, by);
        assert!(!world.apply(&scene)?.rebuilt);
    }
    let changes = world.take_brick_changes().expect("bricks");
    let after = bricks(&world);
    let [changed, all] = [changes.bricks.len(), after.len()];
    assert!((1..=all).contains(&changed), "{changed} of {all}");
    pool.resize(after.pool().bytes().len(), 0);
    words.resize(after.words().len(), 0);
    for brick in changes.bricks {
        let at = brick as usize * size;
        pool[at..at + size].copy_from_slice(&after.pool().bytes()[at..at + size]);
    }
    for slot in changes.slots {
        let at = 64 * slot as usize;
        words[at..at + 64].copy_from_slice(&after.words()[at..at + 64]);
    }
    assert!(pool == after.pool().bytes());
    let wrong = words.iter().zip(after.words()).filter(|(a, b)| a != b);
    assert_eq!(wrong.count(), 0);
    assert_eq!(world.take_brick_changes(), Some(Default::default()));
    Ok(())
}

/// Animated brushes are followed in place, and equal the scene frozen at that time.
#[test]
fn moving_scenes_are_followed() -> Outcome {
    for name in ["morph", "melting"] {
        let mut scene = Scene::open(shipped(name))?;
        let duration = scene.duration().expect("something moves");
        let mut world = world_of(Engine::cpu(), &mut scene, 96);
        let at_first = cells(&world);
        for share in [0.3, 0.5, 0.51, 1.0] {
            scene.set_time(share * duration);
            world.apply(&scene)?;
            assert_eq!(world.diff_from_rebuild()?, Some(0), "{name} at {share}");
            let frozen = Engine::cpu().build(&scene.baked_at_current_time())?.field();
            for i in 0..50 {
                let p = [0.02 * i as f32 - 0.5, 0.5, 0.01 * i as f32];
                assert_eq!(frozen.distance(p), world.distance(p), "{name} at {share}");
            }
        }
        assert!(cells(&world) != at_first);
        // No step of the history, and back at the beginning everything is as it was.
        assert_eq!([scene.undo_depth(), scene.redo_depth()], [0, 0]);
        scene.set_time(f32::NAN);
        assert_eq!(scene.time(), 0.0);
        world.apply(&scene)?;
        assert!(cells(&world) == at_first, "{name}");
    }
    Ok(())
}

/// A volume from a file can grow with its scene, and an octree is as deep as its box needs. Changes that are not
/// edits are saved too.
#[test]
fn a_world_from_a_file_can_be_edited() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::sphere(0.5)))?;
    for via in argil::Representation::all(128) {
        if matches!(
            via,
            argil::Representation::Field
                | argil::Representation::Levels(_)
                | argil::Representation::Mesh(_)
        ) {
            continue;
        }
        let path = folder.path().join(format!("{}.argil", via.name()));
        Engine::cpu()
            .build(&scene)?
            .with_representation(via)?
            .save(&path)?;
        let stored = argil::volume::VolumeFile::open(&path)?;
        let (mut again, mut world) = Engine::cpu().load(stored, &path)?;
        again.push(Brush::new(Shape::sphere(0.2)).at([0.9, 0.0, 0.0]))?;
        again.name = "grown".into();
        world.apply(&again)?;
        assert!(world.distance([0.9, 0.0, 0.0]) < -0.19, "{}", via.name());
        world.save(&path)?;
        let (saved, _) = Engine::cpu().load(argil::volume::VolumeFile::open(&path)?, &path)?;
        assert!(saved == again && saved.name == "grown");
    }
    Ok(())
}
