//! Tests worlds without a box: brushes anywhere are stored, with voxels of the same size.

use argil::render::RenderMode;
use argil::scene::{Brush, Edit, Modifier, Scene, Shape};
use argil::volume::{Volume, VolumeFile, VoxelGrid};
use argil::{
    Backend, BricksOptions, BuildError, DenseOptions, Engine, OctreeOptions, RebuildReason,
    Representation, World,
};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn ball_at(at: [f32; 3]) -> Brush {
    Brush::new(Shape::sphere(0.5)).at(at)
}

fn one_ball() -> Result<Scene, argil::scene::EditError> {
    let mut scene = Scene::new();
    scene.push(ball_at([0.0; 3]))?;
    Ok(scene)
}

fn bricks_of(engine: &Engine, scene: &mut Scene, resolution: u32) -> World {
    let options = BricksOptions {
        resolution,
        ..BricksOptions::default()
    };
    let world = engine.build(scene).and_then(|w| w.bricks(options));
    world.expect("a world")
}

fn voxel_grid_of(world: &World) -> VoxelGrid {
    let info = world.volume_info().expect("an answer");
    info.expect("a volume").voxel_grid
}

/// Counts the pixels of a sphere of radius 0.5 that a camera looks at from the front.
fn pixels_of_ball(world: &World, at: [f32; 3]) -> usize {
    let mut camera = world.camera();
    camera.target = at.into();
    camera.eye = argil::glam::Vec3::from(at) + argil::glam::Vec3::new(0.0, 0.0, 4.0);
    let settings = argil::render::RenderSettings {
        ground: false,
        samples: 1,
        // Of the field it is a share of the scene's size, which is great here.
        epsilon: Some(1e-3),
        ..world.render_settings([96, 72], RenderMode::Normal)
    };
    world
        .render(&camera, &settings)
        .expect("a picture")
        .hit_pixels
}

fn engines() -> [Engine; 2] {
    [
        Engine::cpu(),
        Engine::with_backend(Backend::Gpu).expect("a GPU"),
    ]
}

