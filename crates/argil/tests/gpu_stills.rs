//! Stills of the GPU against those of the CPU.

use argil::prelude::*;
use argil::render::{Still, StillOptions};
use argil::scene::{Environment, SceneImage};
use argil::{Backend, StillError};
use std::sync::Arc;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const SIZE: [u32; 2] = [24, 16];
/// The most that rounding makes of the field's paths, as a part of their noise, and of a volume's, whose filters round more.
const OF_FIELDS: f64 = 0.05;
const OF_VOLUMES: f64 = 0.15;
/// Pixels along the side of a block.
const BLOCK: u32 = 4;

/// The floor's material.
const GRAY: &str = r#"{"base_color": [0.6, 0.5, 0.4], "roughness": 1}"#;

fn scene(view: &str, materials: &str, brushes: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    scene_on(GRAY, view, materials, brushes)
}

fn scene_on(
    floor: &str,
    view: &str,
    materials: &str,
    brushes: &str,
) -> Result<Scene, Box<dyn std::error::Error>> {
    let text = format!(
        r#"{{"argil": 1,
        "view": {{"camera": {{"look_at": {{"eye": [0.5, 1.2, 3.2], "target": [0, 0.35, 0]}}}}, "field_of_view_degrees": 40{view}}},
        "materials": {{"gray": {floor} {materials}}},
        "brushes": [{{"shape": {{"type": "box", "half_size": [2.5, 0.2, 2.5]}}, "material": "gray",
            "modifiers": [{{"type": "translate", "by": [0, -0.2, 0]}}]}}, {brushes}]}}"#
    );
    Ok(Scene::from_json(&text, "stills")?)
}

fn brush(shape: &str, material: &str, at: [f32; 3]) -> String {
    format!(
        r#"{{"shape": {{{shape}}}, "material": "{material}", "modifiers": [{{"type": "translate", "by": {at:?}}}]}}"#
    )
}

/// How two stills differ. Both devices use the same random numbers, so that only few paths differ.
#[derive(Debug)]
struct Difference {
    /// Of the means of both, as a share.
    mean: f64,
    /// Of blocks, in standard deviations of their noise: the root of the mean square, and the most.
    deviations: [f64; 2],
}

impl Difference {
    /// Whether rounding explains it, which sends some paths elsewhere. `limit` is a part of their noise.
    fn is_rounding(&self, limit: f64) -> bool {
        let [usual, most] = self.deviations;
        self.mean < 0.001 && usual < limit && most < 10.0 * limit
    }
}

fn difference(a: &Still, b: &Still) -> Difference {
    let lights = [a, b].map(Still::radiance);
    let noise = [a, b].map(Still::variance);
    let mean = |all: &[[f32; 3]]| {
        all.as_flattened()
            .iter()
            .map(|&c| f64::from(c))
            .sum::<f64>()
    };
    let [of_a, of_b] = lights.each_ref().map(|all| mean(all));
    let (mut squares, mut most, mut count) = (0.0, 0.0f64, 0.0);
    for first_y in (0..SIZE[1]).step_by(BLOCK as usize) {
        for first_x in (0..SIZE[0]).step_by(BLOCK as usize) {
            for channel in 0..3 {
                let (mut apart, mut variance) = (0.0, 0.0);
                for index in 0..BLOCK * BLOCK {
                    let (x, y) = (first_x + index % BLOCK, first_y + index / BLOCK);
                    let at = (y * SIZE[0] + x) as usize;
                    let [first, other] = lights.each_ref().map(|all| f64::from(all[at][channel]));
                    apart += first - other;
                    let [first, other] = noise.each_ref().map(|all| f64::from(all[at][channel]));
                    variance += first + other;
                }
                // Light without noise is rounded.
                let variance = variance + (1e-4 * f64::from(BLOCK * BLOCK)).powi(2);
                let deviations = apart / variance.sqrt();
                squares += deviations * deviations;
                most = most.max(deviations.abs());
                count += 1.0;
            }
        }
    }
    Difference {
        mean: (of_a - of_b).abs() / of_a.max(of_b),
        deviations: [(squares / count).sqrt(), most],
    }
}

fn still(world: &World, samples: u32) -> Result<Still, StillError> {
    let options = StillOptions {
        samples,
        ..StillOptions::default()
    };
    let settings = world.render_settings(SIZE, RenderMode::Shaded);
    world.still(&world.camera(), &settings, &options)
}

