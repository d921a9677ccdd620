//! The same user interface without a window, drawn into a texture as eframe draws into a window.

use super::sculpture::Sculpture;
use super::view::View;
use super::{Fault, descriptor};
use argil::gpu::{GpuCounters, wgpu};
use eframe::egui;
use eframe::egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};

const SIZE: [u32; 2] = [640, 360];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Draws frames, and writes the last one.
pub(crate) fn run(frames: u32) -> Result<[GpuCounters; 2], Fault> {
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor(&adapter)))?;
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: SIZE[0],
            height: SIZE[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let target_view = target.create_view(&Default::default());
    let mut renderer = Renderer::new(&device, FORMAT, RendererOptions::default());
    let sculpture = Sculpture::new(&device, &queue, FORMAT)?;
    renderer.callback_resources.insert(sculpture);
    let (context, mut view) = (egui::Context::default(), View::default());
    let screen = ScreenDescriptor {
        size_in_pixels: SIZE,
        pixels_per_point: 1.0,
    };
    for frame in 0..frames.max(1) {
        view.draw.radius = 0.5 + 0.2 * (0.3 * frame as f32).sin();
        let size = egui::Vec2::from(SIZE.map(|side| side as f32));
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            ..Default::default()
        };
        let mut output = context.run_ui(input, |ui| view.show(ui));
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in deltas {
                renderer.update_texture(&device, &queue, id, &delta);
            }
        }
        let jobs = context.tessellate(output.shapes, output.pixels_per_point);
        let mut encoder = device.create_command_encoder(&Default::default());
        let before = renderer.update_buffers(&device, &queue, &mut encoder, &jobs, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
        queue.submit(before.into_iter().chain([encoder.finish()]));
        // A window waits for its display.
        device.poll(wgpu::PollType::wait_indefinitely())?;
        for id in output.textures_delta.free.drain() {
            renderer.free_texture(&id);
        }
    }
    argil::save_png(
        "host_egui.png".as_ref(),
        SIZE,
        &picture(&device, &queue, &target)?,
    )?;
    let sculpture = renderer.callback_resources.get::<Sculpture>();
    Ok(sculpture.ok_or("no world")?.counts())
}

/// Downloads a target.
fn picture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    target: &wgpu::Texture,
) -> Result<Vec<u8>, Fault> {
    let row = (4 * SIZE[0]).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * SIZE[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        target.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        target.size(),
    );
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = buffer.slice(..).get_mapped_range()?;
    let rows = bytes.chunks_exact(row as usize);
    let pixels = rows.flat_map(|row| row[..4 * SIZE[0] as usize].chunks_exact(4));
    Ok(pixels.flat_map(|pixel| pixel[..3].to_vec()).collect())
}
