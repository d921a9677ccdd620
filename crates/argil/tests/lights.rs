//! Lights, fog, glass and lenses of stills, against formulas and against other ways to make the same light.

use argil::prelude::*;
use argil::render::{Still, StillOptions};
use argil::scene::{Environment, SceneImage};
use std::sync::Arc;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A wide gray floor, seen from above, and what else a view and a list of brushes say.
fn scene(view: &str, materials: &str, brushes: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    let text = format!(
        r#"{{"argil": 1,
        "view": {{"camera": {{"look_at": {{"eye": [0, 3, 0.01], "target": [0, 0, 0]}}}}, "field_of_view_degrees": 20, {view}}},
        "materials": {{"gray": {{"base_color": [0.5, 0.5, 0.5], "roughness": 1}} {materials}}},
        "brushes": [{brushes}]}}"#
    );
    Ok(Scene::from_json(&text, "lights")?)
}

const FLOOR: &str = r#"{"shape": {"type": "box", "half_size": [30, 0.5, 30]}, "material": "gray",
    "modifiers": [{"type": "translate", "by": [0, -0.5, 0]}]}"#;
const BLACK: &str = r#""environment": {"type": "color", "radiance": [0, 0, 0]}"#;

fn still(scene: &Scene, samples: u32) -> Result<Still, Box<dyn std::error::Error>> {
    let world = Engine::cpu().build(scene)?.field();
    let settings = world.render_settings([24, 24], RenderMode::Shaded);
    let options = StillOptions {
        samples,
        max_bounces: 64,
        ..StillOptions::default()
    };
    Ok(world.still(&world.camera(), &settings, &options)?)
}

/// Returns the mean light of a picture, and how far that is off by noise.
fn mean(still: &Still) -> (f64, f64) {
    let green = |all: Vec<[f32; 3]>| all.into_iter().map(|color| f64::from(color[1]));
    let count = f64::from(24 * 24);
    let light = green(still.radiance()).sum::<f64>() / count;
    (light, green(still.variance()).sum::<f64>().sqrt() / count)
}

fn assert_same(what: &str, a: &Still, b: &Still, tolerance: f64) {
    let ((a, a_off), (b, b_off)) = (mean(a), mean(b));
    let most = tolerance * a.max(b) + 4.0 * (a_off * a_off + b_off * b_off).sqrt();
    assert!(
        a > 0.0 && (a - b).abs() < most,
        "{what}: {a} and {b}, ± {most}"
    );
    assert!(
        most < 0.1 * a,
        "{what}: too much noise to tell: {a} ± {most}"
    );
}

