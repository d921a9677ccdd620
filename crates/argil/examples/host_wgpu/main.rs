//! A program with its own renderer draws triangles and a block that is carved in each frame, in one render pass and one submission:
//! `cargo run --release -p argil --example host_wgpu`. With `--headless --frames 60 --json` it opens no window, writes the last
//! picture, and prints what a frame asks of the device.

mod carving;
mod renderer;
mod window;

use argil::gpu::{GpuCounters, wgpu};
use argil::prelude::*;
use carving::Carving;
use renderer::Renderer;

const TEAPOT: &str = include_str!("../../../../scenes/teapot.json");
const SIZE: [u32; 2] = [640, 360];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |name: &str| arguments.iter().any(|word| word == name);
    let frames = arguments.iter().skip_while(|word| *word != "--frames");
    let frames: Option<u32> = frames.skip(1).flat_map(|n| n.parse()).next();

    let teapot = Scene::from_json(TEAPOT, "teapot.json")?;
    let teapot = Engine::cpu().build(&teapot)?.field();
    let teapot = teapot.mesh(&MeshOptions::default())?.mesh;
    let [first, later] = match has("--headless") {
        true => headless(&teapot, frames.unwrap_or(60))?,
        false => window::run(teapot, frames)?,
    };
    if has("--json") {
        println!("{{\"first\": {}, \"later\": {}}}", json(first), json(later));
    } else {
        println!("the first frame: {first:?}\nlater frames, at most: {later:?}");
    }
    Ok(())
}

/// Draws frames without a window, and writes the last one.
fn headless(
    mesh: &argil::mesh::Mesh,
    frames: u32,
) -> Result<[GpuCounters; 2], Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::default();
    let mut host = Renderer::new(&instance, None, mesh)?;
    host.resize(SIZE);
    let mut carving = Carving::new(&host.device, &host.queue, &host.targets())?;
    let target = host.target();
    let view = target.create_view(&Default::default());
    for frame in 0..frames.max(1) {
        host.draw(&view, 0.02 * frame as f32, &mut carving)?;
        // A window waits for its display.
        host.device.poll(wgpu::PollType::wait_indefinitely())?;
    }
    let picture = host.picture(&target)?;
    argil::save_png("host_wgpu.png".as_ref(), SIZE, &picture)?;
    Ok(carving.counts())
}

fn json(counts: GpuCounters) -> String {
    let GpuCounters {
        submissions,
        waits,
        buffers,
        pipelines,
        ..
    } = counts;
    format!(
        "{{\"submissions\": {submissions}, \"waits\": {waits}, \"buffers\": {buffers}, \"pipelines\": {pipelines}}}"
    )
}
