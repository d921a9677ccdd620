//! What the tests of measures are held to: lengths of rays to the teapot by its field and by triangles, and exact and stored
//! distances, as little-endian 32-bit numbers. `cargo run --release -p argil-study --example metrics_data FOLDER`

use anyhow::Context;
use argil::render::{RenderMode, RenderSettings};
use argil::scene::Scene;
use argil::{BricksOptions, Engine, MeshRenderOptions, Representation};
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let folder = std::env::args().nth(1).context("name a folder")?;
    let write = |name: &str, numbers: &[f32]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        std::fs::write(Path::new(&folder).join(name), bytes)
    };
    let scene = Scene::from_json(include_str!("../../scenes/teapot.json"), "teapot.json")?;
    let field = Engine::cpu().build(&scene)?.field();
    let via = |via: Representation| field.engine().build(&scene)?.with_representation(via);

    let triangles = via(Representation::Mesh(MeshRenderOptions {
        resolution: 32,
        ..MeshRenderOptions::default()
    }))?;
    let camera = field.camera();
    for (name, world) in [("exact-lengths", &field), ("mesh-lengths", &triangles)] {
        let settings = RenderSettings {
            samples: 1,
            ground: false,
            ..world.render_settings([60, 40], RenderMode::Depth)
        };
        write(
            &format!("{name}.f32"),
            &world.ray_distances(&camera, &settings)?,
        )?;
    }

    let bricks = via(Representation::Bricks(BricksOptions {
        resolution: 32,
        ..BricksOptions::default()
    }))?;
    let focus = field.view_bounds();
    let at = |i: u32, k: u32| (0.5 + i as f32 / [1.2207f32, 1.4903, 1.8192][k as usize]).fract();
    let points: Vec<[f32; 3]> = (0..2000)
        .map(|i| focus.min + focus.size() * argil::glam::Vec3::from([0, 1, 2].map(|k| at(i, k))))
        .map(|p| p.to_array())
        .collect();
    let mut found = vec![0.0; points.len()];
    field.query().distances(&points, &mut found);
    write("exact-distances.f32", &found)?;
    let stored = bricks.query_volume().context("a volume")?;
    stored.distances(&points, &mut found);
    write("stored-distances.f32", &found)?;
    Ok(())
}
