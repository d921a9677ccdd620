//! An image that follows edits is the image that a whole one would be.

use argil::math::Aabb;
use argil::prelude::*;
use argil::volume::Band;

/// The greatest difference of two images, and how many pixels differ by more than one step.
fn difference(a: &[u8], b: &[u8]) -> (u8, usize) {
    assert_eq!(a.len(), b.len());
    let gaps = || a.iter().zip(b).map(|(a, b)| a.abs_diff(*b));
    let far = a.chunks(3).zip(b.chunks(3));
    let far = far.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1));
    (gaps().max().unwrap_or(0), far.count())
}

/// Spheres appear one after the other. What is drawn again and what stays make the image of a fresh drawing, and less is
/// drawn than the whole.
#[test]
fn what_stays_is_what_a_whole_image_shows() {
    for (mode, ground) in [(RenderMode::Shaded, true), (RenderMode::Normal, false)] {
        let mut scene = Scene::new();
        scene.push(Shape::cuboid([1.0, 0.6, 1.0])).expect("a brush");
        scene
            .push(
                Brush::new(Shape::sphere(0.5))
                    .at([0.4, 0.1, 0.2])
                    .smooth(0.1),
            )
            .expect("a brush");
        let engine = Engine::cpu();
        let mut world = engine
            .build(&scene)
            .expect("a scene")
            .bricks(128)
            .expect("bricks");
        let camera = world.camera();
        let mut settings = world.render_settings([320, 200], mode);
        settings.ground = ground;
        let mut image = LiveImage::default();
        let all = world
            .redraw(&mut image, &camera, &settings, Aabb::ALL)
            .expect("an image");
        assert_eq!(all, 320 * 200);
        let mut drawn = 0;
        for step in 0..12 {
            let angle = step as f32 * 2.1;
            // The last ones make the solid larger.
            let far = if step < 9 { 0.6 } else { 1.0 };
            let place = [far * angle.sin(), 0.28, far * angle.cos()];
            let brush = Brush::new(Shape::sphere(0.08)).at(place);
            scene
                .push(if step % 3 == 0 {
                    brush.subtract()
                } else {
                    brush
                })
                .expect("a brush");
            let report = world.apply(&scene).expect("an edit");
            drawn += world
                .redraw(&mut image, &camera, &settings, report.dirty_box)
                .expect("an image");
            let whole = world.render(&camera, &settings).expect("an image");
            let (greatest, far) = difference(image.rgb(), &whole.rgb);
            assert!(
                far == 0,
                "{mode:?}, step {step}: {far} pixels differ, by up to {greatest}"
            );
        }
        assert!(drawn < 12 * all / 2, "{mode:?}: {drawn} of {}", 12 * all);
    }
}

/// A sphere far above a slab throws its shadow far from where the edit is seen, and one close to a wall closes places
/// beside it, also where the sun does not reach. Both follow.
#[test]
fn shadows_and_occlusion_far_from_an_edit_follow() {
    for sun_degrees in [[90.0, 40.0], [270.0, 40.0]] {
        let mut scene = Scene::new();
        scene
            .push(Brush::new(Shape::cuboid([2.0, 0.05, 2.0])))
            .expect("a brush");
        scene
            .push(Brush::new(Shape::cuboid([0.05, 1.5, 1.0])).at([-1.5, 1.4, 0.0]))
            .expect("a brush");
        let mut options = BricksOptions::from(200);
        options.settings.encoding.band = Band::Voxels(4.0);
        let world = Engine::cpu().build(&scene).expect("a scene");
        let mut world = world.bricks(options).expect("bricks");
        let camera = world.camera_at(CameraPose::LookAt {
            eye: [3.0, 3.0, 4.0],
            target: [-0.5, 0.8, 0.0],
        });
        let mut settings = world.render_settings([320, 200], RenderMode::Shaded);
        settings.sun_degrees = sun_degrees;
        let mut image = LiveImage::default();
        let mut redraw = |world: &World, dirty| {
            let pixels = world.redraw(&mut image, &camera, &settings, dirty);
            let whole = world.render(&camera, &settings).expect("an image");
            let (greatest, far) = difference(image.rgb(), &whole.rgb);
            assert!(far == 0, "{far} pixels differ, by up to {greatest}");
            pixels.expect("an image")
        };
        redraw(&world, Aabb::ALL);
        for place in [[1.2, 1.6, 0.3], [-1.2, 1.2, 0.2], [0.8, 1.8, -0.6]] {
            scene
                .push(Brush::new(Shape::sphere(0.2)).at(place))
                .expect("a brush");
            let report = world.apply(&scene).expect("an edit");
            assert!(redraw(&world, report.dirty_box) < 320 * 200 * 9 / 10);
        }
    }
}

/// Another view and another size are drawn whole.
#[test]
fn another_view_is_drawn_whole() {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0)).expect("a brush");
    let world = Engine::cpu()
        .build(&scene)
        .expect("a scene")
        .bricks(64)
        .expect("bricks");
    let (mut image, mut camera) = (LiveImage::default(), world.camera());
    let settings = world.render_settings([64, 48], RenderMode::Shaded);
    let mut draw = |world: &World, camera: &Camera, settings: &RenderSettings| {
        world
            .redraw(&mut image, camera, settings, Aabb::EMPTY)
            .expect("an image")
    };
    assert_eq!(draw(&world, &camera, &settings), 64 * 48);
    assert_eq!(draw(&world, &camera, &settings), 0);
    camera = camera.orbited(10.0);
    assert_eq!(draw(&world, &camera, &settings), 64 * 48);
    let wide = world.render_settings([80, 48], RenderMode::Shaded);
    assert_eq!(draw(&world, &camera, &wide), 80 * 48);
}
