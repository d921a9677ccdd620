//! Uses the facade as the README does.

use argil::math::Control;
use argil::mesh::MeshReadError;
use argil::scene::{Brush, Scene, Shape};
use argil::{
    Backend, BricksOptions, DenseOptions, Engine, MeshError, MeshFileError, MeshOptions,
    MeshRenderOptions, OctreeOptions, RenderError, Representation,
};

const SUZANNE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/suzanne.json");
const TEAPOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/teapot.json");

#[test]
fn the_readmes_example() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let mut scene = Scene::open(TEAPOT)?;
    scene.push(
        Brush::new(Shape::sphere(0.4))
            .at([0.3, 0.9, 0.9])
            .subtract()
            .smooth(0.1),
    )?;
    let world = Engine::auto()?.build(&scene)?.field();
    assert!(world.distance([0.0, 2.0, 0.0]) > 0.0);
    world
        .render_view([64, 36])?
        .save(folder.path().join("teapot.png"))?;
    assert!(scene.undo().is_some());
    Ok(())
}

/// An edit changes the image on both devices, and both agree.
#[test]
fn worlds_follow_their_scene() -> Result<(), Box<dyn std::error::Error>> {
    let mut hits = Vec::new();
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.5)))?;
        let mut world = Engine::with_backend(backend)?.build(&scene)?.field();
        let camera = world.camera();
        let settings = world.render_settings([48, 48], argil::render::RenderMode::Normal);
        let before = world.render(&camera, &settings)?.hit_pixels;
        scene.push(Brush::new(Shape::cuboid([0.1, 0.9, 0.1])).smooth(0.05))?;
        world.apply(&scene)?;
        let after = world.render(&camera, &settings)?.hit_pixels;
        assert!(after > before + 20, "{before} {after}");
        hits.push((before, after));
    }
    // Rounding decides for a pixel at the edge.
    let off = |a: usize, b: usize| a.abs_diff(b) <= 2;
    let [cpu, gpu] = [hits[0], hits[1]];
    assert!(off(cpu.0, gpu.0) && off(cpu.1, gpu.1), "{hits:?}");
    Ok(())
}

/// Bricks on the CPU change in place: an edit rebuilds only what it touches, and an edit that cannot be built loses
/// nothing.
#[test]
fn bricks_follow_their_scene_in_place() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::open(TEAPOT)?;
    let mut world = Engine::cpu().build(&scene)?.bricks(128)?;
    let all = world.volume_info()?.and_then(|info| info.bricks);
    let all = all.map_or(0, |sparse| sparse.bricks);
    let dent = Brush::new(Shape::sphere(0.1)).at([0.3, 0.9, 0.9]);
    scene.push(dent.subtract().smooth(0.02))?;
    let applied = world.apply(&scene)?;
    let sampled = world.flush()?.filled;
    assert!(!applied.rebuilt && sampled > 0);
    assert!(sampled * 4 < all, "{sampled} of {all}");
    assert!(applied.dirty_box.contains([0.3, 0.9, 0.9].into()));
    assert_eq!(world.diff_from_rebuild()?, Some(0));

    // Queries and pictures see it.
    let mut before = world.render_view([48, 32])?.hit_pixels;
    assert!(world.distance([0.3, 0.9, 0.9]) > 0.05);

    // What cannot be built changes nothing, and can be taken back.
    let node = scene.push(Brush::new(Shape::sphere(0.1)))?.node;
    let tiny = argil::scene::Modifier::Scale { by: 1e-4 };
    for _ in 0..2 {
        let by = tiny.clone();
        scene.apply(argil::scene::Edit::Transform { node, by })?;
    }
    assert!(world.apply(&scene).is_err());
    assert_eq!(world.render_view([48, 32])?.hit_pixels, before);
    for _ in 0..3 {
        assert!(scene.undo().is_some());
    }
    assert!(!world.apply(&scene)?.rebuilt);
    assert_eq!(world.diff_from_rebuild()?, Some(0));

    // What takes too much memory changes no brick; what comes after is right all the same.
    let tight = argil::BricksOptions {
        memory_budget: Some(world.memory_bytes() * 5 / 4),
        ..argil::BricksOptions::from(128)
    };
    let mut tight = Engine::cpu().build(&scene)?.bricks(tight)?;
    scene.push(Brush::new(Shape::sphere(0.05)).at([0.0, -0.02, 0.0]))?;
    tight.apply(&scene)?;
    for at in [[1.2, 1.2, 0.5], [-1.1, 1.2, -0.5]] {
        scene.push(Brush::new(Shape::sphere(0.45)).at(at))?;
    }
    let refused = tight.apply(&scene);
    assert!(refused.is_err(), "{refused:?}");
    assert!(scene.undo().is_some());
    tight.apply(&scene)?;
    assert_eq!(tight.diff_from_rebuild()?, Some(0));
    for _ in 0..2 {
        assert!(scene.undo().is_some());
    }
    scene.push(Brush::new(Shape::sphere(0.06)).at([0.3, 0.9, 0.9]))?;
    tight.apply(&scene)?;
    assert_eq!(tight.diff_from_rebuild()?, Some(0));
    assert!(scene.undo().is_some());
    world.apply(&scene)?;

    // Nothing left, then everything again; and a clone, whose edits were not followed.
    let nodes: Vec<_> = scene.iter().skip(1).collect();
    for node in nodes {
        let _ = scene.apply(argil::scene::Edit::Remove { node });
    }
    world.apply(&scene)?;
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    assert_eq!(world.render_view([48, 32])?.hit_pixels, 0);
    while scene.undo().is_some() {}
    world.apply(&scene)?;
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    before = world.render_view([48, 32])?.hit_pixels;
    assert!(before > 100, "{before}");
    let mut other = scene.clone();
    other.push(Brush::new(Shape::sphere(0.2)).at([1.0, 1.5, 0.0]))?;
    assert!(world.apply(&other)?.rebuilt);
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    Ok(())
}