/// A surface with more blocks of cells than the limit is refused while the blocks are counted. Later builds
/// succeed.
#[test]
fn too_large_builds_are_refused_before_they_allocate() -> Outcome {
    for engine in engines() {
        let mut scene = one_ball()?;
        let options = BricksOptions {
            resolution: 128,
            memory_budget: Some(32 << 20),
            ..BricksOptions::default()
        };
        let mut world = engine.build(&scene)?.bricks(options)?;
        scene.push(Brush::new(Shape::sphere(1000.0)).at([0.0, 0.0, 1100.0]))?;
        let refused = world.apply(&scene).expect_err("too much");
        let text = refused.to_string();
        assert!(text.contains("blocks need over"), "{text}");
        scene.undo();
        world.apply(&scene)?;
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// Adds brushes next to the box, farther out, and so far that empty space is stored as large cubes.
#[test]
fn brushes_outside_the_first_box_are_stored() -> Outcome {
    for engine in engines() {
        let mut scene = one_ball()?;
        let mut world = bricks_of(&engine, &mut scene, 64);
        let first = voxel_grid_of(&world);
        let whole = pixels_of_ball(&world, [0.0; 3]);
        for at in [
            [0.9, 0.0, 0.0],
            [0.0, -3.0, 0.0],
            [-40.0, 25.0, 0.0],
            [900.0, -700.0, 800.0],
        ] {
            scene.push(ball_at(at))?;
            let applied = world.apply(&scene)?;
            world.flush()?;
            assert!(!applied.rebuilt, "{at:?}: {:?}", applied.reason);
            assert_eq!(world.diff_from_rebuild()?, Some(0), "{at:?}");
            let voxel_grid = voxel_grid_of(&world);
            assert_eq!(
                (voxel_grid.voxel_size, voxel_grid.corner),
                (first.voxel_size, first.corner)
            );
            // The field is the independent witness.
            let field = engine.build(&scene)?.field();
            let [pixels, exact] = [&world, &field].map(|world| pixels_of_ball(world, at));
            assert!(
                pixels.abs_diff(exact) <= exact / 12 + 2,
                "{at:?}: {pixels} and {exact}"
            );
            assert!(pixels > whole / 2, "{at:?}: {pixels} of {whole}");
        }
        // What was there before is there still.
        let field = engine.build(&scene)?.field();
        let [pixels, exact] = [&world, &field].map(|world| pixels_of_ball(world, [0.0; 3]));
        assert!(
            pixels.abs_diff(exact) <= exact / 12 + 2,
            "{pixels} and {exact}"
        );
        if let Some(query) = world.query_volume() {
            let hit = query.cast_ray([900.0, -700.0, 830.0], [0.0, 0.0, -1.0], 100.0);
            assert!((hit.expect("the far ball").distance - 29.5).abs() < 0.1);
        }
    }
    Ok(())
}

/// Bricks with a given voxel size store distant brushes in one build, and need the same memory as for adjacent
/// brushes.
#[test]
fn distant_brushes_are_baked_in_one_build() -> Outcome {
    let options = BricksOptions {
        voxel_size: Some(0.02),
        ..BricksOptions::default()
    };
    for engine in engines() {
        let mut bytes = [0; 2];
        for (bytes, apart) in bytes.iter_mut().zip([2.5, 10_000.0]) {
            let mut scene = one_ball()?;
            scene.push(ball_at([apart, 0.0, 0.0]))?;
            let world = engine.build(&scene)?.bricks(options)?;
            *bytes = world.memory_bytes();
            let field = engine.build(&scene)?.field();
            for at in [[0.0; 3], [apart, 0.0, 0.0]] {
                let [pixels, exact] = [&world, &field].map(|world| pixels_of_ball(world, at));
                assert!(
                    pixels > 100 && pixels.abs_diff(exact) <= exact / 12 + 2,
                    "{at:?}: {pixels} and {exact}"
                );
            }
        }
        let [near, far] = bytes.map(|bytes| bytes as f64);
        // Coarse bricks have blocks that are hardly used.
        assert!(far < 1.2 * near, "{far} and {near}");
        let fine = BricksOptions {
            voxel_size: Some(1e-4),
            ..options
        };
        let mut scene = one_ball()?;
        scene.push(ball_at([10_000.0, 0.0, 0.0]))?;
        let refused = engine
            .build(&scene)?
            .bricks(fine)
            .expect_err("too many voxels");
        assert!(refused.to_string().contains("4194304"), "{refused}");
    }
    Ok(())
}

/// After any edits at distances from a thousandth of a unit to ten thousand units, the bricks equal a fresh bake
/// with a new box, and rays hit what the field says.
#[test]
fn edits_anywhere_equal_a_fresh_bake() -> Outcome {
    let mut seed = 11u64;
    let mut unit = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1u64 << 24) as f32
    };
    for (engine, edits) in engines().into_iter().zip([60, 12]) {
        let mut scene = one_ball()?;
        let mut world = bricks_of(&engine, &mut scene, 48);
        let (mut rebuilt, mut nodes) = (0, Vec::new());
        for index in 0..edits {
            let reach = 10f32.powf(-3.0 + 7.0 * unit());
            let direction = [unit() - 0.5, unit() - 0.5, unit() - 0.5];
            let at = direction.map(|d| 2.0 * reach * d);
            match index % 5 {
                0..=2 => {
                    let brush = Brush::new(Shape::sphere(0.2 + 0.4 * unit())).at(at);
                    let brush = match index % 3 {
                        0 => brush,
                        1 => brush.smooth(0.1),
                        _ => brush.subtract(),
                    };
                    nodes.push(scene.push(brush)?.node);
                }
                3 => {
                    let node = nodes[(unit() * nodes.len() as f32) as usize % nodes.len()];
                    let by = Modifier::Translate { by: at };
                    // What would leave the space that can be counted is refused.
                    let _ = scene.apply(Edit::Transform { node, by });
                }
                _ => {
                    scene.undo();
                    if unit() < 0.5 {
                        scene.redo();
                    }
                }
            }
            let applied = world.apply(&scene)?;
            world.flush()?;
            if applied.rebuilt {
                rebuilt += 1;
            }
            assert_eq!(
                world.diff_from_rebuild()?,
                Some(0),
                "edit {index}, {reach} away, {:?}",
                applied.reason
            );
        }
        assert!(rebuilt <= edits / 6, "{rebuilt} of {edits}");
    }
    Ok(())
}

