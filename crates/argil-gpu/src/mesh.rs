//! Triangles on the device, drawn with a depth buffer.

use crate::pass::{DRAWN, FRAME, FRAME_WGSL, entry};
use crate::picture::Way;
use crate::table::Table;
use crate::timing::Timing;
use crate::volume::read_table;
use crate::{Gpu, GpuError, GpuField};
use argil_abi::Frame;
use argil_march::{Picture, Triangles, wgsl};
use argil_mesh::Mesh;
use glam::Vec3;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// A normal and the length of a ray.
const NEAREST: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Triangles on a device.
pub struct GpuMesh {
    /// Positions and normals.
    vertices: Table,
    /// None where each triangle has corners of its own.
    indices: Option<Table>,
    triangles: u32,
    corners: u32,
    pipeline: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
}

impl GpuMesh {
    /// Bring triangles over; corners without a normal are lit as if they faced the viewer. `field` is what they were made
    /// from: it gives the light.
    pub fn upload(field: &GpuField, mesh: Triangles<'_>) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let vertices: Vec<[Vec3; 2]> = mesh
            .positions
            .iter()
            .enumerate()
            .map(|(i, &p)| [p, mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO)])
            .collect();
        let mut corners = Table::drawn("corners");
        corners.write(gpu, &vertices)?;
        let mut indices = Table::drawn("triangles");
        indices.write(gpu, mesh.triangles)?;
        let counts = [mesh.positions.len(), mesh.triangles.len()];
        Self::of_tables(field, corners, Some(indices), counts.map(|n| n as u32))
    }

    pub(crate) fn of_tables(
        field: &GpuField,
        vertices: Table,
        indices: Option<Table>,
        [corners, triangles]: [u32; 2],
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        field.picture(Way::Mesh)?;
        let (layout, pipeline) = gpu.checked(|| pipeline(gpu))?;
        Ok(Self {
            vertices,
            indices,
            triangles,
            corners,
            pipeline,
            layout,
        })
    }

    /// Numbers of triangles and of corners.
    pub fn counts(&self) -> [u64; 2] {
        [self.triangles, self.corners].map(u64::from)
    }

    /// Bring the triangles back, without materials; normals are zero where there are none.
    pub async fn read(&self, gpu: &Gpu) -> Result<Mesh, GpuError> {
        let vertices = read_table(gpu, &self.vertices, 24 * u64::from(self.corners)).await?;
        let of = |at: usize, bytes: &[u8]| -> Vec3 {
            Vec3::from_array(bytemuck::pod_read_unaligned(&bytes[12 * at..12 * at + 12]))
        };
        let triangles = match &self.indices {
            Some(indices) => read_table(gpu, indices, 12 * u64::from(self.triangles))
                .await?
                .chunks_exact(12)
                .map(bytemuck::pod_read_unaligned)
                .collect(),
            None => (0..self.triangles)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect(),
        };
        Ok(Mesh {
            positions: vertices.chunks_exact(24).map(|v| of(0, v)).collect(),
            normals: vertices.chunks_exact(24).map(|v| of(1, v)).collect(),
            materials: Vec::new(),
            triangles,
        })
    }

    /// Bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        self.vertices.size() + self.indices.as_ref().map_or(0, Table::size)
    }

    /// Draw as [`GpuField::render`] does, what is nearest by the device's depth test.
    pub async fn render(
        &self,
        field: &GpuField,
        frames: &[Frame],
    ) -> Result<(Picture, f64), GpuError> {
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
            .await
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
        if let Some(vertices) = self.vertices.buffer()
            && self.triangles > 0
        {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, bind_group, &[]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            match self.indices.as_ref().and_then(Table::buffer) {
                Some(indices) => {
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..3 * self.triangles, 0, 0..1);
                }
                None => pass.draw(0..3 * self.triangles, 0..1),
            }
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
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