/// Where a corner is almost on the surface, the gradient is only the rounding of two points.
#[test]
fn normals_of_fine_meshes_are_the_fields() {
    let text = include_str!("../../../scenes/teapot.json");
    let scene = Scene::from_json(text, "teapot.json").expect("a scene");
    let world = Engine::cpu().build(&scene).expect("a world").field();
    let options = argil::MeshOptions {
        resolution: 400,
        materials: false,
        ..argil::MeshOptions::default()
    };
    let mesh = world.mesh(&options).expect("a mesh").mesh;
    let h = 1e-3 * world.view_bounds().half_diagonal();
    let is_off = |i: &usize| {
        let (p, normal) = (mesh.positions[*i], mesh.normals[*i]);
        let by = [0, 1, 2].map(|axis| {
            let mut step = argil::glam::Vec3::ZERO;
            step[axis] = h;
            world.distance((p + step).to_array()) - world.distance((p - step).to_array())
        });
        argil::glam::Vec3::from(by).normalize_or_zero().dot(normal) < 0.95
    };
    let looked_at = (0..mesh.positions.len()).step_by(7);
    let count = looked_at.len();
    let off = looked_at.filter(is_off).count();
    // At creases both are right, and differ.
    assert!(off * 100 < count, "{off} of {count}");
}

/// Long work ends with an error after it is canceled. With another control it runs again, and earlier results are
/// still there.
#[test]
fn canceled_work_ends_and_loses_nothing() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::open(TEAPOT)?;
    let control = Control::new();
    let engine = Engine::cpu().with_control(&control);
    let mut world = engine.build(&scene)?.field();
    let size = [48, 32];
    let before = world.render_view(size)?.hit_pixels;
    let seen = control.progress().expect("the picture told of itself");
    assert!(seen.stage == "picture" && seen.total > 0 && seen.done == seen.total);
    control.cancel();
    let picture = world.render_view(size);
    assert!(matches!(picture, Err(RenderError::Cancelled)));
    let mesh = world.mesh(&MeshOptions::default());
    assert!(matches!(mesh, Err(MeshError::Build(error)) if error.is_cancelled()));
    let vias = [
        Representation::Dense(DenseOptions::default()),
        Representation::Octree(OctreeOptions::default()),
        Representation::Bricks(BricksOptions::default()),
        Representation::Mesh(MeshRenderOptions::default()),
    ];
    for via in vias {
        let built = engine.build(&scene)?.with_representation(via);
        assert!(built.is_err_and(|error| error.is_cancelled()), "{via:?}");
    }
    world.set_control(&Control::new());
    assert_eq!(world.render_view(size)?.hit_pixels, before);

    // A world whose edit makes all anew.
    let mut world = Engine::cpu()
        .build(&scene)?
        .dense(DenseOptions::default())?;
    let before = world.render_view(size)?.hit_pixels;
    scene.push(Brush::new(Shape::sphere(0.7)).at([0.0, 2.5, 0.0]))?;
    world.set_control(&control);
    assert!(world.apply(&scene).is_err_and(|error| error.is_cancelled()));
    world.set_control(&Control::new());
    assert_eq!(world.render_view(size)?.hit_pixels, before);
    assert!(world.apply(&scene)?.rebuilt);
    assert_ne!(world.render_view(size)?.hit_pixels, before);

    // A mesh that a scene names.
    let mut scene = Scene::open(SUZANNE)?;
    let folder = std::path::Path::new(SUZANNE).parent().expect("a folder");
    let loaded = argil::load_meshes_with_control(&mut scene, folder, false, &control);
    let was_kept = loaded
        .as_ref()
        .is_ok_and(|all| all.iter().all(|mesh| mesh.from_cache));
    let is_cancelled = matches!(loaded, Err(MeshFileError::Input(MeshReadError::Cancelled)));
    assert!(is_cancelled || was_kept);
    Ok(())
}

