//! Tests edits that make the box of a solid larger, where distances are small far away from the surface.

use argil_conformance::{EditRig, gpu};
use argil_gpu::Gpu;
use argil_scene::{Brush, Curve, Edit, Modifier, Ramp, Scene, Shape};
use argil_volume::BrickSettings;
use std::sync::Arc;

/// A thin lens: two spheres, whose fields stay small far outside it.
fn lens() -> Scene {
    let sphere = |x: f32| Brush::new(Shape::Sphere { radius: 10.0 }).at([x, 0.0, 0.0]);
    let mut scene = Scene::new();
    scene.push(sphere(-9.95)).expect("a brush");
    scene.push(sphere(9.95).intersect()).expect("a brush");
    scene
}

/// A box that is sheared along a ramp so short that distances are divided by more than a hundred.
fn sheared() -> Scene {
    let shift = Modifier::Shift {
        by: [0.0, 0.4, 0.0],
        along: Ramp::Line {
            from: [-0.002, 0.0, 0.0],
            to: [0.002, 0.0, 0.0],
            curve: Curve::from_fn(1, |t| t * t * (3.0 - 2.0 * t)),
        },
    };
    let mut scene = Scene::new();
    scene
        .push(Brush::new(Shape::cuboid([0.6, 0.5, 0.4])).with_modifier(shift))
        .expect("a brush");
    scene
}

fn grow(device: Option<&Arc<Gpu>>, (name, mut scene): (&str, Scene)) {
    // A software device takes ten times as long.
    let steps = if device.is_some() { 2 } else { 4 };
    let settings = BrickSettings {
        brick_size_voxels: 4,
        ..BrickSettings::default()
    };
    let mut rig = EditRig::on(device.cloned(), &mut scene, 24, &settings);
    for step in 1..=steps {
        let at = [0.0, 1.2 * step as f32, 0.2 * step as f32];
        let far = Brush::new(Shape::Sphere { radius: 0.3 }).at(at);
        let index = scene.node(Scene::ROOT).children().len();
        let edit = Edit::Insert {
            parent: Scene::ROOT,
            index,
            desc: far.into(),
        };
        scene.apply(edit).expect("an edit");
        rig.follow(&mut scene);
        assert_eq!(rig.compare(&scene), (0, None), "{name}, step {step}");
    }
    assert_eq!(rig.rebakes, 0, "{name}");
}

#[test]
fn a_box_that_grows_holds_what_a_fresh_bake_holds() {
    grow(None, ("lens", lens()));
    grow(None, ("sheared", sheared()));
}

#[test]
fn a_box_that_grows_on_a_gpu_holds_what_a_fresh_bake_holds() {
    let gpu = gpu();
    grow(Some(&gpu), ("sheared", sheared()));
}
