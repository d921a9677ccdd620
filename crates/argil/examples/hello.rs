//! Renders a sphere with a bite out of it: `cargo run --release -p argil --example hello`.

use argil::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::sphere(1.0))?;
    scene.push(
        Shape::sphere(0.6)
            .at([0.7, 0.7, 0.7])
            .subtract()
            .smooth(0.1),
    )?;

    // A hardware GPU if there is one, else the CPU.
    let world = Engine::auto()?.build(&scene)?.field();
    println!(
        "the distance at [0, 2, 0] is {}",
        world.distance([0.0, 2.0, 0.0])
    );

    world.render_view([640, 480])?.save("hello.png")?;
    println!("hello.png");
    Ok(())
}