/// A multi-threaded program can move work that waits for a device between threads.
#[cfg(not(target_arch = "wasm32"))]
#[test]
fn futures_can_be_sent() -> Result<(), Box<dyn std::error::Error>> {
    fn sent<F: Future + Send>(future: F) -> F {
        future
    }
    let mut scene = Scene::open(TEAPOT)?;
    let options = BricksOptions {
        resolution: 24,
        ..BricksOptions::default()
    };
    let engine = pollster::block_on(sent(Engine::with_backend_async(Backend::Cpu)))?;
    let built = engine.build(&scene)?;
    let mut world = pollster::block_on(sent(built.with_representation_async(options)))?;
    scene.push(Brush::new(Shape::sphere(0.4)))?;
    pollster::block_on(sent(world.apply_async(&scene)))?;
    pollster::block_on(sent(world.flush_async()))?;
    pollster::block_on(sent(world.volume_info_async()))?;
    let camera = world.camera();
    let settings = world.render_settings([16, 16], argil::render::RenderMode::Normal);
    let drawn = pollster::block_on(sent(world.render_async(&camera, &settings)))?;
    let (again, _) =
        pollster::block_on(sent(world.render_with_distances_async(&camera, &settings)))?;
    assert_eq!(drawn.hit_pixels, again.hit_pixels);
    Ok(())
}

/// A function becomes a brush. After saving, loading, and storing in a volume it is the same, and a damaged one is
/// refused.
#[test]
fn sampled_functions_are_brushes() -> Result<(), Box<dyn std::error::Error>> {
    let here = tempfile::tempdir()?;
    let ring = |[x, y, z]: [f32; 3]| (x.hypot(z) - 0.5).hypot(y) - 0.2;
    let solid = [[-0.7, -0.2, -0.7], [0.7, 0.2, 0.7]];
    let grid = argil::scene::SampledGrid::from_fn(solid, 96, ring)?;
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::sampled("ring", grid)))?;
    let place = here.path().join("scene.json");
    scene.save(&place)?;
    let file = here.path().join("ring.grid");
    let bytes = std::fs::read(&file)?;
    let mut again = Scene::open(&place)?;
    let loaded = argil::load_meshes(&mut again, here.path(), false)?;
    assert_eq!(loaded.len(), 1);
    for scene in [&scene, &again] {
        let world = Engine::cpu().build(scene)?.field();
        let exact = Engine::cpu();
        let mut torus = Scene::new();
        torus.push(Brush::new(Shape::torus(0.5, 0.2)))?;
        let torus = exact.build(&torus)?.field();
        for i in 0..200 {
            let along = |k: u32| 1.6 * ((i * k) % 97) as f32 / 97.0 - 0.8;
            let p = [along(13), 0.5 * along(31), along(57)];
            let [truth, told] = [&torus, &world].map(|world| world.distance(p));
            // Exact near the surface; elsewhere what lies between coarse samples is a little off.
            let room = if truth.abs() < 0.02 { 0.004 } else { 0.02 };
            assert!(told <= truth + room, "{p:?}: {told} and {truth}");
            assert!(
                truth.abs() > 0.02 || told > truth - room,
                "{p:?}: {told} and {truth}"
            );
        }
    }
    for end in [4, 60, bytes.len() - 4, bytes.len() - 1] {
        std::fs::write(&file, &bytes[..end])?;
        let mut broken = Scene::open(&place)?;
        let refused = argil::load_meshes(&mut broken, here.path(), false);
        let refused = refused.expect_err("a part of a grid").to_string();
        assert!(refused.contains("ring.grid"), "{refused}");
    }
    let of =
        |solid, resolution| argil::scene::SampledGrid::from_fn(solid, resolution, ring).map(|_| ());
    assert!(of([[0.0; 3]; 2], 96).is_err() && of(solid, 8).is_err() && of(solid, 513).is_err());
    assert!(of([[2.0; 3], [3.0; 3]], 32).is_err(), "nothing is inside");
    assert!(argil::scene::SampledGrid::from_fn(solid, 32, |_| f32::NAN).is_err());
    Ok(())
}