/// A small sphere, a point, a far sun and a far rectangle bring the same light, and twice as far away a quarter.
#[test]
fn lights_of_a_kind_agree() -> Outcome {
    let lit = |light: &str| {
        let view = format!(r#""lights": [{light}], {BLACK}"#);
        still(&scene(&view, "", FLOOR)?, 32)
    };
    let point = lit(r#"{"type": "point", "at": [0, 20, 0], "intensity": [400, 400, 400]}"#)?;
    for (what, light) in [
        (
            "sphere",
            r#"{"type": "point", "at": [0, 20, 0], "intensity": [400, 400, 400], "radius": 0.5}"#,
        ),
        (
            "spot",
            r#"{"type": "spot", "at": [0, 20, 0], "target": [0, 0, 0], "intensity": [400, 400, 400]}"#,
        ),
        (
            "wide spot",
            r#"{"type": "spot", "at": [0, 20, 0], "target": [0, 0, 0], "intensity": [400, 400, 400], "angle_degrees": 20, "radius": 0.5}"#,
        ),
        (
            "sun",
            r#"{"type": "sun", "direction_degrees": [0, 90], "irradiance": [1, 1, 1]}"#,
        ),
        (
            "area",
            r#"{"type": "area", "at": [0, 20, 0], "target": [0, 0, 0], "size": [2, 1], "radiance": [200, 200, 200]}"#,
        ),
    ] {
        assert_same(what, &point, &lit(light)?, 0.01);
    }
    let far = lit(r#"{"type": "point", "at": [0, 40, 0], "intensity": [400, 400, 400]}"#)?;
    let ratio = mean(&point).0 / mean(&far).0;
    assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
    Ok(())
}

/// A surface that emits light is found by chance, a rectangle by looking for it: both bring the same light, above all kinds of
/// surfaces, and many lights bring their sum.
#[test]
fn looking_for_lights_changes_nothing_but_noise() -> Outcome {
    let panel = r#"{"shape": {"type": "box", "half_size": [1, 0.01, 1]}, "material": "lamp",
        "modifiers": [{"type": "translate", "by": [1.5, 2.01, 0]}]}"#;
    let area = r#"{"type": "area", "at": [1.5, 2, 0], "target": [1.5, 0, 0], "size": [2, 2], "radiance": [3, 3, 3]}"#;
    for floor in [
        r#"{"roughness": 1}"#,
        r#"{"roughness": 0.3, "metallic": 1}"#,
        r#"{"roughness": 0.1, "base_color": [0.1, 0.1, 0.1]}"#,
    ] {
        let materials = format!(
            r#", "lamp": {{"emission": [3, 3, 3], "base_color": [0, 0, 0]}}, "own": {floor}"#
        );
        let ground = FLOOR.replace("gray", "own");
        let none = format!(r#""lights": [], {BLACK}"#);
        let by_chance = still(
            &scene(&none, &materials, &format!("{ground}, {panel}"))?,
            512,
        )?;
        let view = format!(r#""lights": [{area}], {BLACK}"#);
        let looked_for = still(&scene(&view, &materials, &ground)?, 128)?;
        assert_same(floor, &by_chance, &looked_for, 0.02);
    }
    // A hundred lights of which each brings a hundredth.
    let small = r#"{"type": "area", "at": [1.5, 2, 0], "target": [1.5, 0, 0], "size": [2, 2], "radiance": [0.03, 0.03, 0.03]}"#;
    let all = vec![small; 100].join(",");
    let of = |lights: &str| {
        still(
            &scene(&format!(r#""lights": [{lights}], {BLACK}"#), "", FLOOR)?,
            64,
        )
    };
    assert_same("sum", &of(area)?, &of(&all)?, 0.01);
    Ok(())
}

/// An image of one color is that color, and a bright spot in it is a sun.
#[test]
fn images_around_a_scene_shine() -> Outcome {
    let with_image = |image: SceneImage| -> Result<Still, Box<dyn std::error::Error>> {
        let view = r#""lights": [], "environment": {"type": "image", "path": "a.hdr"}"#;
        let mut scene = scene(view, "", FLOOR)?;
        assert_eq!(scene.missing_images(), ["a.hdr"]);
        scene.set_image("a.hdr", &Arc::new(image));
        still(&scene, 128)
    };
    let even = |radiance: [f32; 3]| SceneImage {
        size: [32, 16],
        pixels: vec![radiance; 512],
    };
    let mut plain = scene(r#""lights": []"#, "", FLOOR)?;
    plain.view.environment = Environment::Color {
        radiance: [0.8, 0.7, 0.6],
    };
    assert_same(
        "even",
        &still(&plain, 128)?,
        &with_image(even([0.8, 0.7, 0.6]))?,
        0.01,
    );

    // A spot at 45° toward +z.
    let (width, height) = (256, 128);
    let mut image = SceneImage {
        size: [width, height],
        pixels: vec![[0.0; 3]; (width * height) as usize],
    };
    // Azimuth 0 is in the middle, and elevation 45° a quarter from the top.
    let (x, y) = (width / 2, height / 4);
    image.pixels[(y * width + x) as usize] = [1000.0; 3];
    let angle = std::f32::consts::TAU / width as f32;
    let elevation = 90.0 - (y as f32 + 0.5) / height as f32 * 180.0;
    let irradiance = 1000.0 * angle * angle * elevation.to_radians().cos();
    let azimuth = (x as f32 + 0.5) / width as f32 * 360.0 - 180.0;
    let sun = format!(
        r#""lights": [{{"type": "sun", "direction_degrees": [{azimuth}, {elevation}], "irradiance": [{irradiance}, {irradiance}, {irradiance}]}}], {BLACK}"#
    );
    // In fog, too, where light is scattered forward.
    let fog = argil::scene::Fog {
        density: 0.4,
        anisotropy: 0.5,
        ..argil::scene::Fog::default()
    };
    let foggy = |mut scene: Scene| {
        scene.view.fog = Some(fog);
        still(&scene, 128)
    };
    let mut around = scene(
        r#""lights": [], "environment": {"type": "image", "path": "a.hdr"}"#,
        "",
        FLOOR,
    )?;
    around.set_image("a.hdr", &Arc::new(even([0.8, 0.7, 0.6])));
    assert_same("fog", &foggy(plain)?, &foggy(around)?, 0.01);
    assert_same(
        "spot",
        &with_image(image)?,
        &still(&scene(&sun, "", FLOOR)?, 64)?,
        0.02,
    );
    Ok(())
}

/// Fog takes light by its depth; fog that only scatters hides in a furnace, and so does clear glass.
#[test]
fn fog_and_glass_keep_light_together() -> Outcome {
    let lamp = r#", "lamp": {"emission": [1, 1, 1], "base_color": [0, 0, 0], "roughness": 1}"#;
    let panel = FLOOR.replace("gray", "lamp");
    for (fog, depth) in [
        (
            r#"{"density": 0.3, "falloff": 0, "albedo": [0, 0, 0]}"#,
            0.9,
        ),
        // ∫ e^(−y) from 0 to 3.
        (
            r#"{"density": 1, "falloff": 1, "albedo": [0, 0, 0]}"#,
            1.0 - (-3f64).exp(),
        ),
    ] {
        let view = format!(r#""lights": [], {BLACK}, "fog": {fog}"#);
        let (light, off) = mean(&still(&scene(&view, lamp, &panel)?, 256)?);
        let expected = (-depth).exp();
        // Rays at the image's side are 3 % longer.
        assert!(
            (light - expected).abs() < 0.015 * expected + 4.0 * off,
            "{fog}: {light}, expected {expected}"
        );
    }
    let furnace = r#""lights": [], "environment": {"type": "color", "radiance": [1, 1, 1]}"#;
    let sphere = |material: &str| {
        format!(r#"{{"shape": {{"type": "sphere", "radius": 0.4}}, "material": "{material}"}}"#)
    };
    let materials = r#", "white": {"base_color": [1, 1, 1], "roughness": 0.5},
        "glass": {"base_color": [1, 1, 1], "roughness": 0, "transmission": 1},
        "dark": {"base_color": [0.2, 0.2, 0.2], "roughness": 0, "transmission": 1, "attenuation_distance": 1}"#;
    let fog =
        r#", "fog": {"density": 0.5, "falloff": 0.7, "albedo": [1, 1, 1], "anisotropy": 0.6}"#;
    for (what, view, brushes) in [
        (
            "fog",
            format!("{furnace}{fog}"),
            FLOOR.replace("gray", "white"),
        ),
        ("glass", furnace.to_owned(), sphere("glass")),
    ] {
        let (light, off) = mean(&still(&scene(&view, materials, &brushes)?, 256)?);
        assert!(
            (light - 1.0).abs() < 0.005 + 3.0 * off,
            "{what}: {light} ± {off}"
        );
    }
    let (light, _) = mean(&still(&scene(furnace, materials, &sphere("dark"))?, 64)?);
    assert!(light < 0.95, "{light}");
    Ok(())
}

/// A lens spreads what is out of focus, and a transparent picture has no background.
#[test]
fn lenses_blur_and_backgrounds_are_left_out() -> Outcome {
    let lamp = r#", "lamp": {"emission": [1, 1, 1], "base_color": [0, 0, 0], "roughness": 1}"#;
    let sphere = r#"{"shape": {"type": "sphere", "radius": 0.1}, "material": "lamp"}"#;
    let lit = |lens: &str| -> Result<usize, Box<dyn std::error::Error>> {
        let view = format!(r#""lights": [], {BLACK} {lens}"#);
        let light = still(&scene(&view, lamp, sphere)?, 64)?.radiance();
        Ok(light.iter().filter(|color| color[1] > 0.02).count())
    };
    let sharp = lit("")?;
    let in_focus = lit(r#", "lens": {"aperture_radius": 0.3}"#)?;
    let near = lit(r#", "lens": {"aperture_radius": 0.3, "focus_distance": 1.5}"#)?;
    assert!(
        in_focus.abs_diff(sharp) < 12 && near > 2 * sharp,
        "{sharp} {in_focus} {near}"
    );

    let world = Engine::cpu()
        .build(&scene(r#""lights": []"#, lamp, sphere)?)?
        .field();
    let settings = world.render_settings([24, 24], RenderMode::Shaded);
    let options = StillOptions {
        samples: 4,
        is_transparent: true,
        ..StillOptions::default()
    };
    let still = world.still(&world.camera(), &settings, &options)?;
    let (opacity, light) = (still.opacity(), still.radiance());
    assert!(opacity[0] == 0.0 && light[0] == [0.0; 3]);
    assert!(opacity[12 * 24 + 12] == 1.0 && light[12 * 24 + 12][1] > 0.9);
    Ok(())
}

/// Textures move and turn with their brushes, or stay in the scene; they blend where brushes do; heights turn normals.
#[test]
fn textures_move_with_their_brushes() -> Outcome {
    let material = |space: &str| {
        format!(
            r#", "own": {{"textures": {{"base_color": {{"pattern": {{"type": "noise"}}, "size": 0.3, "space": "{space}"}}}}}}"#
        )
    };
    let at = |space: &str,
              modifiers: &str,
              point: [f32; 3]|
     -> Result<f32, Box<dyn std::error::Error>> {
        let brush = format!(
            r#"{{"shape": {{"type": "box", "half_size": [0.5, 0.4, 0.3]}}, "material": "own", "modifiers": [{modifiers}]}}"#
        );
        let scene = scene(BLACK, &material(space), &brush)?;
        let world = Engine::cpu().build(&scene)?.field();
        Ok(world.query().material(point).base_color[0])
    };
    let moved = r#"{"type": "rotate", "axis": [0, 1, 0], "degrees": 90}, {"type": "translate", "by": [2, 1, 0]}"#;
    for index in 0..8 {
        let y = 0.1 * index as f32 - 0.35;
        let before = [0.5, y, 0.2];
        // A quarter turn about y takes x to −z and z to x.
        let after = [2.2, 1.0 + y, -0.5];
        let color = at("brush", "", before)?;
        assert!((color - at("brush", moved, after)?).abs() < 1e-3, "{index}");
        assert!((at("world", moved, after)? - at("world", "", after)?).abs() < 0.5);
        let apart = (color - at("brush", "", [0.5, y, 0.05])?).abs();
        assert!(apart > 1e-4, "{index}: the pattern is flat");
    }
    // In the scene, the same point has the same color wherever the brush is.
    let shifted = r#"{"type": "translate", "by": [0.1, 0, 0]}"#;
    let point = [0.2, 0.4, 0.1];
    assert!((at("world", "", point)? - at("world", shifted, point)?).abs() < 1e-4);
    assert!((at("brush", "", point)? - at("brush", shifted, point)?).abs() > 1e-3);

    let bumpy = r#", "bumpy": {"base_color": [0.5, 0.5, 0.5], "roughness": 1, "textures": {"bump": {"pattern": {"type": "stripes"}, "size": 0.4, "high": 0.2}}}"#;
    let view = format!(
        r#""lights": [{{"type": "sun", "direction_degrees": [0, 30], "irradiance": [3, 3, 3]}}], {BLACK}"#
    );
    let spread = |floor: &str| -> Result<f32, Box<dyn std::error::Error>> {
        let light = still(&scene(&view, bumpy, floor)?, 16)?.radiance();
        let all = || light.iter().map(|radiance| radiance[1]);
        Ok(all().fold(0.0, f32::max) - all().fold(f32::MAX, f32::min))
    };
    let (flat, rough) = (spread(FLOOR)?, spread(&FLOOR.replace("gray", "bumpy"))?);
    assert!(rough > 5.0 * flat, "{flat} {rough}");
    Ok(())
}

/// Images stand upright on all sides of a box, and are not mirrored. Their middle is the brush's.
#[test]
fn images_are_upright_and_not_mirrored() -> Outcome {
    let material =
        r#", "own": {"textures": {"base_color": {"pattern": {"type": "image", "path": "a.png"}}}}"#;
    let brush = r#"{"shape": {"type": "box", "half_size": [0.5, 0.5, 0.5]}, "material": "own"}"#;
    let mut scene = scene(BLACK, material, brush)?;
    // Red, green; blue, white.
    let pixels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
    let image = SceneImage {
        size: [2, 2],
        pixels: pixels.clone(),
    };
    scene.set_image("a.png", &Arc::new(image));
    let world = Engine::cpu().build(&scene)?.field();
    // Outward, and to the right as seen from outside.
    for (out, right, up) in [
        ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
        ([-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        ([0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ] {
        for (index, (x, y)) in [(-0.25, 0.25), (0.25, 0.25), (-0.25, -0.25), (0.25, -0.25)]
            .into_iter()
            .enumerate()
        {
            let point = [0, 1, 2].map(|k| 0.5 * out[k] + x * right[k] + y * up[k]);
            let found = world.query().material(point).base_color;
            let expected: [f32; 3] = pixels[index];
            let apart = (0..3)
                .map(|k| (found[k] - expected[k]).abs())
                .fold(0.0, f32::max);
            assert!(
                apart < 0.02,
                "{out:?} {index}: {found:?}, expected {expected:?}"
            );
        }
    }
    Ok(())
}

/// Levels hold only what an image needed: paths are refused.
#[test]
fn levels_are_refused() -> Outcome {
    let scene = scene("\"ground\": false", "", FLOOR)?;
    let built = Engine::cpu().build(&scene)?;
    let world = built.with_representation(argil::LevelsOptions::default())?;
    let settings = world.render_settings([8, 8], RenderMode::Shaded);
    let refused = world.still(&world.camera(), &settings, &StillOptions::default());
    assert!(refused.is_err_and(|error| error.to_string().contains("levels")));
    Ok(())
}
