//! Stills by path tracing hold light together, and agree with other ways to find it.

use argil::math::Control;
use argil::prelude::*;
use argil::render::{PathLights, PathView, StillOptions, denoised, frame_uniforms, trace_paths};
use argil::scene::Material;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// Walls, a hollow and a blend: light goes from surface to surface.
fn scene(material: Material) -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.set_material("own", material)?;
    let mut put = |brush: Brush| scene.push(brush.with_material("own")).map(drop);
    put(Brush::new(Shape::cuboid([1.0, 0.1, 1.0])))?;
    put(Brush::new(Shape::cuboid([0.1, 0.8, 1.0]))
        .at([-0.8, 0.5, 0.0])
        .smooth(0.1))?;
    put(Brush::new(Shape::sphere(0.4))
        .at([0.2, 0.4, 0.0])
        .smooth(0.05))?;
    put(Brush::new(Shape::sphere(0.3))
        .at([0.4, 0.6, 0.2])
        .subtract())?;
    Ok(scene)
}

fn luminance([r, g, b]: [f32; 3]) -> f64 {
    f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b)
}

fn mean(picture: &[[f32; 3]]) -> f64 {
    picture.iter().map(|&light| luminance(light)).sum::<f64>() / picture.len() as f64
}

/// In a white furnace, all that is white is as bright as the furnace, and cannot be seen: in each square of pixels within
/// 0.5 %.
#[test]
fn white_surfaces_vanish_in_a_furnace() -> Outcome {
    for (roughness, metallic) in [(0.1, 0.0), (0.6, 0.0), (0.3, 1.0), (1.0, 1.0), (0.5, 0.5)] {
        let scene = scene(Material {
            base_color: [1.0; 3],
            roughness,
            metallic,
            ..Material::default()
        })?;
        let world = Engine::cpu().build(&scene)?.field();
        let settings = RenderSettings {
            samples: 1,
            ..world.render_settings([64, 48], RenderMode::Shaded)
        };
        let frames = frame_uniforms(
            &settings,
            &world.camera(),
            world.program(),
            None,
            world.view_bounds(),
        );
        let options = StillOptions {
            samples: 200,
            max_bounces: 1024,
            ..StillOptions::default()
        };
        let view = PathView::new(PathLights::even([1.0; 3]));
        let still = trace_paths(
            &world.query(),
            &view,
            &frames[0],
            &options,
            &Control::default(),
        );
        let light = still.radiance();
        assert!(still.hit_pixels() > 300);
        for y in (0..48).step_by(16) {
            for x in (0..64).step_by(16) {
                let rows = (y..y + 16).map(|y| &light[64 * y + x..64 * y + x + 16]);
                let brightness = mean(&rows.flatten().copied().collect::<Vec<_>>());
                assert!(
                    (brightness - 1.0).abs() < 0.005,
                    "{roughness} {metallic}: {brightness} at {x}, {y}"
                );
            }
        }
    }
    Ok(())
}

/// Paths through bricks and dense volumes find the light of those through the field, within their noise and what voxels
/// leave out.
#[test]
fn volumes_are_lit_as_the_field() -> Outcome {
    let clay = Material {
        roughness: 0.6,
        ..Material::colored([0.7, 0.4, 0.3])
    };
    let scene = scene(clay)?;
    let options = StillOptions {
        samples: 32,
        ..StillOptions::default()
    };
    let still = |world: World| -> Result<_, Box<dyn std::error::Error>> {
        let settings = world.render_settings([96, 72], RenderMode::Shaded);
        Ok(world.still(&world.camera(), &settings, &options)?)
    };
    let engine = Engine::cpu();
    let field = still(engine.build(&scene)?.field())?;
    for world in [
        engine.build(&scene)?.bricks(256)?,
        engine.build(&scene)?.dense(128)?,
    ] {
        let name = world.representation().name();
        let other = still(world)?;
        let (a, b) = (field.radiance(), other.radiance());
        assert!(
            (mean(&a) / mean(&b) - 1.0).abs() < 0.01,
            "{name}: {} {}",
            mean(&a),
            mean(&b)
        );
        // Squares that differ by more than four standard deviations and 3 % are at edges.
        let (va, vb) = (field.variance(), other.variance());
        let mut far = 0;
        for y in (0..72).step_by(8) {
            for x in (0..96).step_by(8) {
                let all = || (0..64).map(|i| 96 * (y + i / 8) + x + i % 8);
                let sum = |of: &[[f32; 3]]| all().map(|i| luminance(of[i])).sum::<f64>() / 64.0;
                let deviation = all()
                    .map(|i| luminance(va[i]) + luminance(vb[i]))
                    .sum::<f64>()
                    .sqrt()
                    / 64.0;
                let off = (sum(&a) - sum(&b)).abs();
                far += usize::from(off > 4.0 * deviation + 0.03 * sum(&a));
            }
        }
        assert!(far <= 2, "{name}: {far} of 108 squares");
    }
    Ok(())
}

