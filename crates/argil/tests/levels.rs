//! Levels of detail, against bricks, the field, and fresh bakes.

use crate::levels_common::{differing, engines, levels_of, levels_on, scene};
use argil::prelude::*;
use argil::scene::Edit;
use argil::volume::Volume;
use argil::{LevelsOptions, World};

/// At rest, an image no longer changes, lacks nothing, and hits what the field has there.
#[test]
fn a_view_at_rest_lacks_nothing() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(rests)
}

fn rests(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    let mut world = levels_on(engine, &scene, LevelsOptions::from(1024))?;
    let camera = world.camera();
    let settings = world.render_settings([160, 90], RenderMode::Normal);
    let first = world.render(&camera, &settings)?;
    let filled = world.refine(&camera, &settings)?;
    assert!(filled.bricks > 0 && filled.remaining == 0 && !filled.is_full);
    let a = world.render(&camera, &settings)?;
    let b = world.render(&camera, &settings)?;
    let at = world.ray_distances(&camera, &settings)?;
    assert!(a.rgb == b.rgb && a.rgb != first.rgb);
    assert_eq!(world.levels().map(|levels| levels.request_count()), Some(0));
    let exact = Engine::cpu().build(&scene)?.field();
    let truth = exact.ray_distances(&camera, &settings)?;
    let off = at.iter().zip(&truth).filter(|(a, b)| {
        a.is_finite() != b.is_finite() || (a.is_finite() && (*a - *b).abs() > 0.02)
    });
    let off = off.count();
    assert!(off < at.len() / 80, "{off} of {}", at.len());
    Ok(())
}

/// Both devices draw the same, lit and unlit, apart from rounding and where levels are dithered.
#[test]
fn both_devices_draw_the_same() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    for mode in [RenderMode::Normal, RenderMode::Shaded] {
        let mut drawn = Vec::new();
        for engine in engines() {
            let mut world = levels_on(&engine, &scene, LevelsOptions::from(4096))?;
            let settings = world.render_settings([160, 90], mode);
            let camera = world.camera();
            world.refine(&camera, &settings)?;
            drawn.push(world.render(&camera, &settings)?.rgb);
        }
        let off = drawn[0].iter().zip(&drawn[1]);
        let off = off.filter(|(a, b)| a.abs_diff(**b) > 12).count();
        assert!(off < drawn[0].len() / 100, "{mode:?}: {off}");
    }
    Ok(())
}

/// Where all is as fine as it gets, the devices hit the same pixels at the same distances, silhouettes included.
#[test]
fn both_devices_hit_the_same() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::sphere(0.7)))?;
    let options = LevelsOptions {
        pixel_error: 0.125,
        ..LevelsOptions::from(64)
    };
    let mut lengths = Vec::new();
    for engine in engines() {
        let mut world = levels_on(&engine, &scene, options)?;
        let settings = world.render_settings([640, 360], RenderMode::Normal);
        let camera = world.camera();
        world.refine(&camera, &settings)?;
        lengths.push(world.ray_distances(&camera, &settings)?);
    }
    let off = lengths[0].iter().zip(&lengths[1]).filter(|(a, b)| {
        a.is_finite() != b.is_finite() || (a.is_finite() && (*a - *b).abs() > 1e-3)
    });
    let off = off.count();
    assert!(off < 8, "{off}");
    Ok(())
}

/// Before anything is filled, rays end before the surface, never behind it.
#[test]
fn no_ray_passes_through_a_surface_that_is_not_resident() -> Result<(), Box<dyn std::error::Error>>
{
    let mut scene = Scene::new();
    // Much thinner than a voxel of the coarsest level.
    scene.push(Brush::new(Shape::cuboid([1.0, 0.002, 1.0])))?;
    scene.push(Brush::new(Shape::sphere(0.01)).at([0.0, -0.9, 0.0]))?;
    let world = levels_of(&scene, LevelsOptions::from(8192))?;
    let camera = Camera {
        eye: [0.1, 2.0, 0.2].into(),
        target: [0.1, 0.0, 0.2].into(),
        field_of_view_degrees: 30.0,
    };
    let settings = world.render_settings([64, 64], RenderMode::Normal);
    let at = world.ray_distances(&camera, &settings)?;
    let exact = Engine::cpu().build(&scene)?.field();
    let truth = exact.ray_distances(&camera, &settings)?;
    for (coarse, truth) in at.iter().zip(&truth) {
        assert!(*coarse <= truth + 1e-3, "{coarse} {truth}");
    }
    Ok(())
}