/// Distance is free: two spheres ten thousand units apart need the same memory as two adjacent ones.
#[test]
fn far_things_take_no_more_than_near_ones() -> Outcome {
    let memory = |gap: f32| -> Result<u64, Box<dyn std::error::Error>> {
        let mut scene = Scene::new();
        let radius = 1.0;
        scene.push(Brush::new(Shape::sphere(radius)))?;
        let mut world = bricks_of(&Engine::cpu(), &mut scene, 512);
        scene.push(Brush::new(Shape::sphere(radius)).at([gap, 0.0, 0.0]))?;
        assert!(!world.apply(&scene)?.rebuilt);
        Ok(world.memory_bytes())
    };
    let (near, far) = (memory(2.5)?, memory(10_000.0)?);
    assert!(far as f64 <= 1.1 * near as f64, "{far} and {near}");
    Ok(())
}

/// Memory of blocks that edits empty is released.
#[test]
fn blocks_are_given_back() -> Outcome {
    let mut scene = one_ball()?;
    let mut world = bricks_of(&Engine::cpu(), &mut scene, 96);
    let before = world.memory_bytes();
    for _ in 0..3 {
        scene.push(ball_at([500.0, 0.0, 300.0]))?;
        assert!(!world.apply(&scene)?.rebuilt);
        assert!(world.memory_bytes() > before + before / 2);
        scene.undo();
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    let after = world.memory_bytes();
    // But for the top of a table that reaches as far, of which there are 65,536 entries at most.
    assert!(after < before + 4 * 65_536 + 4_096, "{after} and {before}");
    Ok(())
}

/// Dense volumes and octrees are rebuilt for the larger box, with voxels of the same size, and the report says why.
#[test]
fn others_are_built_for_a_larger_box() -> Outcome {
    let dense = Representation::Dense(DenseOptions {
        resolution: 32,
        ..DenseOptions::default()
    });
    let octree = Representation::Octree(OctreeOptions {
        resolution: 32,
        ..OctreeOptions::default()
    });
    for via in [dense, octree] {
        let mut scene = one_ball()?;
        let mut world = Engine::cpu().build(&scene)?.with_representation(via)?;
        let (voxel, whole) = (
            voxel_grid_of(&world).voxel_size,
            pixels_of_ball(&world, [0.0; 3]),
        );
        scene.push(
            Brush::new(Shape::sphere(0.2))
                .at([0.1, 0.0, 0.0])
                .subtract(),
        )?;
        assert_eq!(
            world.apply(&scene)?.reason,
            Some(RebuildReason::NotEditable)
        );
        scene.push(ball_at([1.8, 0.0, 0.0]))?;
        assert_eq!(world.apply(&scene)?.reason, Some(RebuildReason::OutsideBox));
        assert_eq!(voxel_grid_of(&world).voxel_size, voxel);
        let found = pixels_of_ball(&world, [1.8, 0.0, 0.0]);
        assert!(found > whole / 2, "{found} of {whole}");
    }
    Ok(())
}

/// The box clips infinite solids. When one is added or removed, the world is rebuilt.
#[test]
fn infinite_solids_are_clipped() -> Outcome {
    let mut scene = one_ball()?;
    scene.view.bounds = Some([[-1.0; 3], [1.0; 3]]);
    let mut world = bricks_of(&Engine::cpu(), &mut scene, 48);
    assert!(!voxel_grid_of(&world).is_clipped);
    scene.push(Brush::new(Shape::Plane {
        normal: [0.0, 1.0, 0.0],
        offset: -0.2,
    }))?;
    assert_eq!(world.apply(&scene)?.reason, Some(RebuildReason::Unbounded));
    assert!(voxel_grid_of(&world).is_clipped);
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    scene.push(ball_at([0.0, 0.4, 0.0]))?;
    assert!(!world.apply(&scene)?.rebuilt);
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    Ok(())
}

/// A scene with a floor and without bounds is baked around its brushes, and bricks follow brushes that are added
/// far away. Each sphere has as many pixels as in a scene of that sphere alone, rendered from the field.
#[test]
fn an_infinite_floor_does_not_hide_what_stands_on_it() -> Outcome {
    let floor = Shape::Plane {
        normal: [0.0, 1.0, 0.0],
        offset: -3.0,
    };
    let mut alone = Scene::new();
    alone.push(ball_at([0.0; 3]))?;
    let engine = Engine::cpu();
    let whole = pixels_of_ball(&engine.build(&alone)?.field(), [0.0; 3]);
    for engine in engines() {
        let mut scene = Scene::new();
        scene.push(Brush::new(floor.clone()))?;
        scene.push(ball_at([20.0, 0.0, 5.0]))?;
        let mut world = bricks_of(&engine, &mut scene, 96);
        assert!(voxel_grid_of(&world).is_clipped);
        let sees = |world: &World, at| {
            let found = pixels_of_ball(world, at);
            // Rays hit bricks from half a pixel away.
            assert!(found.abs_diff(whole) * 10 < whole, "{found} of {whole}");
        };
        sees(&world, [20.0, 0.0, 5.0]);
        // The floor under the ball is in the box, and a hole in it is an edit in place.
        scene.push(
            Brush::new(Shape::sphere(0.3))
                .at([20.0, -3.0, 5.0])
                .subtract(),
        )?;
        assert_eq!(world.apply(&scene)?.reason, None);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        let voxel = voxel_grid_of(&world).voxel_size;
        let far = scene.push(ball_at([-8.0, 0.0, 5.0]))?.node;
        assert_eq!(world.apply(&scene)?.reason, Some(RebuildReason::OutsideBox));
        assert_eq!(voxel_grid_of(&world).voxel_size, voxel);
        sees(&world, [-8.0, 0.0, 5.0]);
        sees(&world, [20.0, 0.0, 5.0]);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
        // The box keeps its size when the ball goes, so that nothing is built again.
        scene.apply(Edit::Remove { node: far })?;
        assert!(!world.apply(&scene)?.rebuilt);
        assert_eq!(world.diff_from_rebuild()?, Some(0));
    }
    Ok(())
}

/// A world that grew survives saving and loading.
#[test]
fn a_grown_world_survives_a_file() -> Outcome {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("grown.argil");
    let mut scene = one_ball()?;
    let mut world = bricks_of(&Engine::cpu(), &mut scene, 64);
    for at in [[-60.0, 0.0, 2.0], [0.0, 300.0, 0.0]] {
        scene.push(ball_at(at))?;
        world.apply(&scene)?;
    }
    world.save(&path)?;
    let (mut scene, mut again) = Engine::cpu().load(VolumeFile::open(&path)?, &path)?;
    assert_eq!(again.diff_from_rebuild()?, Some(0));
    let (ours, theirs) = (world.volume()?, again.volume()?);
    let (Some(Volume::Bricks(ours)), Some(Volume::Bricks(theirs))) =
        (ours.as_deref(), theirs.as_deref())
    else {
        panic!("bricks are kept");
    };
    assert_eq!(ours.differing_cells(theirs), 0);
    scene.push(ball_at([0.0, 0.0, -90.0]))?;
    assert!(!again.apply(&scene)?.rebuilt);
    assert_eq!(again.diff_from_rebuild()?, Some(0));
    Ok(())
}

/// Voxels have the requested size, for any box. An impossible size is refused, and the message names it.
#[test]
fn voxels_are_of_the_size_that_was_asked_for() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::cuboid([1.0, 0.3, 0.5])))?;
    let of = |voxel| BricksOptions {
        voxel_size: Some(voxel),
        ..BricksOptions::default()
    };
    let built = |scene: &Scene, voxel| Engine::cpu().build(scene)?.bricks(of(voxel));
    let mut world = built(&scene, 0.02)?;
    let size = world.resolution().expect("a volume");
    // Two voxels around the box.
    assert_eq!(size, [104, 34, 54]);
    scene.push(Brush::new(Shape::sphere(0.2)).at([5.0, 0.0, 0.0]))?;
    world.apply(&scene)?;
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    for voxel in [f32::NAN, 0.0, -1.0, f32::INFINITY, 1e-9, 1e9] {
        let refused = built(&scene, voxel).expect_err("no such voxels");
        assert!(
            matches!(refused, BuildError::VoxelSize(_)),
            "{voxel}: {refused}"
        );
    }
    Ok(())
}
