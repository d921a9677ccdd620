//! Light of images without paths, against that of stills.

use argil::prelude::*;
use argil::render::StillOptions;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const FLOOR: &str = r#"{"shape": {"type": "box", "half_size": [30, 0.5, 30]}, "material": "gray",
    "modifiers": [{"type": "translate", "by": [0, -0.5, 0]}]}"#;

/// A wide gray floor, seen from above, and what else a view and a list of brushes say.
fn scene(view: &str, brushes: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    let text = format!(
        r#"{{"argil": 1,
        "view": {{"camera": {{"look_at": {{"eye": [0, 3, 0.01], "target": [0, 0, 0]}}}}, "field_of_view_degrees": 20, {view}}},
        "materials": {{"gray": {{"base_color": [0.5, 0.5, 0.5], "roughness": 1}}}},
        "brushes": [{brushes}]}}"#
    );
    Ok(Scene::from_json(&text, "lights")?)
}

/// Returns the mean linear light of an image without paths, which is not brighter than white.
fn mean_of_image(scene: &Scene) -> Result<f64, Box<dyn std::error::Error>> {
    let world = Engine::cpu().build(scene)?.field();
    let settings = world.render_settings([24, 24], RenderMode::Shaded);
    let image = world.render(&world.camera(), &settings)?;
    let linear = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    let green = image.rgb.chunks_exact(3).map(|pixel| linear(pixel[1]));
    Ok(green.sum::<f64>() / f64::from(24 * 24))
}

fn assert_image_is_still(what: &str, view: &str, brushes: &str, tolerance: f64) -> Outcome {
    let dark = r#""environment": {"type": "color", "radiance": [0, 0, 0]}"#;
    let scene = scene(&format!(r#"{view}, {dark}, "tone": "none""#), brushes)?;
    let world = Engine::cpu().build(&scene)?.field();
    let settings = world.render_settings([24, 24], RenderMode::Shaded);
    let options = StillOptions {
        samples: 256,
        max_bounces: 1,
        ..StillOptions::default()
    };
    let still = world.still(&world.camera(), &settings, &options)?;
    let green = |all: Vec<[f32; 3]>| {
        all.into_iter()
            .map(|color| f64::from(color[1]))
            .sum::<f64>()
    };
    let count = f64::from(24 * 24);
    let traced = green(still.radiance()) / count;
    let noise = green(still.variance()).sqrt() / count;
    let drawn = mean_of_image(&scene)?;
    assert!(
        (drawn - traced).abs() < tolerance * traced + 4.0 * noise && traced > 0.01,
        "{what}: {drawn} in an image, {traced} ± {noise} in a still"
    );
    Ok(())
}

/// Lamps, shadows and fog of images without paths have the light of stills whose paths are short: a second, independent way.
#[test]
fn images_have_the_light_of_stills() -> Outcome {
    let post = r#"{"shape": {"type": "box", "half_size": [0.1, 0.2, 0.1]}, "material": "gray",
        "modifiers": [{"type": "translate", "by": [0.1, 0.2, 0]}]}"#;
    let with_post = format!("{FLOOR}, {post}");
    for (what, light) in [
        (
            "point",
            r#"{"type": "point", "at": [1, 2, 0.5], "intensity": [9, 9, 9], "radius": 0.1}"#,
        ),
        (
            "spot",
            r#"{"type": "spot", "at": [1, 2, 0.5], "target": [0, 0, 0], "intensity": [9, 9, 9], "angle_degrees": 24, "fade": 0.5, "radius": 0.05}"#,
        ),
        (
            "area",
            r#"{"type": "area", "at": [-1, 2, 0.5], "target": [0, 0, 0], "size": [0.4, 0.3], "radiance": [60, 60, 60]}"#,
        ),
        (
            "near area",
            r#"{"type": "area", "at": [-0.6, 0.9, 0.2], "target": [0, 0, 0], "size": [1.2, 0.8], "radiance": [2, 2, 2]}"#,
        ),
        (
            "sun",
            r#"{"type": "sun", "direction_degrees": [30, 50], "irradiance": [2, 2, 2], "angle_degrees": 4}"#,
        ),
        (
            "second sun",
            r#"{"type": "sun", "direction_degrees": [0, 50], "irradiance": [0, 0, 0]},
            {"type": "sun", "direction_degrees": [30, 50], "irradiance": [2, 2, 2], "angle_degrees": 4}"#,
        ),
    ] {
        let view = format!(r#""lights": [{light}]"#);
        assert_image_is_still(what, &view, &with_post, 0.05)?;
        let fog = r#""fog": {"density": 0.3, "falloff": 0.2, "height": 0.5, "anisotropy": 0.4, "albedo": [0.9, 0.8, 0.7]}"#;
        assert_image_is_still(what, &format!("{view}, {fog}"), &with_post, 0.08)?;
    }
    Ok(())
}

/// Edits of views reach images of a world that is already built.
#[test]
fn edits_of_lights_reach_images() -> Outcome {
    let mut scene = scene(r#""ground": false"#, FLOOR)?;
    let mut world = Engine::cpu().build(&scene)?.bricks(32)?;
    let settings = |world: &World| world.render_settings([8, 8], RenderMode::Shaded);
    let before = world.render(&world.camera(), &settings(&world))?.rgb;
    let mut view = scene.view.clone();
    view.lights = Some(Vec::new());
    view.environment = argil::scene::Environment::Color { radiance: [0.0; 3] };
    scene.apply(Edit::SetView {
        view: Box::new(view),
    })?;
    world.apply(&scene)?;
    let after = world.render(&world.camera(), &settings(&world))?.rgb;
    assert!(before.iter().all(|&c| c > 50) && after.iter().all(|&c| c == 0));
    Ok(())
}

/// A lamp is as bright in a wide scene as in a small one.
#[test]
fn lamps_do_not_depend_on_the_size_of_the_scene() -> Outcome {
    let light = r#""lights": [{"type": "point", "at": [0.3, 0.8, 0], "intensity": [1, 1, 1]}],
        "environment": {"type": "color", "radiance": [0, 0, 0]}, "tone": "none""#;
    let floor = |half: &str| FLOOR.replace("[30, 0.5, 30]", &format!("[{half}, 0.5, {half}]"));
    let small = mean_of_image(&scene(light, &floor("2"))?)?;
    for half in ["30", "300"] {
        let wide = mean_of_image(&scene(light, &floor(half))?)?;
        assert!(
            (wide / small - 1.0).abs() < 0.02,
            "{half}: {wide}, and {small}"
        );
    }
    Ok(())
}
