//! A random walk through levels of detail, with edits.

use crate::levels_common::{differing, engines, levels_on, scene};
use argil::LevelsOptions;
use argil::prelude::*;
use argil::scene::Edit;

/// On a random walk with edits of instances and brushes, what is resident is what a fresh bake has, to the bit. Set
/// ARGIL_WALK_STEPS for a longer walk than 60 steps.
#[test]
fn a_random_walk_with_edits_equals_a_fresh_bake() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(walks)
}

fn walks(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    let steps = std::env::var("ARGIL_WALK_STEPS").ok();
    let steps: u32 = steps.and_then(|steps| steps.parse().ok()).unwrap_or(60);
    let mut seed = 5u32;
    let mut random = move |low: f32, high: f32| {
        seed ^= seed << 13;
        seed ^= seed >> 17;
        seed ^= seed << 5;
        low + (high - low) * ((seed >> 8) as f32 / 16_777_216.0)
    };
    let mut scene = scene()?;
    let poses: Vec<argil::scene::Pose> = (0..50)
        .map(|_| {
            [
                random(-1.8, 1.8),
                0.0,
                random(-1.8, 1.8),
                random(0.0, 360.0),
                0.5,
            ]
            .into()
        })
        .collect();
    let row = Brush::new(Shape::sphere(0.05)).with_modifier(Modifier::Instances {
        poses: poses.into(),
    });
    scene.push(row)?;
    let options = LevelsOptions {
        memory_budget: 3 << 20,
        ..LevelsOptions::from(4096)
    };
    let mut world = levels_on(engine, &scene, options)?;
    let settings = world.render_settings([64, 36], RenderMode::Normal);
    let mut nodes = Vec::new();
    let mut eye = [0.0f32, 0.6, 0.0];
    let mut different = 0;
    for step in 0..steps {
        for (axis, limit) in [(0, 1.8f32), (2, 1.8)] {
            eye[axis] = (eye[axis] + random(-0.3, 0.3)).clamp(-limit, limit);
        }
        let near = [
            eye[0] + random(-0.3, 0.3),
            random(0.0, 0.3),
            eye[2] + random(-0.3, 0.3),
        ];
        match step % 3 {
            0 => {
                let brush = Brush::new(Shape::sphere(random(0.02, 0.1)));
                let brush = if random(0.0, 1.0) < 0.5 {
                    brush.subtract()
                } else {
                    brush
                };
                nodes.push(scene.push(brush.smooth(random(0.0, 0.03)).at(near))?.node);
            }
            1 if nodes.len() > 8 => {
                scene.apply(Edit::Remove {
                    node: nodes.remove(0),
                })?;
            }
            _ => {}
        }
        world.apply(&scene)?;
        let camera = Camera {
            eye: eye.into(),
            target: [near[0], 0.0, near[2] + 0.2].into(),
            field_of_view_degrees: 60.0,
        };
        world.render(&camera, &settings)?;
        world.fill_pages(f64::INFINITY).expect("filled");
        if step % 10 == 9 {
            different += differing(&world);
        }
    }
    assert_eq!(different + differing(&world), 0);
    Ok(())
}

/// Edits that change no distance leave levels as they are, and what rays ask for afterwards is right: views, strokes,
/// names, and replacements by the same.
#[test]
fn edits_that_change_no_distance_are_followed() -> Result<(), Box<dyn std::error::Error>> {
    engines().iter().try_for_each(changes_nothing)
}

fn changes_nothing(engine: &Engine) -> Result<(), Box<dyn std::error::Error>> {
    type Change = fn(&mut Scene) -> Result<(), Box<dyn std::error::Error>>;
    let nothing: [(&str, Change); 6] = [
        ("view", |scene| {
            let mut view = scene.view.clone();
            view.field_of_view_degrees += 1.0;
            scene.apply(Edit::SetView { view: view.into() })?;
            Ok(())
        }),
        ("stroke", |scene| {
            scene.begin_stroke();
            scene.end_stroke();
            Ok(())
        }),
        ("same", |scene| {
            let node = scene.node(Scene::ROOT).children()[1];
            let desc = scene.node(node).desc().clone();
            scene.apply(Edit::Replace { node, desc })?;
            Ok(())
        }),
        ("away and back", |scene| {
            let node = scene.node(Scene::ROOT).children()[1];
            scene.apply(Edit::Remove { node })?;
            scene.undo();
            Ok(())
        }),
        ("nothing", |_| Ok(())),
        ("an empty group", |scene| {
            scene.push(Group::new())?;
            Ok(())
        }),
    ];
    for (name, change) in nothing {
        let mut scene = Scene::new();
        scene.push(Shape::sphere(0.2))?;
        let tall = Shape::cylinder(0.4, 0.45);
        let entry = Brush::new(tall).with_modifier(Modifier::Scale { by: 0.79 });
        scene.push(entry.clone())?;
        let options = LevelsOptions::from(4096);
        let mut world = levels_on(engine, &scene, options)?;
        let settings = world.render_settings([64, 40], RenderMode::Normal);
        let mut camera = world.camera();
        // The world is built anew for some edits, and follows others from then on.
        let node = scene.node(Scene::ROOT).children()[1];
        let row = Modifier::Repeat {
            spacing: [1.5, 0.0, 0.0],
            count: Some([3, 1, 1]),
        };
        scene.apply(Edit::Replace {
            node,
            desc: entry.with_modifier(row).into(),
        })?;
        world.apply(&scene)?;
        world.refine(&camera, &settings)?;
        change(&mut scene)?;
        world.apply(&scene)?;
        for height in [0.0, 1.0, 2.0] {
            camera.eye.y += height;
            world.refine(&camera, &settings)?;
            assert_eq!(differing(&world), 0, "{name}, {height} higher");
        }
    }
    Ok(())
}
