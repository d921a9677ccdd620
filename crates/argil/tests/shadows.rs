//! Shadows of the sun, against dense samples along its rays.

use argil::prelude::*;
use argil::scene::{Edit, Environment, ToneCurve};
use glam::Vec3;

type Outcome = Result<(), Box<dyn std::error::Error>>;

const SIZE: [u32; 2] = [240, 150];

/// Returns the direction at an azimuth and an elevation.
fn toward([azimuth, elevation]: [f32; 2]) -> Vec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let across = elevation.cos();
    Vec3::new(
        across * azimuth.sin(),
        elevation.sin(),
        across * azimuth.cos(),
    )
}

/// Returns the pixels whose surfaces face the sun, and whose rays to it go through more than 0.04 of the solid.
fn shadowed(world: &World) -> Result<Vec<usize>, Box<dyn std::error::Error>> {
    let camera = world.camera();
    let settings = world.render_settings(SIZE, RenderMode::Normal);
    let lengths = world.ray_distances(&camera, &settings)?;
    let forward = (camera.target - camera.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = (0.5 * camera.field_of_view_degrees).to_radians().tan();
    let sun = toward(world.scene().view.sun_degrees);
    let distance = |p: Vec3| world.distance(p.to_array());
    let is_shadowed = |&i: &usize| {
        let [width, height] = SIZE.map(|side| side as f32);
        let [x, y] = [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|at| at as f32 + 0.5);
        let across = (2.0 * x - width) / height * half;
        let toward = forward + across * right + (1.0 - 2.0 * y / height) * half * up;
        let p = camera.eye + lengths[i] * toward.normalize();
        let step = |axis: Vec3| distance(p + 1e-3 * axis) - distance(p - 1e-3 * axis);
        let normal = Vec3::new(step(Vec3::X), step(Vec3::Y), step(Vec3::Z)).normalize_or_zero();
        let from = p + 0.01 * normal;
        let mut along = (0..750).map(|index| from + sun * (0.004 * index as f32));
        normal.dot(sun) > 0.15 && along.any(|p| distance(p) < -0.02)
    };
    let pixels = (0..lengths.len()).step_by(7);
    let hits = pixels.filter(|&i| lengths[i].is_finite());
    Ok(hits.filter(is_shadowed).collect())
}

/// Returns the pixels that are brighter than black, where nothing but the sun and emitters shine.
fn bright(world: &World) -> Result<Vec<bool>, argil::RenderError> {
    let settings = RenderSettings {
        samples: 1,
        ..world.render_settings(SIZE, RenderMode::Shaded)
    };
    let image = world.render(&world.camera(), &settings)?;
    let green = image.rgb.iter().skip(1).step_by(3);
    Ok(green.map(|&green| green > 20).collect())
}

/// Rays to the sun along rough rock take short steps. They must not end as lit before they come to what hides the sun.
#[test]
fn long_shadows_are_dark() -> Outcome {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let mut scene = Scene::open(format!("{folder}/temple.json"))?;
    let mut view = Box::new(scene.view.clone());
    view.environment = Environment::Color { radiance: [0.0; 3] };
    view.tone = ToneCurve::None;
    scene.apply(Edit::SetView { view: view.clone() })?;
    let field = Engine::cpu().build(&scene)?.field();
    let bricks = Engine::cpu().build(&scene)?.bricks(256)?;
    let mut shadowed = shadowed(&field)?;
    // With the sun below, what is bright there is an emitter.
    view.sun_degrees[1] = -80.0;
    scene.apply(Edit::SetView { view })?;
    let emits = bright(&Engine::cpu().build(&scene)?.field())?;
    shadowed.retain(|&i| !emits[i]);
    assert!(shadowed.len() > 30, "{}", shadowed.len());
    for world in [&field, &bricks] {
        let bright = bright(world)?;
        let count = shadowed.iter().filter(|&&i| bright[i]).count();
        let (via, all) = (world.representation().name(), shadowed.len());
        assert!(count * 8 < all, "{via}: {count} of {all}");
    }
    Ok(())
}
