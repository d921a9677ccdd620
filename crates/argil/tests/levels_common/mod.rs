//! What tests of levels share.

use argil::prelude::*;
use argil::volume::Volume;
use argil::{LevelsOptions, World};

pub(crate) fn scene() -> Result<Scene, Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Brush::new(Shape::cuboid([2.0, 0.1, 2.0])).at([0.0, -0.1, 0.0]))?;
    for i in 0..40u16 {
        let along = |k: u16| f32::from(i * k % 41) / 41.0 * 3.6 - 1.8;
        let shape = match i % 3 {
            0 => Shape::sphere(0.12),
            1 => Shape::cuboid([0.1, 0.15, 0.05]),
            _ => Shape::torus(0.1, 0.03),
        };
        scene.push(
            Brush::new(shape)
                .smooth(0.02)
                .at([along(7), 0.08, along(13)]),
        )?;
    }
    Ok(scene)
}

pub(crate) fn levels_of(
    scene: &Scene,
    options: LevelsOptions,
) -> Result<World, Box<dyn std::error::Error>> {
    levels_on(&Engine::cpu(), scene, options)
}

pub(crate) fn levels_on(
    engine: &Engine,
    scene: &Scene,
    options: LevelsOptions,
) -> Result<World, Box<dyn std::error::Error>> {
    Ok(engine.build(scene)?.with_representation(options)?)
}

pub(crate) fn engines() -> [Engine; 2] {
    [
        Engine::cpu(),
        Engine::with_backend(Backend::Gpu).expect("a GPU"),
    ]
}

/// Counts cells that differ from a fresh bake. A device must have what the CPU has, to the bit.
pub(crate) fn differing(world: &World) -> u64 {
    let levels = world.levels().expect("levels");
    let there = world.volume().expect("a download");
    let Some(Volume::Levels(there)) = there.as_deref() else {
        return u64::MAX;
    };
    assert!(there == levels, "the device has other pages");
    levels.differing_cells(world.program())
}