/// After edits, moves and evictions, what is resident is what a fresh bake has, to the bit.
#[test]
fn what_is_resident_equals_a_fresh_bake() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(follows)
}

fn follows(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = scene()?;
    let options = LevelsOptions {
        memory_budget: 1 << 20,
        ..LevelsOptions::from(2048)
    };
    let mut world = levels_on(engine, &scene, options)?;
    let settings = world.render_settings([96, 54], RenderMode::Normal);
    let mut evicted = 0;
    let mut nodes = Vec::new();
    for step in 0..24u16 {
        let along = |k: u16| f32::from(step * k % 23) / 23.0 * 3.0 - 1.5;
        match step % 4 {
            0 => {
                let brush = Brush::new(Shape::sphere(0.2)).at([along(5), 0.0, along(3)]);
                nodes.push(scene.push(brush.subtract().smooth(0.03))?.node);
            }
            1 => {
                let ring = Brush::new(Shape::torus(0.2, 0.05));
                nodes.push(scene.push(ring.at([along(7), 0.9, along(9)]))?.node);
            }
            2 => {
                if let Some(node) = nodes.pop() {
                    scene.apply(Edit::Remove { node })?;
                }
            }
            _ => {}
        }
        let applied = world.apply(&scene)?;
        assert!(!applied.rebuilt, "step {step}: {:?}", applied.reason);
        let camera = world.camera().orbited(f32::from(step) * 15.0);
        let near = Camera {
            eye: camera.target + (camera.eye - camera.target) * 0.4,
            ..camera
        };
        evicted += world.refine(&near, &settings)?.evicted;
        assert_eq!(differing(&world), 0, "step {step}");
        let levels = world.levels().expect("levels");
        assert!(
            levels.memory_bytes() <= 5 << 18,
            "{}",
            levels.memory_bytes()
        );
    }
    assert!(evicted > 0);
    Ok(())
}

/// A view at rest is the same, to the bit, whether only what it asked for is resident or everything is.
#[test]
fn at_rest_it_is_as_if_everything_were_resident() -> Result<(), Box<dyn std::error::Error>> {
    for engine in engines() {
        for mode in [RenderMode::Normal, RenderMode::Shaded] {
            is_as_whole(&engine, mode)?;
        }
    }
    Ok(())
}

fn is_as_whole(engine: &Engine, mode: RenderMode) -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    let mut world = levels_on(engine, &scene, LevelsOptions::from(256))?;
    let mut whole = levels_on(engine, &scene, LevelsOptions::from(256))?;
    // Shadows fall into a close view from what it does not show.
    let usual = world.camera();
    let camera = Camera {
        eye: usual.target + (usual.eye - usual.target) * 0.3,
        ..usual
    };
    let settings = world.render_settings([160, 90], mode);
    world.refine(&camera, &settings)?;
    loop {
        let levels = whole.levels().expect("levels");
        let finest = levels.layout().level(0);
        let [low, high] = [finest.first_cell(), finest.end_cell()];
        let mut is_missing = false;
        for z in low.z..high.z {
            for y in low.y..high.y {
                for x in low.x..high.x {
                    let cell = finest.cell_box([x, y, z].into());
                    is_missing |= levels.request(0, cell.center());
                }
            }
        }
        if !is_missing {
            break;
        }
        whole.fill_pages(f64::INFINITY).expect("filled");
    }
    let count = |world: &World| world.levels().map(|levels| levels.brick_count());
    assert!(count(&whole) > count(&world));
    let [a, b] = [&world, &whole].map(|world| world.ray_distances(&camera, &settings));
    let (a, b) = (a?, b?);
    let other = a.iter().zip(&b).filter(|(a, b)| a.to_bits() != b.to_bits());
    assert_eq!(other.count(), 0);
    let [a, b] = [&world, &whole].map(|world| world.render(&camera, &settings));
    assert!(a?.rgb == b?.rgb);
    Ok(())
}

