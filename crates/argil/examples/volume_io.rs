//! Saves bricks to a file, loads them, and reads their samples: `cargo run --release -p argil --example volume_io`.

use argil::prelude::*;
use argil::volume::{Volume, VolumeFile};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::torus(1.0, 0.3))?;
    let world = Engine::cpu().build(&scene)?.bricks(128)?;
    world.save("torus.argil")?;

    // A volume file also holds its scene, so the world can be edited.
    let file = VolumeFile::open("torus.argil")?;
    let (scene, world) = Engine::cpu().load(file, "torus.argil")?;
    println!(
        "{} brush, {} bytes in memory",
        scene.brush_count(),
        world.memory_bytes()
    );

    let volume = world.volume()?.ok_or("no volume")?;
    let Volume::Bricks(bricks) = volume.as_ref() else {
        return Err("not bricks".into());
    };
    let mut nearest = f32::INFINITY;
    let mut distances = Vec::new();
    for brick in bricks.iter() {
        distances.clear();
        distances.extend(brick.distances());
        nearest = distances
            .iter()
            .fold(nearest, |least, d| least.min(d.abs()));
    }
    println!(
        "{} bricks, the sample nearest to the surface is {nearest} away",
        bricks.len()
    );
    world.render_view([640, 480])?.save("volume_io.png")?;
    Ok(())
}
