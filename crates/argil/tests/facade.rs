//! The facade as the README uses it.

use argil::{Backend, Brush, Engine, Scene, Shape};

const TEAPOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/teapot.json");

#[test]
fn the_readmes_example() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let mut scene = Scene::open(TEAPOT)?;
    scene.push(
        Brush::new(Shape::sphere(0.4))
            .at([0.3, 0.9, 0.9])
            .subtract()
            .blend(0.1),
    )?;
    let world = Engine::auto()?.build(&scene)?;
    assert!(world.distance([0.0, 2.0, 0.0]) > 0.0);
    world
        .render(&world.camera(), [64, 36])?
        .save(folder.path().join("teapot.png"))?;
    assert!(scene.undo());
    Ok(())
}

/// An edit reaches the picture on both devices, and both agree on it.
#[test]
fn worlds_follow_their_scene() -> Result<(), Box<dyn std::error::Error>> {
    let mut hits = Vec::new();
    for backend in [Backend::Cpu, Backend::Gpu] {
        let mut scene = Scene::new();
        scene.push(Brush::new(Shape::sphere(0.5)))?;
        let mut world = Engine::on(backend)?.build(&scene)?;
        let camera = world.camera();
        let settings = world.settings([48, 48], argil::Show::Normal);
        let before = world.draw(&camera, &settings)?.hit_pixels;
        scene.push(Brush::new(Shape::cuboid([0.1, 0.9, 0.1])).blend(0.05))?;
        world.apply(&scene)?;
        let after = world.draw(&camera, &settings)?.hit_pixels;
        assert!(after > before + 20, "{before} {after}");
        hits.push((before, after));
    }
    assert_eq!(hits[0], hits[1]);
    Ok(())
}