fn assert_same(what: &str, a: &Still, b: &Still, limit: f64) {
    let found = difference(a, b);
    println!("{what}: {found:?}");
    assert!(found.is_rounding(limit), "{what}: {found:?}");
}

fn worlds(scene: &Scene) -> Result<[World; 2], Box<dyn std::error::Error>> {
    let on = |engine: Engine| Ok::<_, Box<dyn std::error::Error>>(engine.build(scene)?.field());
    Ok([on(Engine::cpu())?, on(Engine::with_backend(Backend::Gpu)?)?])
}

fn assert_agrees(what: &str, scene: &Scene, samples: u32, limit: f64) -> Outcome {
    let [on_cpu, on_gpu] = worlds(scene)?;
    let found = still(&on_gpu, samples)?;
    assert_same(what, &still(&on_cpu, samples)?, &found, limit);
    Ok(())
}

const ALL_LIGHTS: &str = r#", "environment": {"type": "color", "radiance": [0.05, 0.08, 0.1]}, "lights": [
    {"type": "sun", "direction_degrees": [40, 50], "irradiance": [1, 0.9, 0.8], "angle_degrees": 4},
    {"type": "point", "at": [-1, 1.2, 1], "intensity": [1, 0.2, 0.2]},
    {"type": "point", "at": [1.2, 0.9, 0.4], "intensity": [0.3, 0.5, 1], "radius": 0.2},
    {"type": "spot", "at": [0, 2, 1.5], "target": [0.2, 0, 0], "intensity": [2, 3, 2], "angle_degrees": 70, "fade": 0.9, "radius": 0.05},
    {"type": "area", "at": [-1.5, 1.5, -0.5], "target": [0, 0, 0], "size": [0.8, 0.5], "radiance": [2, 2, 3]}]"#;

