//! Models a machine part with operators and materials, and saves its scene: `cargo run --release -p argil --example csg`.

use argil::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::new();
    let steel = Material {
        base_color: [0.35, 0.4, 0.45],
        metallic: 1.0,
        roughness: 0.35,
        ..Material::default()
    };
    scene.set_material("steel", steel)?;

    // The classic: a cube with rounded corners, and a hole along each axis.
    let body = Shape::cuboid([0.75; 3]) & Shape::sphere(1.0);
    let hole = Shape::cylinder(0.4, 2.0);
    let holes = hole.clone()
        | hole.clone().rotated([1.0, 0.0, 0.0], 90.0)
        | hole.rotated([0.0, 0.0, 1.0], 90.0);
    scene.push((body - holes).with_material("steel").with_name("part"))?;

    // A ring around it, with a smooth joint.
    let ring = Shape::torus(1.0, 0.08).smooth(0.1);
    scene.push(ring.with_material("steel"))?;
    scene.save("csg.json")?;

    let world = Engine::cpu().build(&scene)?.bricks(256)?;
    world.render_view([640, 480])?.save("csg.png")?;
    println!("csg.json, csg.png: {} brushes", scene.brush_count());
    Ok(())
}
