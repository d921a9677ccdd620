//! Edits within a budget of time: whatever they change, in every representation, what remains is done later, and the end
//! is what edits without a budget give.

use argil::prelude::RenderMode;
use argil::scene::{Brush, Material, Scene, Shape};
use argil::{Backend, EditBudget, Engine, Representation, World};
use argil_conformance::RandomTables;
use argil_field::Program;
use std::time::{Duration, Instant};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// So short that every edit is cut into parts, and every rebuild is done beside the world.
const SHORT: EditBudget = EditBudget {
    max_ms: 0.01,
    priority_point: [1.0, 0.0, 0.0],
};

/// Whether a scene takes long, for the wrong reasons.
fn is_slow(scene: &Scene) -> bool {
    Program::lower(scene).map_or(true, |program| {
        let size = program.aabb().size();
        program.max_iterations() > 100 || size.is_finite() && size.max_element() > 4.0
    })
}

/// Applies what remains, call by call. Returns how often the world was built again.
fn finish(world: &mut World, scene: &Scene) -> Result<usize, Box<dyn std::error::Error>> {
    let start = Instant::now();
    let mut rebuilds = 0;
    loop {
        let report = world.apply_within(scene, SHORT)?;
        rebuilds += usize::from(report.rebuilt);
        assert_eq!(report.is_rebuilding, world.is_rebuilding());
        if report.remaining_blocks == 0 {
            return Ok(rebuilds);
        }
        assert!(start.elapsed() < Duration::from_secs(120), "{report:?}");
        if report.is_rebuilding {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Returns what a world shows, with all that its levels can have.
fn picture(world: &mut World) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    picture_of(world, [48, 36])
}

fn picture_of(world: &mut World, size: [u32; 2]) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let camera = world.camera();
    let settings = world.render_settings(size, RenderMode::Normal);
    if world.levels().is_some() {
        world.refine(&camera, &settings)?;
    }
    Ok(world.render(&camera, &settings)?.rgb)
}

/// Random logs of the whole table, in all representations, on both devices. A world with a budget ends as one without.
#[test]
fn random_logs_end_as_without_a_budget() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let is_gpu = engine.gpu_kind().is_some();
        let (resolution, edits) = if is_gpu { (12, 12) } else { (20, 30) };
        for (seed, via) in (1..).zip(Representation::all(resolution)) {
            let mut tables = RandomTables::new(seed);
            let mut scene = tables.scene(4);
            scene.view.bounds = Some([[-1.5; 3], [1.5; 3]]);
            while is_slow(&scene) {
                scene.undo().expect("a step of what is slow");
            }
            let build = || engine.build(&scene)?.with_representation(via);
            let (mut world, mut other) = (build()?, build()?);
            for index in 0..edits {
                tables.edit(&mut scene);
                if is_slow(&scene) {
                    scene.undo();
                }
                world.apply_within(&scene, SHORT)?;
                other.apply(&scene)?;
                match index % 6 {
                    2 => _ = world.flush()?,
                    5 => _ = finish(&mut world, &scene)?,
                    _ => continue,
                }
                let name = via.name();
                assert!(!world.is_rebuilding());
                assert_eq!(
                    world.scene().to_json(),
                    scene.to_json(),
                    "{name}, edit {index}"
                );
                if matches!(via, Representation::Bricks(_)) {
                    assert_eq!(world.diff_from_rebuild()?, Some(0), "{name}, edit {index}");
                }
                let [ours, theirs] = [picture(&mut world)?, picture(&mut other)?];
                let apart = ours
                    .iter()
                    .zip(&theirs)
                    .filter(|(a, b)| a.abs_diff(**b) > 2);
                let apart = apart.count();
                assert!(
                    apart * 200 <= ours.len(),
                    "{name}, edit {index}: {apart} bytes"
                );
            }
        }
    }
    Ok(())
}

/// Levels of many pages get on with each call, whatever the calls before have done.
#[test]
fn levels_of_many_pages_come_to_an_end() -> Outcome {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.0, 0.4, 1.0]))?;
    let levels = || Representation::all(256)[2];
    let build = |scene: &Scene| Engine::cpu().build(scene)?.with_representation(levels());
    let (mut world, mut other) = (build(&scene)?, build(&scene)?);
    for world in [&mut world, &mut other] {
        picture_of(world, [240, 180])?;
    }
    // It reaches all pages that there are.
    scene.push(
        Brush::new(Shape::torus(0.8, 0.2))
            .at([0.0, 0.4, 0.0])
            .smooth(0.3),
    )?;
    let first = world.apply_within(&scene, SHORT)?;
    assert!(first.remaining_blocks > 0, "{first:?}");
    finish(&mut world, &scene)?;
    other.apply(&scene)?;
    let [ours, theirs] = [&mut world, &mut other].map(|world| picture_of(world, [240, 180]));
    let (ours, theirs) = (ours?, theirs?);
    let apart = ours
        .iter()
        .zip(&theirs)
        .filter(|(a, b)| a.abs_diff(**b) > 2);
    assert!(apart.count() * 200 <= ours.len());
    Ok(())
}