/// A floor is not refined, but a pebble on it is seen, however small it is in the voxels where the floor would do.
#[test]
fn a_pebble_on_a_plane_is_seen() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::cuboid([2.0, 0.1, 2.0])).at([0.0, -0.1, 0.0]))?;
    let floor = scene.clone();
    scene.push(Brush::new(Shape::sphere(0.003)).at([0.517, 0.0, 0.233]))?;
    let camera = Camera {
        eye: [0.517, 0.02, 0.26].into(),
        target: [0.517, 0.0, 0.233].into(),
        field_of_view_degrees: 40.0,
    };
    let mut bricks = [0; 2];
    for (scene, bricks) in [&floor, &scene].into_iter().zip(&mut bricks) {
        let mut world = levels_of(scene, LevelsOptions::from(16_384))?;
        let settings = argil::render::RenderSettings {
            epsilon: Some(1e-6),
            ..world.render_settings([128, 96], RenderMode::Normal)
        };
        *bricks = world.refine(&camera, &settings)?.bricks;
        let at = world.ray_distances(&camera, &settings)?;
        let exact = Engine::cpu().build(scene)?.field();
        let truth = exact.ray_distances(&camera, &settings)?;
        let off = at
            .iter()
            .zip(&truth)
            .filter(|(a, b)| (*a - *b).abs() > 0.000_5);
        let off = off.count();
        assert!(off < at.len() / 200, "{off} of {}", at.len());
    }
    // The floor alone needs next to nothing.
    assert!(20 * bricks[0] < bricks[1], "{bricks:?}");
    Ok(())
}

/// A world can grow a little, and far beyond its coarsest level, and is right in both cases.
#[test]
fn a_world_grows_beyond_its_levels() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(grows)
}

fn grows(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = scene()?;
    let mut world = levels_on(engine, &scene, LevelsOptions::from(64))?;
    let count = |world: &World| world.levels().map(|levels| levels.layout().count());
    assert_eq!(count(&world), Some(3));
    scene.push(Brush::new(Shape::sphere(0.3)).at([4.0, 0.0, 0.0]))?;
    assert!(!world.apply(&scene)?.rebuilt);
    assert_eq!(differing(&world), 0);
    scene.push(Brush::new(Shape::sphere(0.5)).at([0.0, 900.0, 0.0]))?;
    assert!(world.apply(&scene)?.rebuilt);
    assert!(count(&world) > Some(5));
    assert_eq!(differing(&world), 0);
    let settings = world.render_settings([32, 32], RenderMode::Normal);
    let camera = Camera {
        eye: [0.0, 900.0, 4.0].into(),
        target: [0.0, 900.0, 0.0].into(),
        field_of_view_degrees: 20.0,
    };
    world.refine(&camera, &settings)?;
    let at = world.ray_distances(&camera, &settings)?;
    let nearest = at.into_iter().fold(f32::INFINITY, f32::min);
    assert!((nearest - 3.5).abs() < 0.1, "{nearest}");
    Ok(())
}

