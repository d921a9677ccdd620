//! Durations from an edit to its shaded image of 512², from bricks of 256³ of `scenes/csg20.json`: the first brush moves a
//! little, or a small sphere is cut out, its bricks follow, and what this can change is drawn again.

use argil::math::Aabb;
use argil::prelude::*;
use std::time::Instant;

/// Measures a hundred edits: from each to its image.
fn measure(
    name: &str,
    mode: RenderMode,
    mut edit: impl FnMut(&mut Scene, usize) -> Result<(), Box<dyn std::error::Error>>,
) -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/csg20.json");
    let mut scene = Scene::open(path)?;
    let mut world = Engine::cpu().build(&scene)?.bricks(256)?;
    let camera = world.camera();
    let mut settings = world.render_settings([512, 512], mode);
    settings.samples = 1;
    let mut image = LiveImage::default();
    world.redraw(&mut image, &camera, &settings, Aabb::ALL)?;
    let (mut times, mut edits, mut drawn) = (Vec::new(), Vec::new(), 0);
    for round in 0..100 {
        let start = Instant::now();
        edit(&mut scene, round)?;
        let report = world.apply(&scene)?;
        edits.push(start.elapsed().as_secs_f64() * 1e3);
        drawn += world.redraw(&mut image, &camera, &settings, report.dirty_box)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let whole = world.render(&camera, &settings)?;
    let gaps = image.rgb().iter().zip(&whole.rgb);
    let greatest = gaps.map(|(a, b)| a.abs_diff(*b)).max();
    assert!(
        greatest <= Some(1),
        "{name}: a byte differs by {greatest:?}"
    );
    let median = |all: &mut Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    println!(
        "csg20, {name}, {mode:?}: edit to image {:.2} ms, of which the edit {:.2} ms; {:.0} % of the pixels",
        median(&mut times),
        median(&mut edits),
        100.0 * drawn as f64 / (times.len() as f64 * 512.0 * 512.0)
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for mode in [RenderMode::Shaded, RenderMode::Normal] {
        measure("its first brush moves", mode, |scene, round| {
            let first = scene.iter().find(|&node| node != Scene::ROOT);
            let node = first.ok_or("no brush")?;
            let step = if round % 2 == 0 { 0.001 } else { -0.001 };
            let by = Modifier::Translate {
                by: [step, 0.0, 0.0],
            };
            scene.apply(Edit::Transform { node, by })?;
            Ok(())
        })?;
        measure("a sphere is cut out", mode, |scene, round| {
            let angle = round as f32 * 2.399_963;
            let place = [0.5 * angle.sin(), 0.5 * angle.cos(), 0.35];
            scene.push(
                Brush::new(Shape::sphere(0.05))
                    .at(place)
                    .smooth(0.01)
                    .subtract(),
            )?;
            Ok(())
        })?;
    }
    Ok(())
}