/// All kinds of lights, on rough and smooth surfaces, metals, and surfaces that shine.
#[test]
fn lights_agree() -> Outcome {
    let materials = r#", "gold": {"base_color": [0.9, 0.7, 0.3], "metallic": 1, "roughness": 0.3},
        "gloss": {"base_color": [0.1, 0.3, 0.6], "roughness": 0.15}, "lamp": {"emission": [3, 1, 0.5]}"#;
    let brushes = [
        brush(
            r#""type": "sphere", "radius": 0.4"#,
            "gold",
            [-0.6, 0.4, 0.0],
        ),
        brush(
            r#""type": "box", "half_size": [0.3, 0.3, 0.3]"#,
            "gloss",
            [0.3, 0.3, -0.2],
        ),
        brush(
            r#""type": "torus", "major_radius": 0.3, "minor_radius": 0.1"#,
            "lamp",
            [0.9, 0.1, 0.6],
        ),
    ];
    let lit = scene(ALL_LIGHTS, materials, &brushes.join(","))?;
    let [on_cpu, on_gpu] = worlds(&lit)?;
    let found = still(&on_gpu, 64)?;
    assert_same("lights", &still(&on_cpu, 64)?, &found, OF_FIELDS);
    // Control: a slightly rougher metal is another picture.
    let rougher = materials.replace(r#""roughness": 0.3"#, r#""roughness": 0.33"#);
    let other = scene(ALL_LIGHTS, &rougher, &brushes.join(","))?;
    let world = Engine::cpu().build(&other)?.field();
    let control = difference(&still(&world, 64)?, &found);
    assert!(!control.is_rounding(OF_FIELDS), "{control:?}");
    Ok(())
}

/// An image behind everything, fog, the ground, and a lens.
fn foggy() -> Result<Scene, Box<dyn std::error::Error>> {
    let view = r#", "ground": true, "lens": {"aperture_radius": 0.05, "focus_distance": 3},
        "fog": {"density": 0.25, "falloff": 0.8, "height": 0.3, "anisotropy": 0.5, "albedo": [0.9, 0.8, 0.7]},
        "lights": [{"type": "spot", "at": [0, 2, 1.5], "target": [0.2, 0, 0], "intensity": [2, 3, 2], "angle_degrees": 40}],
        "environment": {"type": "image", "path": "a.hdr", "turn_degrees": 70, "strength": 0.7}"#;
    let sphere = brush(
        r#""type": "sphere", "radius": 0.4"#,
        "gray",
        [-0.3, 0.4, 0.0],
    );
    let mut scene = scene(view, "", &sphere)?;
    let pixels = (0..16 * 8).map(|index| {
        let (x, y) = (index % 16, index / 16);
        let sun = if x == 5 && y == 2 { 40.0 } else { 0.0 };
        [
            0.2 + 0.05 * x as f32 + sun,
            0.6 - 0.05 * y as f32 + sun,
            0.3 + sun,
        ]
    });
    let image = Arc::new(SceneImage {
        size: [16, 8],
        pixels: pixels.collect(),
    });
    if let Environment::Image { image: place, .. } = &mut scene.view.environment {
        place.0 = Some(image);
    }
    Ok(scene)
}

#[test]
fn fog_lenses_and_images_agree() -> Outcome {
    assert_agrees("fog", &foggy()?, 64, OF_FIELDS)
}

/// Clear, colored and rough glass, one of which is one solid with something opaque, by the interpreter and by a shader for this
/// scene alone.
#[test]
fn glass_agrees() -> Outcome {
    let materials = r#", "clear": {"transmission": 1, "roughness": 0, "base_color": [1, 1, 1]},
        "amber": {"transmission": 1, "roughness": 0.3, "base_color": [0.9, 0.5, 0.2], "attenuation_distance": 0.5, "refractive_index": 1.3},
        "half": {"transmission": 0.5, "roughness": 0.2, "base_color": [0.3, 0.8, 0.4]}"#;
    let brushes = [
        brush(
            r#""type": "sphere", "radius": 0.7"#,
            "clear",
            [-0.5, 0.702, 0.0],
        ),
        brush(
            r#""type": "box", "half_size": [0.25, 1.0, 0.25]"#,
            "gray",
            [-0.5, 0.702, 0.0],
        ),
        brush(
            r#""type": "box", "half_size": [0.3, 0.3, 0.3], "rounding": 0.1"#,
            "amber",
            [0.2, 0.302, -0.2],
        ),
        brush(
            r#""type": "sphere", "radius": 0.25"#,
            "half",
            [0.8, 0.252, 0.5],
        ),
    ];
    let view = r#", "lights": [{"type": "area", "at": [-1.5, 2.5, 1.5], "target": [0, 0, 0], "size": [2, 2], "radiance": [2, 2, 2]}]"#;
    let lit = scene(view, materials, &brushes.join(","))?;
    let [on_cpu, mut on_gpu] = worlds(&lit)?;
    let expected = still(&on_cpu, 64)?;
    assert_same("glass", &expected, &still(&on_gpu, 64)?, OF_FIELDS);
    on_gpu.specialize()?;
    let found = still(&on_gpu, 64)?;
    assert_same("a shader of its own", &expected, &found, OF_FIELDS);
    Ok(())
}

/// Patterns in color, roughness, metalness and height.
#[test]
fn textures_agree() -> Outcome {
    let material = |pattern: &str, size: f32| {
        let texture = |high: &str| {
            format!(
                r#"{{"pattern": {{"type": "{pattern}"}}, "size": {size}, "low": 0.1, "high": {high}}}"#
            )
        };
        format!(
            r#"{{"textures": {{"base_color": {{"pattern": {{"type": "{pattern}"}}, "size": {size}, "high": [0.9, 0.5, 0.2]}},
            "roughness": {}, "metallic": {}, "bump": {}}}}}"#,
            texture("0.9"),
            texture("1"),
            texture("0.13")
        )
    };
    let materials = format!(
        r#", "a": {}, "b": {}, "c": {}"#,
        material("stripes", 0.3),
        material("noise", 0.15),
        material("marble", 0.4)
    );
    let brushes = [
        brush(r#""type": "sphere", "radius": 0.4"#, "a", [-0.6, 0.4, 0.0]),
        brush(
            r#""type": "box", "half_size": [0.3, 0.3, 0.3], "rounding": 0.1"#,
            "b",
            [0.3, 0.3, -0.2],
        ),
        brush(
            r#""type": "torus", "major_radius": 0.3, "minor_radius": 0.1"#,
            "c",
            [0.9, 0.1, 0.6],
        ),
    ];
    let textured = scene("", &materials, &brushes.join(","))?;
    assert_agrees("textures", &textured, 24, OF_FIELDS)
}

