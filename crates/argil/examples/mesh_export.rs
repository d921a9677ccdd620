//! Exports a part for a 3D printer, and a light mesh for a game: `cargo run --release -p argil --example mesh_export`.

use argil::mesh::{MeshFormat, MeshWriteOptions, UpAxis};
use argil::{MeshMethod, MeshRenderOptions, prelude::*, save_mesh};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Lengths in millimeters: a knob of 30 mm.
    let knob =
        Shape::cylinder(15.0, 6.0) | Shape::cylinder(8.0, 9.0).at([0.0, 10.0, 0.0]).smooth(4.0);
    let mut scene = Scene::new();
    scene.push(knob - Shape::cylinder(3.0, 30.0))?;
    let world = Engine::cpu().build(&scene)?.field();

    // For the printer: voxels of 0.2 mm, z up, closed.
    let fine = MeshOptions {
        voxel_size: Some(0.2),
        ..MeshOptions::default()
    };
    let output = world.mesh(&fine)?;
    assert!(output.report.is_watertight());
    println!(
        "knob.stl: {} triangles, {:.0} mm³, vertices {:.5} voxels from the surface",
        output.report.triangles, output.report.volume, output.surface_error.rms_voxels
    );
    let z_up = MeshWriteOptions {
        axes: UpAxis::ZUp,
        ..MeshWriteOptions::default()
    };
    save_mesh(&output.mesh, MeshFormat::Stl, &z_up, "knob.stl")?;

    // For the game: sharp edges, and at most 2,000 triangles.
    let light = MeshOptions {
        method: MeshMethod::DualContouring,
        resolution: 64,
        max_triangles: Some(2000),
        ..MeshOptions::default()
    };
    let output = world.mesh(&light)?;
    println!("knob.glb: {} triangles", output.report.triangles);
    output.save("knob.glb")?;

    let preview = MeshRenderOptions {
        resolution: 64,
        flat: true,
        ..MeshRenderOptions::default()
    };
    let world = Engine::cpu().build(&scene)?.with_representation(preview)?;
    world.render_view([640, 480])?.save("mesh_export.png")?;
    Ok(())
}