/// Of edits of all kinds, few build bricks again.
#[test]
fn few_edits_build_bricks_again() -> Outcome {
    let (mut edits, mut rebuilds) = (0, 0);
    for seed in 100..120 {
        let mut tables = RandomTables::new(seed);
        let mut scene = tables.scene(4);
        if is_slow(&scene) {
            continue;
        }
        scene.view.bounds = Some([[-1.5; 3], [1.5; 3]]);
        let mut world = Engine::cpu().build(&scene)?.bricks(16)?;
        for _ in 0..40 {
            tables.edit(&mut scene);
            if is_slow(&scene) {
                scene.undo();
            }
            edits += 1;
            rebuilds += usize::from(world.apply(&scene)?.rebuilt);
        }
        assert_eq!(world.diff_from_rebuild()?, Some(0), "seed {seed}");
    }
    assert!(
        edits >= 300 && 50 * rebuilds <= edits,
        "{rebuilds} of {edits}"
    );
    Ok(())
}

/// Slopes are known where they are, and new materials come last: neither builds the world again.
#[test]
fn the_first_chamfer_and_a_new_material_change_in_place() -> Outcome {
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let mut scene = Scene::new();
        scene.push(Shape::cuboid([0.6, 0.2, 0.6]))?;
        scene.push(Brush::new(Shape::sphere(0.2)).at([-0.5, 0.3, 0.0]))?;
        // More than a number of steep brushes are treated as one.
        let count = if engine.gpu_kind().is_some() { 8 } else { 70 };
        let mut world = engine.build(&scene)?.bricks(32)?;
        for index in 0..count {
            let at = [0.014 * index as f32 - 0.5, 0.2, 0.3];
            let mut brush = Brush::new(Shape::sphere(0.06)).at(at).chamfer(0.002);
            if index % 9 == 0 {
                let name = format!("{} red", 9 - index / 9);
                let base_color = [0.1 * (index / 9) as f32, 0.2, 0.1];
                scene.set_material(
                    &name,
                    Material {
                        base_color,
                        ..Material::default()
                    },
                )?;
                brush = brush.with_material(&name);
            }
            scene.push(brush)?;
            let report = world.apply(&scene)?;
            assert!(!report.rebuilt, "{index}: {:?}", report.reason);
            if index % 23 == 0 || index > 62 {
                assert_eq!(world.diff_from_rebuild()?, Some(0), "{index}");
            }
        }
        while scene.undo().is_some() {}
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// A world that is dropped, built in another way or edited without a budget in the middle of a rebuild loses nothing.
#[test]
fn rebuilds_beside_a_world_can_be_interrupted() -> Outcome {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(0.5))?;
    let dense = || Representation::all(96)[3];
    let mut world = Engine::cpu().build(&scene)?.with_representation(dense())?;
    let add = |scene: &mut Scene, x: f32| scene.push(Shape::sphere(0.3).at([x, 0.0, 0.0]));
    add(&mut scene, 0.4)?;
    let report = world.apply_within(&scene, SHORT)?;
    assert!(report.is_rebuilding && report.remaining_blocks > 0 && !report.rebuilt);
    let refused = world.write(&mut Vec::new()).map_err(|e| e.to_string());
    assert!(refused.is_err_and(|reason| reason.contains("World::flush")));
    // Without a budget, the call waits, and includes what came later.
    add(&mut scene, 0.6)?;
    assert!(world.apply(&scene)?.rebuilt);
    assert_eq!(world.scene().to_json(), scene.to_json());
    add(&mut scene, 0.7)?;
    world.apply_within(&scene, SHORT)?;
    add(&mut scene, -0.7)?;
    world.apply_within(&scene, SHORT)?;
    world.flush()?;
    assert!(!world.is_rebuilding());
    assert_eq!(world.scene().to_json(), scene.to_json());
    assert!(world.apply(&scene)?.remaining_blocks == 0);
    add(&mut scene, 0.9)?;
    world.apply_within(&scene, SHORT)?;
    let mut world = world.rebuilt_as(&scene, dense())?;
    assert!(!world.is_rebuilding());
    add(&mut scene, 1.0)?;
    world.apply_within(&scene, SHORT)?;
    drop(world);
    Ok(())
}
