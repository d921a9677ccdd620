//! A program with egui draws a world inside its user interface, on egui's device, with one submission for all:
//! `cargo run --release -p argil --example host_egui`. With `--headless --frames 60 --json` it opens no window, moves a slider
//! in each frame, writes the last picture, and prints what a frame asks of the device.

mod headless;
mod sculpture;
mod view;

use argil::gpu::{Gpu, GpuCounters, wgpu};
use eframe::egui_wgpu::WgpuSetup;
use sculpture::Sculpture;
use std::sync::Arc;
use view::View;

type Fault = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Fault> {
    let arguments: Vec<String> = std::env::args().collect();
    let has = |name: &str| arguments.iter().any(|word| word == name);
    let frames = arguments.iter().skip_while(|word| *word != "--frames");
    let frames = frames.skip(1).flat_map(|n| n.parse()).next().unwrap_or(60);
    if !has("--headless") {
        return windowed();
    }
    let [first, later] = headless::run(frames)?.map(json);
    match has("--json") {
        true => println!("{{\"first\": {first}, \"later\": {later}}}"),
        false => println!("the first frame: {first}\nlater frames, at most: {later}"),
    }
    Ok(())
}

/// What a device of egui needs for the engine, too.
fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        required_features: Gpu::required_features() | adapter.features() & Gpu::wished_features(),
        required_limits: Gpu::required_limits(adapter),
        ..Default::default()
    }
}

fn windowed() -> Result<(), Fault> {
    let mut options = eframe::NativeOptions::default();
    if let WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        setup.device_descriptor = Arc::new(descriptor);
    }
    let begin = |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, Fault> {
        let state = cc.wgpu_render_state.as_ref().ok_or("egui has no device")?;
        let sculpture = Sculpture::new(&state.device, &state.queue, state.target_format)?;
        state.renderer.write().callback_resources.insert(sculpture);
        Ok(Box::new(View::default()))
    };
    let shown = eframe::run_native("Argil in egui", options, Box::new(begin));
    shown.map_err(|fault| format!("{fault}: without a display, run it with --headless").into())
}

fn json(counts: GpuCounters) -> String {
    let names = ["submissions", "waits", "buffers", "pipelines"];
    let all = [
        counts.submissions,
        counts.waits,
        counts.buffers,
        counts.pipelines,
    ];
    let pairs = names
        .iter()
        .zip(all)
        .map(|(name, n)| format!("\"{name}\": {n}"));
    format!("{{{}}}", pairs.collect::<Vec<_>>().join(", "))
}
