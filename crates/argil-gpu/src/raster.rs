//! Triangles on the device, drawn with a depth buffer.

use crate::bindings::{Bind, DRAWN, DRAWN_WGSL, FRAME, FRAME_WGSL};
use crate::frame_extras::{Drawing, FrameExtras};
use crate::resources::read_table;
use crate::storage_buffer::StorageBuffer;
use crate::timing::Timing;
use crate::trace_mode::{BoundResource, TraceMode};
use crate::{Gpu, GpuError, GpuProgram, ImageOutput};
use argil_abi::FrameUniform;
use argil_mesh::Mesh;
use argil_render::{RenderOutput, Triangles, wgsl};
use glam::Vec3;
use std::sync::{Mutex, MutexGuard, PoisonError};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// A normal and the length of a ray.
const NEAREST: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

pub(crate) static MESH: TraceMode = TraceMode {
    name: "mesh",
    more_name: "mesh with more light",
    march: wgsl::RASTER_HITS,
    tables: || DRAWN_WGSL.to_owned(),
    binds: &[Bind::Picture(DRAWN)],
    constants: &[],
    draws: true,
    is_exact: false,
    paths: None,
    host: None,
    has_cones: false,
    by_lists: false,
};

/// Triangles on a device.
#[derive(Debug)]
pub struct GpuMesh {
    /// Positions and normals.
    vertices: StorageBuffer,
    /// `None` if each triangle has its own vertices.
    indices: Option<StorageBuffer>,
    triangles: u32,
    corners: u32,
    /// The previous frame's target.
    target: Mutex<Option<RasterTarget>>,
}

impl GpuMesh {
    /// Uploads triangles. A vertex without a normal is lit as if it faced the viewer. `field` is the program that
    /// they were made from, which provides light.
    ///
    /// # Errors
    /// If the mesh exceeds the device's limits or memory.
    pub fn upload(field: &GpuProgram, mesh: Triangles<'_>) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let vertices: Vec<[Vec3; 2]> = mesh
            .positions
            .iter()
            .enumerate()
            .map(|(i, &p)| [p, mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO)])
            .collect();
        let mut corners = StorageBuffer::drawn("corners");
        corners.write(gpu, &vertices)?;
        let mut indices = StorageBuffer::drawn("triangles");
        indices.write(gpu, mesh.triangles)?;
        let counts = [mesh.positions.len(), mesh.triangles.len()];
        Ok(Self::of_tables(
            corners,
            Some(indices),
            counts.map(|n| n as u32),
        ))
    }

    pub(crate) fn of_tables(
        vertices: StorageBuffer,
        indices: Option<StorageBuffer>,
        [corners, triangles]: [u32; 2],
    ) -> Self {
        Self {
            vertices,
            indices,
            triangles,
            corners,
            target: Mutex::default(),
        }
    }

    /// Returns the numbers of triangles and vertices.
    pub fn counts(&self) -> [u64; 2] {
        [self.triangles, self.corners].map(u64::from)
    }

    /// Downloads the triangles, without materials. Missing normals are zero.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn download(&self, gpu: &Gpu) -> Result<Mesh, GpuError> {
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

    /// Returns the bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        self.vertices.size() + self.indices.as_ref().map_or(0, StorageBuffer::size)
    }

    /// Renders as [`GpuProgram::render`] does. The device's depth test keeps the nearest triangle.
    ///
    /// # Errors
    /// If the image exceeds the device's memory, or the device fails.
    pub async fn render(
        &self,
        field: &GpuProgram,
        frames: &[FrameUniform],
        output: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((RenderOutput::empty(), 0.0));
        };
        let size = [first.width, first.height];
        let kept = self.lock().take().filter(|target| target.size == size);
        let target = match kept {
            Some(target) => target,
            None => RasterTarget::new(field.gpu(), size)?,
        };
        let bound = vec![BoundResource::View(DRAWN, target.nearest.clone())];
        let gpu = field.gpu();
        let pass = field.plain_passes("triangles", || RasterPass::new(gpu))?;
        let drawing = RasterOutput {
            pass: &pass,
            mesh: self,
            target: &target,
        };
        let passes = field.picture(&MESH, first)?;
        let extras = FrameExtras {
            drawing: Some(&drawing),
            ..FrameExtras::of(output)
        };
        let drawn = passes.draw(field, bound, extras, frames).await;
        *self.lock() = Some(target);
        drawn.map(|drawn| (drawn.picture, drawn.duration_ms))
    }

    fn lock(&self) -> MutexGuard<'_, Option<RasterTarget>> {
        self.target.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The textures that triangles of a frame's size are drawn on.
#[derive(Debug)]
struct RasterTarget {
    size: [u32; 2],
    nearest: wgpu::TextureView,
    depth: wgpu::TextureView,
    /// The frames of the previous draw, with their bind group.
    bound: Mutex<Option<(wgpu::Buffer, wgpu::BindGroup)>>,
}

impl RasterTarget {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let view = |label, format, usage| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let (nearest, depth) = gpu.with_error_scope(|| {
            let nearest = view("nearest", NEAREST, wgpu::TextureUsages::TEXTURE_BINDING);
            let depth = view("depth", DEPTH, wgpu::TextureUsages::empty());
            (nearest, depth)
        })?;
        Ok(Self {
            size,
            nearest,
            depth,
            bound: Mutex::default(),
        })
    }
}

/// Triangles, and what they are drawn on.
struct RasterOutput<'a> {
    pass: &'a RasterPass,
    mesh: &'a GpuMesh,
    target: &'a RasterTarget,
}

impl Drawing for RasterOutput<'_> {
    fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (frames, offset): (&wgpu::Buffer, u32),
        timing: Option<&mut Timing>,
    ) {
        let (mesh, target) = (self.mesh, self.target);
        let mut bound = target.bound.lock().unwrap_or_else(PoisonError::into_inner);
        let same = bound.take().filter(|(buffer, _)| buffer == frames);
        let (_, group) = bound.insert(same.unwrap_or_else(|| {
            let frame = BoundResource::Buffer(
                FRAME,
                frames.clone(),
                Some(size_of::<FrameUniform>() as u64),
            );
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Triangles"),
                layout: &self.pass.layout,
                entries: &[frame.entry()],
            });
            (frames.clone(), group)
        }));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("Triangles"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.nearest,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timing.and_then(|timing| timing.next_render()),
            ..wgpu::RenderPassDescriptor::default()
        });
        if let Some(vertices) = mesh.vertices.buffer()
            && mesh.triangles > 0
        {
            pass.set_pipeline(&self.pass.pipeline);
            pass.set_bind_group(0, &*group, &[offset]);
            pass.set_vertex_buffer(0, vertices.slice(..));
            match mesh.indices.as_ref().and_then(StorageBuffer::buffer) {
                Some(indices) => {
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..3 * mesh.triangles, 0, 0..1);
                }
                None => pass.draw(0..3 * mesh.triangles, 0..1),
            }
        }
    }
}

/// What draws triangles.
struct RasterPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl RasterPass {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let (layout, pipeline) = gpu.with_error_scope(|| pipeline(gpu))?;
        Ok(Self { layout, pipeline })
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
                    has_dynamic_offset: true,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
    let source = [&argil_abi::wgsl(), FRAME_WGSL, wgsl::RASTER_DRAW].concat();
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
    gpu.counters.pipelines.add(1);
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
            // Counterclockwise as seen from outside. Nothing is culled, because the eye may be inside.
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
            cache: gpu.pipeline_cache(),
        });
    (layout, pipeline)
}
