//! Moves a brush by keyframes and renders six frames: `cargo run --release -p argil --example animation`.

use argil::prelude::*;
use argil::scene::Ease;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let key = |time: f32, translate: [f32; 3]| Keyframe {
        time,
        ease: Ease::Smooth,
        translate: Some(translate),
        ..Keyframe::default()
    };
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.2, 0.2, 0.6]))?;
    let drop = Shape::sphere(0.35)
        .smooth(0.3)
        .with_keyframe(key(0.0, [-0.8, 1.2, 0.0]))
        .with_keyframe(key(1.0, [0.0, 0.3, 0.0]))
        .with_keyframe(key(2.0, [0.8, 1.2, 0.0]));
    scene.push(drop)?;

    // Bricks follow a moving brush as they follow an edit.
    let mut world = Engine::cpu().build(&scene)?.bricks(128)?;
    for frame in 0..6 {
        scene.set_time(2.0 * frame as f32 / 5.0);
        let report = world.apply(&scene)?;
        println!("frame {frame}: {:.2} ms", report.duration_ms);
        world
            .render_view([320, 240])?
            .save(format!("animation-{frame}.png"))?;
    }
    Ok(())
}
