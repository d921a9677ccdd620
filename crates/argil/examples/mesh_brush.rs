//! Blends a triangle mesh into a wall: `cargo run --release -p argil --example mesh_brush [MESH]`.

use argil::prelude::*;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/suzanne.obj");
    let file = std::env::args()
        .nth(1)
        .unwrap_or_else(|| shipped.to_owned());
    let file = Path::new(&file);
    let name = file
        .file_name()
        .and_then(|name| name.to_str())
        .ok_or("the mesh has no name")?;

    // The mesh is repaired and sampled when the scene loads it.
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.7, 1.3, 0.6]))?;
    // This one stands away from the origin: its center moves to the front of the wall.
    let head = Shape::mesh(name).at([2.494, -1.252, -3.9]).smooth(0.15);
    let mesh = scene.push(head)?.node;

    let folder = file.parent().ok_or("the mesh has no folder")?;
    for loaded in argil::load_meshes(&mut scene, folder, false)? {
        println!("{}: {} triangles", loaded.path, loaded.triangles);
        for warning in loaded.warnings() {
            println!("  {warning}");
        }
    }
    println!("{} is a brush like any other", scene.path(mesh));

    let world = Engine::cpu().build(&scene)?.bricks(192)?;
    world.render_view([640, 480])?.save("mesh_brush.png")?;
    Ok(())
}
