//! The host's own renderer: triangles with a light from above, and a depth buffer that is reversed.

use super::carving::Carving;
use argil::glam::Vec3;
use argil::glam::camera::rh::proj::directx;
use argil::glam::camera::rh::view::look_at_mat4;
use argil::gpu::{Gpu, HostTargets, wgpu};
use argil::mesh::Mesh;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SHADER: &str = "
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
struct Corner { @builtin(position) position: vec4<f32>, @location(0) normal: vec3<f32> }
@vertex fn corner(@location(0) p: vec3<f32>, @location(1) n: vec3<f32>) -> Corner {
    return Corner(clip_from_world * vec4(p, 1.0), n);
}
@fragment fn lit(corner: Corner) -> @location(0) vec4<f32> {
    let light = 0.55 + 0.45 * normalize(corner.normal).y;
    return vec4(vec3(0.75, 0.3, 0.15) * light, 1.0);
}
";

fn depth() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Greater),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// The renderer.
pub(crate) struct Renderer {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    vertices: wgpu::Buffer,
    count: u32,
    matrix: wgpu::Buffer,
    group: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
    depth: wgpu::TextureView,
}

impl Renderer {
    /// Opens a device with what the engine needs, for a surface if there is one, and uploads triangles.
    pub(crate) fn new(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        mesh: &Mesh,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let asked = instance.request_adapter(&wgpu::RequestAdapterOptions {
            compatible_surface: surface,
            ..Default::default()
        });
        let adapter = pollster::block_on(asked)?;
        let formats =
            surface.map(|surface_formats| surface_formats.get_capabilities(&adapter).formats);
        let format = formats
            .iter()
            .flatten()
            .find(|candidate| candidate.is_srgb());
        let format = *format.unwrap_or(&wgpu::TextureFormat::Rgba8UnormSrgb);
        let wished = adapter.features() & Gpu::wished_features();
        let opened = adapter.request_device(&wgpu::DeviceDescriptor {
            required_features: Gpu::required_features() | wished,
            required_limits: Gpu::required_limits(&adapter),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(opened)?;
        let corners = mesh.triangles.iter().flatten().map(|&i| i as usize);
        let corners: Vec<[Vec3; 2]> = corners
            .map(|i| [mesh.positions[i] * 0.4 - 0.2 * Vec3::Y, mesh.normals[i]])
            .collect();
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&BufferInitDescriptor {
                label: None,
                contents,
                usage,
            })
        };
        let vertices = buffer(bytemuck::cast_slice(&corners), wgpu::BufferUsages::VERTEX);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let matrix = buffer(&[0; 64], usage);
        let pipeline = pipeline(&device, format);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: matrix.as_entire_binding(),
            }],
        });
        let depth = target(&device, [1, 1], DEPTH).create_view(&Default::default());
        Ok(Self {
            device,
            queue,
            size: [1, 1],
            format,
            vertices,
            count: corners.len() as u32,
            matrix,
            group,
            pipeline,
            depth,
        })
    }

    /// Takes targets of another size from now on.
    pub(crate) fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
        self.depth = target(&self.device, size, DEPTH).create_view(&Default::default());
    }

    /// Returns what the engine needs to know of the render pass.
    pub(crate) fn targets(&self) -> HostTargets {
        HostTargets {
            depth: Some(depth()),
            ..HostTargets::new(self.format)
        }
    }

    pub(crate) fn format(&self) -> wgpu::TextureFormat {
        self.format
    }

    /// Creates a target that can be downloaded.
    pub(crate) fn target(&self) -> wgpu::Texture {
        target(&self.device, self.size, self.format)
    }

    /// Returns the projection times the view, from an angle.
    fn clip_from_world(&self, angle: f32) -> [[f32; 4]; 4] {
        let aspect = self.size[0] as f32 / self.size[1] as f32;
        let projection = directx::perspective_infinite_reverse(0.7, aspect, 0.1);
        let eye = Vec3::new(4.0 * angle.sin(), 2.4, 4.0 * angle.cos());
        (projection * look_at_mat4(eye, Vec3::ZERO, Vec3::Y)).to_cols_array_2d()
    }

    /// Draws a frame into a view of the color format, from an angle: the triangles and then the guest's world, by one submission.
    pub(crate) fn draw(
        &mut self,
        color: &wgpu::TextureView,
        angle: f32,
        guest: &mut Carving,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let clip_from_world = self.clip_from_world(angle);
        let matrix = bytemuck::bytes_of(&clip_from_world);
        self.queue.write_buffer(&self.matrix, 0, matrix);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        guest.encode(self.size, clip_from_world, &mut encoder)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color {
                        r: 0.1,
                        g: 0.13,
                        b: 0.18,
                        a: 1.0,
                    }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.count, 0..1);
        guest.composite(&mut pass);
        drop(pass);
        self.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Downloads a target.
    pub(crate) fn picture(
        &self,
        target: &wgpu::Texture,
    ) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
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
        let pixels = rows.flat_map(|row| row[..4 * width as usize].chunks_exact(4));
        Ok(pixels.flat_map(|pixel| pixel[..3].to_vec()).collect())
    }
}

fn target(
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

fn pipeline(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 24,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
            })],
        },
        primitive: Default::default(),
        depth_stencil: Some(depth()),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
