//! The first use of a GPU by a program, which creates pipelines.

use crate::configuration::{BRICKS, Configuration};
use crate::counters;
use crate::outcome::Outcome;
use crate::task::FirstUse;
use argil::glam::Vec3;
use argil::render::RenderMode;
use argil::scene::{Brush, Scene, Shape};
use argil::{Backend, Engine, MeshOptions, World};
use std::time::Instant;

/// Voxels along the longest side: few, because pipelines are measured.
const RESOLUTION: u32 = 64;

/// The size of an image in pixels.
const SIZE: [u32; 2] = [64, 64];

/// Opens the GPU again, and times the first and the second use of it. The driver may have stored pipelines on disk.
///
/// # Errors
/// If the device fails.
pub(crate) fn sample(kind: FirstUse, scene: &Scene, out: &mut Outcome) -> anyhow::Result<()> {
    let start = Instant::now();
    let engine = Engine::with_backend(Backend::Gpu)?;
    out.add("open_ms", start.elapsed().as_secs_f64() * 1e3);
    let mut copy = scene.clone();
    for name in ["first_ms", "second_ms"] {
        let before = counters::counts(&engine);
        let start = Instant::now();
        run(kind, &engine, &mut copy)?;
        out.add(name, start.elapsed().as_secs_f64() * 1e3);
        for (count_name, count) in counters::since(&before, &counters::counts(&engine)) {
            let name = name.trim_end_matches("_ms");
            out.add(&format!("{count_name}_{name}"), count as f64);
        }
    }
    Ok(())
}

fn run(kind: FirstUse, engine: &Engine, scene: &mut Scene) -> anyhow::Result<()> {
    let bricks = |scene: &Scene| -> anyhow::Result<World> {
        let way = Configuration::of(BRICKS, RESOLUTION);
        Ok(engine.build(scene)?.with_representation(way.via())?)
    };
    let mode = match kind {
        FirstUse::LitFrame => RenderMode::Shaded,
        _ => RenderMode::Normal,
    };
    match kind {
        FirstUse::Bake => {
            bricks(scene)?;
        }
        FirstUse::Frame | FirstUse::LitFrame => {
            let world = bricks(scene)?;
            world.render(&world.camera(), &world.render_settings(SIZE, mode))?;
        }
        FirstUse::FieldFrame => {
            let world = engine.build(scene)?.field();
            world.render(&world.camera(), &world.render_settings(SIZE, mode))?;
        }
        FirstUse::Edit => {
            let mut world = bricks(scene)?;
            let bounds = world.view_bounds();
            let radius = 0.02 * bounds.size().max_element();
            let place = Vec3::lerp(bounds.min, bounds.max, 0.5).to_array();
            scene.push(Brush::new(Shape::sphere(radius)).at(place).subtract())?;
            world.apply(scene)?;
            world.flush()?;
        }
        FirstUse::Mesh => {
            let options = MeshOptions {
                resolution: RESOLUTION,
                ..MeshOptions::default()
            };
            engine.build(scene)?.field().mesh(&options)?;
        }
    }
    Ok(())
}
