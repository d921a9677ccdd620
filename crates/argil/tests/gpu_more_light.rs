//! Lamps, fog, bent normals and tone curves of images without paths: the GPU against the CPU.

use argil::Backend;
use argil::prelude::*;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const LAMPS: &str = r#"
    {"type": "spot", "at": [-1.2, 2, 1.2], "target": [-0.4, 0.2, 0], "intensity": [8, 5, 3], "angle_degrees": 35, "fade": 0.3, "radius": 0.05},
    {"type": "point", "at": [1.5, 0.9, 0.6], "intensity": [0.6, 0.9, 2], "radius": 0.1},
    {"type": "area", "at": [0.2, 1.8, -1.2], "target": [0, 0, 0], "size": [0.8, 0.8], "radiance": [4, 4, 3]},
    {"type": "sun", "direction_degrees": [100, 30], "irradiance": [0.5, 0.4, 0.2], "angle_degrees": 3},
    {"type": "point", "at": [-1.5, 0.4, 0.9], "intensity": [0.2, 0.6, 0.2]}"#;
const SUN: &str = r#"{"type": "sun", "direction_degrees": [20, 40], "irradiance": [2, 1.8, 1.6]}"#;
const FOG: &str = r#""fog": {"density": 0.3, "falloff": 0.4, "height": 0.2, "anisotropy": 0.4, "albedo": [0.9, 0.8, 0.7]}"#;

fn scene(view: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    let text = format!(
        r#"{{"argil": 1,
        "view": {{"camera": {{"look_at": {{"eye": [0.5, 1.6, 3.6], "target": [0, 0.4, 0]}}}}, "field_of_view_degrees": 40, {view}}},
        "materials": {{"gold": {{"base_color": [0.9, 0.7, 0.3], "metallic": 1, "roughness": 0.35}}, "red": {{"base_color": [0.7, 0.1, 0.1]}}}},
        "brushes": [
            {{"shape": {{"type": "box", "half_size": [1.5, 0.2, 1.5]}}, "modifiers": [{{"type": "translate", "by": [0, -0.2, 0]}}]}},
            {{"shape": {{"type": "sphere", "radius": 0.4}}, "material": "gold", "modifiers": [{{"type": "translate", "by": [-0.5, 0.4, 0]}}]}},
            {{"shape": {{"type": "box", "half_size": [0.25, 0.4, 0.25]}}, "material": "red", "modifiers": [{{"type": "translate", "by": [0.5, 0.4, -0.1]}}]}}]}}"#
    );
    Ok(Scene::from_json(&text, "light")?)
}

fn image(
    backend: Backend,
    scene: &Scene,
    representation: Representation,
) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let engine = Engine::with_backend(backend)?;
    let mut world = engine.build(scene)?.with_representation(representation)?;
    let settings = world.render_settings([48, 32], RenderMode::Shaded);
    world.refine(&world.camera(), &settings)?;
    Ok(world.render(&world.camera(), &settings)?.rgb)
}

/// Returns how many of a thousand bytes differ by more than 6.
fn differing(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    1000 * pairs.filter(|(a, b)| a.abs_diff(**b) > 6).count() / a.len()
}

/// Everything at once, through all representations; and each alone changes the picture.
#[test]
fn both_devices_have_the_same_light() -> Outcome {
    let field = Representation::Field;
    let whole = scene(&format!(
        r#""lights": [{SUN}, {LAMPS}], {FOG}, "ambient_occlusion": "bent_normal", "exposure": 0.5, "tone": "agx", "ground": true"#
    ))?;
    for representation in [
        field,
        Representation::Bricks(96.into()),
        Representation::Dense(64.into()),
        Representation::Levels(96.into()),
    ] {
        let [a, b] = [Backend::Cpu, Backend::Gpu].map(|on| image(on, &whole, representation));
        let apart = differing(&a?, &b?);
        assert!(apart < 5, "{}: {apart} of 1000", representation.name());
    }
    // A sun in front of the viewer, where the sky would shine, and the sky's light alone on what faces the viewer.
    let other = scene(
        r#""lights": [{"type": "sun", "direction_degrees": [190, 14], "irradiance": [2, 1.8, 1.6]}], "ambient_occlusion": "bent_normal",
        "environment": {"type": "color", "radiance": [0.1, 0.3, 0.6]}, "tone": "none", "exposure": 0.3"#,
    )?;
    let [a, b] = [Backend::Cpu, Backend::Gpu].map(|on| image(on, &other, field));
    assert!(differing(&a?, &b?) < 5);
    let plain = image(Backend::Cpu, &scene(r#""ground": false"#)?, field)?;
    for view in [
        format!(r#""lights": [{LAMPS}]"#),
        FOG.into(),
        r#""ambient_occlusion": "bent_normal""#.into(),
        r#""exposure": 1"#.into(),
        r#""tone": "none""#.into(),
        r#""tone": "agx""#.into(),
        r#""environment": {"type": "color", "radiance": [0.1, 0.3, 0.6]}"#.into(),
        format!(r#""lights": [{SUN}]"#),
    ] {
        let changed = image(Backend::Cpu, &scene(&view)?, field)?;
        assert!(differing(&plain, &changed) > 20, "{view} changes nothing");
    }
    Ok(())
}
