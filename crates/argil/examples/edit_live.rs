//! Carves a tunnel while a game would run, with a budget of 2 ms per frame: `cargo run --release -p argil --example edit_live`.

use argil::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([2.0, 1.0, 2.0]))?;
    let mut world = Engine::cpu().build(&scene)?.bricks(256)?;

    // Called with the boxes that changed, for physics or navigation.
    let subscription = world.subscribe(|boxes| println!("  {} boxes changed", boxes.len()));

    // One undo step for the whole tunnel.
    scene.begin_stroke();
    for frame in 0..20 {
        let x = -2.0 + 0.2 * frame as f32;
        let position = [x, 0.5 + 0.2 * x.sin(), 0.0];
        scene.push(Shape::sphere(0.35).at(position).subtract().smooth(0.1))?;
        let report = world.apply_within(&scene, EditBudget::new(2.0).near(position))?;
        println!(
            "frame {frame}: {:.2} ms, {} blocks remain",
            report.duration_ms, report.remaining_blocks
        );
    }
    scene.end_stroke();
    let stats = world.flush()?;
    println!(
        "{} bricks sampled, {} added, {} removed",
        stats.filled, stats.added, stats.removed
    );

    world.render_view([640, 480])?.save("edit_live.png")?;
    scene.undo();
    world.apply(&scene)?;
    world.unsubscribe(subscription);
    assert!(world.distance([0.0, 0.5, 0.0]) < 0.0, "the tunnel is gone");
    Ok(())
}