/// Bricks and dense volumes, with their own materials; what has no paths says so.
#[test]
fn volumes_agree() -> Outcome {
    let materials = r#", "red": {"base_color": [0.8, 0.1, 0.1]}, "blue": {"base_color": [0.1, 0.2, 0.8], "metallic": 1, "roughness": 0.4}"#;
    let brushes = [
        brush(
            r#""type": "sphere", "radius": 0.4"#,
            "red",
            [-0.3, 0.4, 0.0],
        ),
        brush(
            r#""type": "box", "half_size": [0.3, 0.3, 0.3]"#,
            "blue",
            [0.3, 0.3, -0.2],
        )
        .replace(r#""material""#, r#""blend": 0.1, "material""#),
    ];
    let lit = scene(ALL_LIGHTS, materials, &brushes.join(","))?;
    let engines = [Engine::cpu(), Engine::with_backend(Backend::Gpu)?];
    for representation in [
        Representation::Bricks(96.into()),
        Representation::Dense(64.into()),
    ] {
        let build = |engine: &Engine| engine.build(&lit)?.with_representation(representation);
        let [a, b] = engines.each_ref().map(build);
        let (a, b) = (still(&a?, 64)?, still(&b?, 64)?);
        assert_same(representation.name(), &a, &b, OF_VOLUMES);
    }
    let octree = engines[1].build(&lit)?.octree(32)?;
    let error = still(&octree, 1).expect_err("octrees have no paths");
    assert!(error.to_string().contains("octree"), "{error}");
    Ok(())
}

/// Nothing is lost or made in a white room: a white floor, a rough metal, a gloss and clear glass vanish.
#[test]
fn white_surfaces_vanish_in_a_white_room() -> Outcome {
    let materials = r#", "white": {"base_color": [1, 1, 1], "roughness": 0.6}, "metal": {"base_color": [1, 1, 1], "metallic": 1, "roughness": 0.5},
        "glass": {"base_color": [1, 1, 1], "transmission": 1, "roughness": 0}"#;
    let brushes = [
        brush(
            r#""type": "sphere", "radius": 0.4"#,
            "white",
            [-0.6, 0.4, 0.0],
        ),
        brush(
            r#""type": "sphere", "radius": 0.3"#,
            "metal",
            [0.2, 0.3, 0.0],
        ),
        brush(
            r#""type": "sphere", "radius": 0.3"#,
            "glass",
            [0.8, 0.302, 0.4],
        ),
    ];
    let view = r#", "lights": [], "environment": {"type": "color", "radiance": [1, 1, 1]}"#;
    let floor = r#"{"base_color": [1, 1, 1], "roughness": 1}"#;
    let furnace = scene_on(floor, view, materials, &brushes.join(","))?;
    let world = Engine::with_backend(Backend::Gpu)?.build(&furnace)?.field();
    let found = still(&world, 64)?.radiance();
    let mean = found.iter().map(|light| f64::from(light[1])).sum::<f64>() / found.len() as f64;
    assert!((mean - 1.0).abs() < 0.005, "{mean}");
    Ok(())
}

/// Stills go on where they ended, leave out what is behind, and remove what is too bright, as the CPU's do.
#[test]
fn options_agree() -> Outcome {
    let materials = r#", "gold": {"base_color": [0.9, 0.7, 0.3], "metallic": 1, "roughness": 0.1}"#;
    let sphere = brush(
        r#""type": "sphere", "radius": 0.4"#,
        "gold",
        [-0.6, 0.4, 0.0],
    );
    let lit = scene(r#", "ground": true"#, materials, &sphere)?;
    let options = StillOptions {
        samples: 16,
        firefly_clamp: Some(0.5),
        is_transparent: true,
        max_bounces: 4,
        ..StillOptions::default()
    };
    let [a, b] = worlds(&lit)?.map(|world| {
        let settings = world.render_settings(SIZE, RenderMode::Shaded);
        let mut still = world.still(&world.camera(), &settings, &options)?;
        world.refine_still(&mut still, &world.camera(), &settings, &options)?;
        Ok::<_, StillError>(still)
    });
    let (a, b) = (a?, b?);
    assert_eq!([a.samples(), b.samples()], [32, 32]);
    assert_same("options", &a, &b, OF_FIELDS);
    let opacity = a.opacity().into_iter().zip(b.opacity());
    assert!(opacity.clone().all(|(a, b)| (a - b).abs() < 0.15));
    assert!(opacity.into_iter().any(|(_, b)| b < 0.5));
    let pairs = a.distances().into_iter().zip(b.distances());
    let apart = pairs.filter(|(a, b)| (a - b).abs() > 0.01 * a.abs() && a != b);
    assert!(apart.count() < 8);
    Ok(())
}
