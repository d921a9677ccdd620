//! Futures can move to any thread, and give the same results as the blocking calls.

use argil::render::RenderMode;
use argil::scene::{Brush, Edit, Scene, Shape};
use argil::{EditBudget, Engine, MeshOptions, Representation};

fn scene() -> Scene {
    let mut scene = Scene::new();
    let ball = Brush::new(Shape::sphere(0.5));
    scene.push(ball).expect("a brush");
    scene
}

/// Checks at compile time that a multi-threaded executor can send a future.
fn sent<T: Send>(future: impl Future<Output = T> + Send) -> T {
    std::thread::scope(|scope| {
        let thread = scope.spawn(|| pollster::block_on(future));
        thread.join().expect("no panic")
    })
}

#[test]
fn futures_can_be_sent_to_other_threads() -> Result<(), Box<dyn std::error::Error>> {
    for engine in [
        Engine::cpu(),
        sent(Engine::with_backend_async(argil::Backend::Gpu))?,
    ] {
        let mut scene = scene();
        let mut world = sent(
            engine
                .build(&scene)?
                .with_representation_async(Representation::Bricks(32.into())),
        )?;
        let node = scene
            .push(Brush::new(Shape::sphere(0.3)).at([0.5, 0.0, 0.0]))?
            .node;
        let eye = [2.0, 0.0, 0.0];
        let pace = EditBudget {
            max_ms: 1.0,
            priority_point: eye,
        };
        sent(world.apply_within_async(&scene, pace))?;
        sent(world.flush_async())?;
        scene.apply(Edit::Remove { node })?;
        sent(world.apply_async(&scene))?;
        sent(world.flush_async())?;
        sent(world.shrink_to_fit_async())?;
        assert_eq!(sent(world.diff_from_rebuild_async())?, Some(0));
        let settings = world.render_settings([32, 24], RenderMode::Normal);
        let drawn = sent(world.render_async(&world.camera(), &settings))?;
        assert_eq!(drawn.rgb, world.render(&world.camera(), &settings)?.rgb);
        let info = sent(world.volume_info_async())?;
        assert!(info.is_some() && sent(world.volume_async())?.is_some());
        let meshed = sent(world.mesh_async(&MeshOptions::default()))?;
        assert!(meshed.report.is_watertight());
        let mut bytes = Vec::new();
        sent(world.write_async(&mut bytes))?;
        let mut again = Vec::new();
        world.write(&mut again)?;
        assert!(bytes == again && bytes.len() > 1000);
        let world = sent(world.rebuilt_as_async(&scene, Representation::Field))?;
        assert_eq!(world.distance([0.0; 3]), -0.5);
    }
    Ok(())
}
