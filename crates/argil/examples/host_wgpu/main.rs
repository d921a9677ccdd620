//! A program with its own renderer draws triangles and a block that is carved in each frame, in one render pass:
//! `cargo run --release -p argil --example host_wgpu -- --frames 60`.

mod renderer;

use argil::gpu::{Gpu, GpuCounters};
use argil::prelude::*;
use std::sync::Arc;

const TEAPOT: &str = include_str!("../../../../scenes/teapot.json");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let frames = arguments.iter().skip_while(|word| *word != "--frames");
    let frames: u32 = frames.skip(1).flat_map(|n| n.parse()).next().unwrap_or(6);

    let teapot = Scene::from_json(TEAPOT, "teapot.json")?;
    let teapot = Engine::cpu().build(&teapot)?.field();
    let teapot = teapot.mesh(&MeshOptions::default())?.mesh;
    let mut host = renderer::Renderer::new([640, 360], &teapot)?;

    // The engine shares the device. Its world keeps its bricks there.
    let gpu = Arc::new(Gpu::from_wgpu(host.device.clone(), host.queue.clone())?);
    let mut scene = Scene::new();
    scene.push(Shape::cuboid([1.4, 0.5, 1.4]).at([0.0, -0.35, 0.0]))?;
    let mut world = Engine::on_gpu(gpu.clone()).build(&scene)?.bricks(128)?;
    let mut own = world.host_frame(&renderer::targets())?;
    let settings = RenderSettings {
        samples: 1,
        ground: false,
        ..world.render_settings(host.size, RenderMode::Shaded)
    };

    let mut counts = Vec::new();
    for frame in 0..frames {
        let angle = 0.4 * frame as f32;
        let place = [1.2 * angle.cos(), 0.2, 1.2 * angle.sin()];
        scene.push(Shape::sphere(0.3).at(place).subtract().smooth(0.05))?;
        let before = gpu.counters();
        world.apply(&scene)?;
        let edited = gpu.counters();

        let mut encoder = host.device.create_command_encoder(&Default::default());
        let view = host.clip_from_world(0.02 * frame as f32);
        world.encode_frame(&mut own, view, &settings, &mut encoder)?;
        host.draw(&mut encoder, view, |pass| own.composite(pass));
        host.queue.submit([encoder.finish()]);
        counts.push([since(before, edited), since(edited, gpu.counters())]);
    }
    // The last of each, without the submission of the host.
    if let Some([edit, frame]) = counts.last() {
        println!("{{\"frames\": {frames}, \"edit\": {edit}, \"frame\": {frame}}}");
    }
    argil::save_png("host_wgpu.png".as_ref(), host.size, &host.picture()?)?;
    Ok(())
}

/// What the engine asked of the device in between, as JSON.
fn since(before: GpuCounters, after: GpuCounters) -> String {
    let submissions = after.submissions - before.submissions;
    let waits = after.waits - before.waits;
    let buffers = after.buffers - before.buffers;
    let pipelines = after.pipelines - before.pipelines;
    format!(
        "{{\"submissions\": {submissions}, \"waits\": {waits}, \"buffers\": {buffers}, \"pipelines\": {pipelines}}}"
    )
}