/// Without noise, an image is nearer to one of many paths. The variance tells how far it is off.
#[test]
fn noise_is_known_and_removed() -> Outcome {
    let world = Engine::cpu()
        .build(&scene(Material::colored([0.5, 0.6, 0.7]))?)?
        .bricks(128)?;
    let settings = world.render_settings([128, 96], RenderMode::Shaded);
    let still = |samples| {
        let options = StillOptions {
            samples,
            ..StillOptions::default()
        };
        world.still(&world.camera(), &settings, &options)
    };
    let (few, many) = (still(4)?, still(64)?);
    let truth = many.radiance();
    let error = |picture: &[[f32; 3]]| {
        let squares = picture
            .iter()
            .zip(&truth)
            .map(|(a, b)| (luminance(*a) - luminance(*b)).powi(2));
        squares.sum::<f64>() / truth.len() as f64
    };
    let (noisy, denoised) = (error(&few.radiance()), error(&denoised(&few)));
    assert!(denoised < 0.5 * noisy, "{denoised} of {noisy}");
    let variance = still(16)?;
    let known = mean(
        &variance
            .variance()
            .iter()
            .map(|v| v.map(f32::abs))
            .collect::<Vec<_>>(),
    );
    let found = error(&variance.radiance());
    assert!((0.3..3.0).contains(&(found / known)), "{found} {known}");
    Ok(())
}

/// What cannot be is refused. Canceled work ends soon.
#[test]
fn senseless_stills_are_refused() -> Outcome {
    let scene = scene(Material::default())?;
    let world = Engine::cpu().build(&scene)?.field();
    let settings = world.render_settings([16, 16], RenderMode::Shaded);
    for (samples, max_bounces) in [(0, 8), (u32::MAX, 8), (1, 0), (1, 100_000)] {
        let options = StillOptions {
            samples,
            max_bounces,
            ..StillOptions::default()
        };
        let refused = world.still(&world.camera(), &settings, &options);
        assert!(refused.is_err(), "{samples} {max_bounces}");
    }
    let tree = Engine::cpu()
        .build(&scene)?
        .with_representation(argil::OctreeOptions::default())?;
    let refused = tree.still(&tree.camera(), &settings, &StillOptions::default());
    assert!(
        refused
            .expect_err("an octree")
            .to_string()
            .contains("octree")
    );
    let control = Control::new();
    control.cancel();
    let world = Engine::cpu().with_control(&control).build(&scene)?.field();
    let still = world.still(&world.camera(), &settings, &StillOptions::default())?;
    assert_eq!(still.samples(), 0);
    Ok(())
}

/// Rays have a normal where they end right on the surface, also of shapes whose gradient is none there.
#[test]
fn all_hits_have_normals() -> Outcome {
    let teapot = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/teapot.json");
    let world = Engine::cpu().build(&Scene::open(teapot)?)?.field();
    let camera = world.camera();
    let forward = (camera.target - camera.eye).normalize();
    let (right, up) = forward.any_orthonormal_pair();
    let mut hits = 0;
    for i in 0..40_000u32 {
        let [u, v] = [(i % 200) as f32, (i / 200) as f32].map(|c| 0.3 * (c / 200.0 - 0.5));
        let direction = forward + u * right + v * up;
        if let Some(hit) =
            world
                .query()
                .cast_ray(camera.eye.to_array(), direction.to_array(), 100.0)
        {
            let length: f32 = hit.normal.iter().map(|c| c * c).sum();
            assert!((length - 1.0).abs() < 1e-3, "{i}: {hit:?}");
            hits += 1;
        }
    }
    assert!(hits > 10_000, "{hits}");
    Ok(())
}

/// A limit that ends the first pass leaves paths that are spread evenly. They are those of a still without a limit, and other pixels
/// show their nearest neighbor.
#[test]
fn a_short_limit_spreads_paths() -> Outcome {
    let world = Engine::cpu().build(&scene(Material::default())?)?.field();
    let size = [61, 46];
    let settings = world.render_settings(size, RenderMode::Shaded);
    let traced = |time_limit| {
        let options = StillOptions {
            samples: 1,
            time_limit,
            ..StillOptions::default()
        };
        world.still(&world.camera(), &settings, &options)
    };
    let whole = traced(None)?;
    let mut sparse = traced(Some(std::time::Duration::ZERO))?;
    assert_eq!((whole.samples(), sparse.samples()), (1, 0));
    let [width, height] = size.map(|side| side as usize);
    let cells = width.div_ceil(4) * height.div_ceil(4);
    assert_eq!(sparse.fill_gaps(), width * height - cells);
    assert_eq!((sparse.samples(), sparse.fill_gaps()), (1, 0));
    let ends_in_time = traced(Some(std::time::Duration::from_secs(3600)))?;
    assert_eq!(ends_in_time.radiance(), whole.radiance());
    let [whole, sparse] = [whole.radiance(), sparse.radiance()];
    for (i, light) in sparse.iter().enumerate() {
        let known = ((i / width) & !3) * width + ((i % width) & !3);
        assert_eq!(*light, whole[known], "pixel {i}");
    }
    // Each call goes on with the pixels that have none.
    let mut still = argil::render::Still::new(size);
    let options = StillOptions {
        samples: 1,
        time_limit: Some(std::time::Duration::ZERO),
        ..StillOptions::default()
    };
    for _ in 0..16 {
        assert_eq!(still.samples(), 0);
        world.refine_still(&mut still, &world.camera(), &settings, &options)?;
    }
    assert_eq!(still.radiance(), whole);
    Ok(())
}