/// Requests that cannot be met have clear errors.
#[test]
fn senseless_options_are_refused() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    let build = |options: LevelsOptions| {
        let world = Engine::cpu().build(&scene).expect("a world");
        let refused = world.with_representation(options);
        refused.err().map(|error| error.to_string())
    };
    let usual = LevelsOptions::from(4096);
    for (options, reason) in [
        (
            LevelsOptions {
                pixel_error: f32::NAN,
                ..usual
            },
            "0.125 to 1024 pixels",
        ),
        (
            LevelsOptions {
                memory_budget: 1_000,
                ..usual
            },
            "the budget is",
        ),
        (LevelsOptions::from(0), "resolution 0"),
        (LevelsOptions::from(u32::MAX), "8 to 4194304 voxels"),
    ] {
        let found = build(options).unwrap_or_default();
        assert!(found.contains(reason), "{found}");
    }
    let world = levels_of(&scene, usual)?;
    let folder = tempfile::tempdir()?;
    let refused = world.save(folder.path().join("a.argil")).err();
    assert!(refused.is_some_and(|error| error.to_string().contains("cannot be saved")));
    assert!(matches!(
        world.volume()?.as_deref(),
        Some(Volume::Levels(_))
    ));
    Ok(())
}

/// A budget that holds only a part makes all of an image equally coarse, instead of leaving gaps.
#[test]
fn a_full_budget_makes_all_equally_coarse() -> Result<(), Box<dyn std::error::Error>> {
    let scene = scene()?;
    let options = LevelsOptions {
        memory_budget: 1 << 20,
        ..LevelsOptions::from(65_536)
    };
    let mut world = levels_of(&scene, options)?;
    let settings = world.render_settings([320, 180], RenderMode::Normal);
    let camera = world.camera_at(CameraPose::Orbit([30.0, 20.0, 2.6]));
    let filled = world.refine(&camera, &settings)?;
    assert!(filled.evicted > 0 && !filled.is_full, "{filled:?}");
    world.render(&camera, &settings)?;
    let levels = world.levels().expect("levels");
    let accepted = levels.effective_pixel_error();
    assert!(accepted > 1.1 && accepted < 8.0, "{accepted}");
    assert_eq!(levels.coarse_share(), 0.0);
    // Far away, the scene is small, and soon sharp again.
    let away = Camera {
        eye: camera.target + 40.0 * (camera.eye - camera.target),
        ..camera
    };
    for _ in 0..80 {
        world.render(&away, &settings)?;
        world.fill_pages(f64::INFINITY).expect("filled");
    }
    let levels = world.levels().expect("levels");
    assert_eq!(levels.effective_pixel_error(), 1.0);
    Ok(())
}

/// A scene without end is a world as far as one can see: 100 km out, it looks as it does at the origin.
#[test]
fn a_repetition_without_end_reaches_the_horizon() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(reaches_horizon)
}

fn reaches_horizon(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::Plane {
        normal: [0.0, 1.0, 0.0],
        offset: 0.0,
    })?;
    let column = Brush::new(Shape::cuboid([0.5, 1.2, 0.5]))
        .rotated([0.0, 1.0, 0.0], 30.0)
        .at([0.0, 1.2, 0.0]);
    scene.push(column.with_modifier(Modifier::Repeat {
        spacing: [4.0, 0.0, 4.0],
        count: None,
    }))?;
    let options = LevelsOptions {
        voxel_size: Some(0.05),
        ..LevelsOptions::default()
    };
    let mut world = levels_on(engine, &scene, options)?;
    let settings = world.render_settings([96, 54], RenderMode::Normal);
    let mut seen = Vec::new();
    for x in [0.0, 100_000.0] {
        let camera = Camera {
            eye: [x + 2.0, 2.25, 7.0].into(),
            target: [x + 1.0, 1.0, -8.0].into(),
            field_of_view_degrees: 50.0,
        };
        world.refine(&camera, &settings)?;
        seen.push(world.ray_distances(&camera, &settings)?);
    }
    let (near, far) = (&seen[0], &seen[1]);
    assert!(near.iter().filter(|t| t.is_finite()).count() > near.len() / 2);
    assert!(near.iter().any(|&t| t.is_finite() && t > 40.0));
    let off = near.iter().zip(far).filter(|(a, b)| {
        a.is_finite() != b.is_finite() || (a.is_finite() && (*a - *b).abs() > 0.02 * *a)
    });
    let off = off.count();
    assert!(off < near.len() / 50, "{off} of {}", near.len());
    Ok(())
}