/// A sampled function ends at its box, has its own file name next to the scene, and is not written anywhere else.
#[test]
fn sampled_functions_stay_where_they_belong() -> Result<(), Box<dyn std::error::Error>> {
    let here = tempfile::tempdir()?;
    let folder = here.path().join("scene");
    std::fs::create_dir(&folder)?;
    let ball = |radius: f32| {
        let of = move |[x, y, z]: [f32; 3]| (x * x + y * y + z * z).sqrt() - radius;
        argil::scene::SampledGrid::from_fn([[-0.5; 3], [0.5; 3]], 32, of)
    };
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::sampled("a", ball(0.8)?)))?;
    let world = Engine::cpu().build(&scene)?.field();
    let hit = world
        .query()
        .cast_ray([2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], 5.0);
    let hit = hit.expect("its side");
    assert!((hit.point[0] - 0.5).abs() < 0.01, "{hit:?}");
    scene.save(folder.join("scene.json"))?;

    // Another under the same name is another brush, which a file cannot hold too.
    let mut again = Scene::open(folder.join("scene.json"))?;
    argil::load_meshes(&mut again, &folder, false)?;
    let node = again.node(Scene::ROOT).children()[0];
    let entry = Brush::new(Shape::sampled("a", ball(0.2)?)).into();
    again.apply(argil::scene::Edit::Replace { node, desc: entry })?;
    let world = Engine::cpu().build(&again)?.field();
    let told = world.distance([0.2, 0.0, 0.0]);
    assert!(told.abs() < 0.02, "{told}");
    again.push(Brush::new(Shape::sampled("a", ball(0.4)?)))?;
    assert!(again.save(folder.join("two.json")).is_err());
    let elsewhere = here.path().join("b").display().to_string();
    for name in ["../b", "sub/b", &elsewhere] {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sampled(name, ball(0.3)?)))?;
        assert!(scene.save(folder.join("out.json")).is_err(), "{name}");
    }
    assert!(!here.path().join("b.grid").exists() && !folder.join("out.json").exists());
    let steep = argil::scene::SampledGrid::from_fn([[-0.5; 3], [0.5; 3]], 32, |[x, _, _]| 1e6 * x);
    assert!(steep.is_err());
    Ok(())
}

/// A cliff in a heightmap gives a warning, because all distances are shorter for it.
#[test]
fn cliffs_give_a_warning() -> Result<(), Box<dyn std::error::Error>> {
    let here = tempfile::tempdir()?;
    for (name, spike, count) in [("smooth", 100, 0), ("spike", 255, 1)] {
        let height = |i: u32| {
            if i == 1_234 {
                spike
            } else {
                90 + (i % 64) as u8 / 3
            }
        };
        let image: Vec<u8> = (0..64 * 64).flat_map(|i| [height(i); 3]).collect();
        let file = format!("{name}.png");
        argil::save_png(&here.path().join(&file), [64, 64], &image)?;
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::heightmap(file, [1.0, 1.0], 0.5)))?;
        let loaded = argil::load_meshes(&mut scene, here.path(), false)?;
        assert_eq!(loaded[0].warnings().len(), count, "{name}");
    }
    Ok(())
}

/// An image becomes terrain as high as its pixels are bright, on both devices and in bricks. In a volume file it
/// needs no other file.
#[test]
fn images_are_ground() -> Result<(), Box<dyn std::error::Error>> {
    let here = tempfile::tempdir()?;
    // White along x = 1, black along x = −1.
    let ramp: Vec<u8> = (0..64 * 48)
        .flat_map(|i| [(i % 64 * 255 / 63) as u8; 3])
        .collect();
    argil::save_png(&here.path().join("ramp.png"), [64, 48], &ramp)?;
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::heightmap("ramp.png", [1.0, 0.75], 0.5)))?;
    argil::load_meshes(&mut scene, here.path(), false)?;
    for engine in [Engine::cpu(), Engine::with_backend(Backend::Gpu)?] {
        let world = engine.build(&scene)?.bricks(96)?;
        let picture = world.render_view([96, 64])?;
        assert!(picture.hit_pixels > 500, "{}", picture.hit_pixels);
    }
    let world = Engine::cpu().build(&scene)?.bricks(128)?;
    for query in [world.query(), world.query_volume().expect("bricks")] {
        for (x, height) in [(-0.9, 0.025), (0.0, 0.25), (0.7, 0.425)] {
            let hit = query
                .cast_ray([x, 2.0, 0.1], [0.0, -1.0, 0.0], 5.0)
                .expect("ground");
            assert!((hit.point[1] - height).abs() < 0.01, "{hit:?}");
            let hit = query
                .cast_ray([x, -2.0, 0.1], [0.0, 1.0, 0.0], 5.0)
                .expect("its bottom");
            assert!((hit.point[1] + 0.1).abs() < 0.01, "{hit:?}");
        }
    }
    let file = here.path().join("ramp.argil");
    world.save(&file)?;
    std::fs::remove_file(here.path().join("ramp.png"))?;
    let (_, world) = Engine::cpu().load(argil::volume::VolumeFile::open(&file)?, &file)?;
    assert_eq!(world.diff_from_rebuild()?, Some(0));
    Ok(())
}
