//! A program with its own device and targets, for tests.

use argil::gpu::{Gpu, HostFrame, HostTargets, wgpu};
use argil::prelude::*;
use argil::{RenderError, Representation};
use glam::camera::rh::{proj::directx, view::look_at_mat4};
use glam::{Mat4, Vec3};
use std::sync::Arc;

pub(crate) const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
pub(crate) const NEAR: f32 = 0.1;
/// What the host clears its color to.
pub(crate) const CLEAR: [u8; 3] = [51, 102, 153];

/// What rays march through in frames of a host.
pub(crate) fn representations() -> Vec<Representation> {
    let mut all = Representation::all(48);
    all.retain(|representation| !matches!(representation, Representation::Mesh(_)));
    all
}

/// A view that is rolled, and whose middle is not in the image's middle.
pub(crate) fn odd_view() -> Mat4 {
    odd_view_from(NEAR)
}

/// The same with another near plane.
pub(crate) fn odd_view_from(near: f32) -> Mat4 {
    let shift = Mat4::from_translation(Vec3::new(0.25, -0.15, 0.0));
    let projection = directx::perspective_infinite_reverse(0.6, 1.4, near);
    let up = Vec3::new(0.4, 1.0, 0.1);
    shift * projection * look_at_mat4(Vec3::new(1.5, 1.0, 4.0), Vec3::ZERO, up)
}

/// Returns the point of a pixel with a depth, by the inverse of the matrix.
pub(crate) fn point_at(view: Mat4, size: [u32; 2], pixel: usize, depth: f64) -> glam::DVec3 {
    let (x, y) = (pixel as u32 % size[0], pixel as u32 / size[0]);
    let clip = glam::DVec4::new(
        (f64::from(x) + 0.5) / f64::from(size[0]) * 2.0 - 1.0,
        1.0 - (f64::from(y) + 0.5) / f64::from(size[1]) * 2.0,
        depth,
        1.0,
    );
    let p = view.as_dmat4().inverse() * clip;
    p.truncate() / p.w
}

/// The number of a binary16.
pub(crate) fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f32::from(bits & 1023));
    let size = match exponent {
        0 => mantissa * 2.0_f32.powi(-24),
        _ => (1024.0 + mantissa) * 2.0_f32.powi(exponent - 25),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// A host with a color and a reversed depth buffer.
pub(crate) struct Host {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) size: [u32; 2],
    pub(crate) color: wgpu::Texture,
    pub(crate) depth: wgpu::Texture,
}

pub(crate) fn opened(
    limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits,
) -> Result<(wgpu::Device, wgpu::Queue), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let asked = adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: Gpu::required_features() | adapter.features() & Gpu::wished_features(),
        required_limits: limits(&adapter),
        ..Default::default()
    });
    Ok(pollster::block_on(asked)?)
}

/// Creates a target.
pub(crate) fn target(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

impl Host {
    pub(crate) fn new(size: [u32; 2]) -> Result<Self, Box<dyn std::error::Error>> {
        let (device, queue) = opened(Gpu::required_limits)?;
        Ok(Self {
            color: target(&device, size, COLOR),
            depth: target(&device, size, DEPTH),
            size,
            device,
            queue,
        })
    }

    pub(crate) fn engine(&self) -> Result<(Arc<Gpu>, Engine), Box<dyn std::error::Error>> {
        let gpu = Gpu::from_wgpu(self.device.clone(), self.queue.clone())?;
        let gpu = Arc::new(gpu);
        Ok((gpu.clone(), Engine::on_gpu(gpu)))
    }

    pub(crate) fn targets() -> HostTargets {
        Self::targets_with(wgpu::CompareFunction::Greater)
    }

    pub(crate) fn targets_with(compare: wgpu::CompareFunction) -> HostTargets {
        HostTargets {
            depth: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            ..HostTargets::new(COLOR)
        }
    }

    /// Draws a frame after the host has cleared its depth, and submits it once.
    pub(crate) fn draw(
        &self,
        world: &World,
        frame: &mut HostFrame,
        look: (Mat4, RenderMode),
        depth: f32,
    ) -> Result<(), RenderError> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        self.encode(world, frame, look, &mut encoder)?;
        self.pass(frame, depth, &mut encoder);
        self.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Encodes a frame.
    pub(crate) fn encode(
        &self,
        world: &World,
        frame: &mut HostFrame,
        (view, mode): (Mat4, RenderMode),
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), RenderError> {
        let settings = RenderSettings {
            samples: 1,
            ground: false,
            ..world.render_settings(self.size, mode)
        };
        world.encode_frame(frame, view.to_cols_array_2d(), &settings, encoder)
    }

    /// Draws an encoded frame in a pass that clears the targets.
    pub(crate) fn pass(&self, frame: &HostFrame, depth: f32, encoder: &mut wgpu::CommandEncoder) {
        self.pass_with(&[&self.color], frame, depth, encoder);
    }

    /// Draws an encoded frame into other targets, and into the depth.
    pub(crate) fn pass_with(
        &self,
        targets: &[&wgpu::Texture],
        frame: &HostFrame,
        depth: f32,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let [r, g, b] = CLEAR.map(|c| f64::from(c) / 255.0);
        let views = targets
            .iter()
            .map(|texture| texture.create_view(&Default::default()));
        let views: Vec<_> = views.collect();
        let depth_view = self.depth.create_view(&Default::default());
        let attachments = views.iter().map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &attachments.collect::<Vec<_>>(),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(depth),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        frame.composite(&mut pass);
    }

    /// Downloads the four bytes of each pixel of a target.
    pub(crate) fn pixels(
        &self,
        target: &wgpu::Texture,
    ) -> Result<Vec<[u8; 4]>, Box<dyn std::error::Error>> {
        let [width, height] = self.size;
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
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
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        let bytes = buffer.slice(..).get_mapped_range()?;
        let rows = bytes.chunks_exact(row as usize);
        let all = rows.flat_map(|row| row[..4 * width as usize].as_chunks().0.to_vec());
        Ok(all.collect())
    }

    pub(crate) fn depths(&self) -> Result<Vec<f32>, Box<dyn std::error::Error>> {
        let all = self.pixels(&self.depth)?;
        Ok(all.into_iter().map(f32::from_le_bytes).collect())
    }
}
