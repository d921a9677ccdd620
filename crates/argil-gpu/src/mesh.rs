//! Triangles on the device, drawn with a depth buffer.

use crate::pass::{DRAWN, FRAME, FRAME_WGSL, entry};
use crate::picture::Way;
use crate::timing::Timing;
use crate::{Gpu, GpuError, GpuField};
use argil_abi::Frame;
use argil_march::{Picture, Triangles, wgsl};
use glam::Vec3;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// A normal and the length of a ray.
const NEAREST: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Triangles on a device.
pub struct GpuMesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl GpuMesh {
    /// Bring triangles over; corners without a normal are lit as if they faced the viewer. `field` is what they were made
    /// from: it gives the light.
    pub fn upload(field: &GpuField, mesh: Triangles<'_>) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        field.picture(Way::Mesh)?;
        let vertices: Vec<[Vec3; 2]> = mesh
            .positions
            .iter()
            .enumerate()
            .map(|(i, &p)| [p, mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO)])
            .collect();
        let bytes: &[u8] = bytemuck::cast_slice(&vertices);
        let indices: &[u8] = bytemuck::cast_slice(mesh.triangles);
        let vertices = buffer(gpu, "corners", bytes, wgpu::BufferUsages::VERTEX)?;
        let indices = buffer(gpu, "triangles", indices, wgpu::BufferUsages::INDEX)?;
        let (layout, pipeline) = gpu.checked(|| pipeline(gpu))?;
        Ok(Self {
            vertices,
            indices,
            count: 3 * mesh.triangles.len() as u32,
            pipeline,
            layout,
        })
    }

    /// Bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        self.vertices.size() + self.indices.size()
    }

    /// Draw as [`GpuField::render`] does, what is nearest by the device's depth test.
    pub fn render(&self, field: &GpuField, frames: &[Frame]) -> Result<(Picture, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((Picture::empty(), 0.0));
        };
        let gpu = field.gpu();
        let target = |label, format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: first.width,
                    height: first.height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let (nearest, depth, uniform) = gpu.checked(|| {
            let nearest = target("nearest", NEAREST, wgpu::TextureUsages::TEXTURE_BINDING);
            let depth = target("depth", DEPTH, wgpu::TextureUsages::empty());
            (
                nearest,
                depth,
                crate::volume::uniform_of::<Frame>(gpu, "frame"),
            )
        })?;
        let view = nearest.create_view(&wgpu::TextureViewDescriptor::default());
        let depth = depth.create_view(&wgpu::TextureViewDescriptor::default());
        let bind_group = gpu.checked(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Triangles"),
                layout: &self.layout,
                entries: &[entry(FRAME, &uniform)],
            })
        })?;
        let mut before = |frame: &Frame, timing: Option<&mut Timing>| {
            gpu.queue
                .write_buffer(&uniform, 0, bytemuck::bytes_of(frame));
            gpu.checked(|| self.submit(gpu, [&view, &depth], &bind_group, timing))
        };
        let own = [wgpu::BindGroupEntry {
            binding: DRAWN,
            resource: wgpu::BindingResource::TextureView(&view),
        }];
        field
            .picture(Way::Mesh)?
            .draw_after(field, &own, frames, &mut before)
    }

    fn submit(
        &self,
        gpu: &Gpu,
        [nearest, depth]: [&wgpu::TextureView; 2],
        bind_group: &wgpu::BindGroup,
        timing: Option<&mut Timing>,
    ) {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("Triangles"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: nearest,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timing.and_then(|timing| timing.next_render()),
            ..wgpu::RenderPassDescriptor::default()
        });
        if self.count > 0 {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, bind_group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.count, 0, 0..1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
}

fn buffer(
    gpu: &Gpu,
    label: &'static str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let limit = gpu.device.limits().max_buffer_size;
    if bytes.len() as u64 > limit {
        return Err(GpuError::TooLarge {
            what: label,
            bytes: bytes.len() as u64,
            name: gpu.info.name.clone(),
            limit,
        });
    }
    let buffer = gpu.checked(|| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.len().max(4) as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    })?;
    gpu.queue.write_buffer(&buffer, 0, bytes);
    Ok(buffer)
}

fn pipeline(gpu: &Gpu) -> (wgpu::BindGroupLayout, wgpu::RenderPipeline) {
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("Triangles"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: FRAME,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
    let source = [&argil_abi::wgsl(), FRAME_WGSL, wgsl::DRAW].concat();
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("Triangles"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
    let pipeline_layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("Triangles"),
            bind_group_layouts: &[Some(&layout)],
            ..wgpu::PipelineLayoutDescriptor::default()
        });
    let pipeline = gpu
        .device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("Triangles"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("place"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 24,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
                })],
            },
            // Counterclockwise as seen from outside; nothing is culled, as the eye may be inside.
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("nearest"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(NEAREST.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
    (layout, pipeline)
}
