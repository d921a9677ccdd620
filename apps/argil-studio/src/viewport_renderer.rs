//! Draws the images of the viewport and the grid in the window's device.

use crate::render_request::{Pixels, WorkerImage};
use crate::texture_pool::TexturePool;
use crate::viewport_camera::ViewportCamera;
use argil::glam::{Vec2, Vec3};
use argil::gpu::{GpuError, ImageTextures, wgpu};
use eframe::egui::{self, Color32, Rect};
use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use std::sync::Arc;

/// Maximum number of lines.
const MAX_LINES: usize = 256;

/// A line of the grid, as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct GridLine {
    ends: [[f32; 3]; 2],
    /// Premultiplied.
    color: [f32; 4],
}

impl GridLine {
    pub(crate) fn new(ends: [Vec3; 2], color: Color32) -> Self {
        Self {
            ends: ends.map(|end| end.to_array()),
            color: color.to_array().map(|byte| f32::from(byte) / 255.0),
        }
    }
}

/// What the shader reads of the view.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct ViewUniform {
    eye: [f32; 3],
    reach: f32,
    right: [f32; 3],
    focal: f32,
    up: [f32; 3],
    divider: f32,
    forward: [f32; 3],
    shows_difference: u32,
    size: [f32; 2],
    half_width: f32,
    padding: f32,
}

/// One image, or two to compare, ready to be drawn.
pub(crate) struct ShownTextures {
    group: wgpu::BindGroup,
    /// Nothing is rendered into them while they are shown.
    _images: [Arc<ImageTextures>; 2],
}

/// The pipelines, and what they read.
pub(crate) struct ViewportRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    image: wgpu::RenderPipeline,
    grid: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    view: wgpu::Buffer,
    lines: wgpu::Buffer,
}

impl ViewportRenderer {
    /// Compiles the pipelines for a window.
    pub(crate) fn new(state: &RenderState) -> Self {
        let device = &state.device;
        let layout = layout(device);
        let module = device.create_shader_module(wgpu::include_wgsl!("viewport.wgsl"));
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("viewport"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let line = wgpu::VertexBufferLayout {
            array_stride: size_of::<GridLine>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4],
        };
        let pipeline = |[vertex, fragment]: [&str; 2], buffers: &[Option<_>], topology| {
            let takes_linear = f64::from(u8::from(state.target_format.is_srgb()));
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState {
                    topology,
                    ..Default::default()
                },
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("TAKES_LINEAR", takes_linear)],
                        ..Default::default()
                    },
                    targets: &[Some(wgpu::ColorTargetState {
                        format: state.target_format,
                        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        use wgpu::PrimitiveTopology as Topology;
        Self {
            image: pipeline(["cover", "image"], &[], Topology::TriangleList),
            grid: pipeline(["line", "grid"], &[Some(line)], Topology::TriangleStrip),
            sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("viewport"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            view: buffer(
                device,
                size_of::<ViewUniform>(),
                wgpu::BufferUsages::UNIFORM,
            ),
            lines: buffer(
                device,
                MAX_LINES * size_of::<GridLine>(),
                wgpu::BufferUsages::VERTEX,
            ),
            device: state.device.clone(),
            queue: state.queue.clone(),
            layout,
        }
    }

    /// Returns a pool of textures on the window's device.
    pub(crate) fn pool(&self) -> TexturePool {
        TexturePool::new(self.device.clone())
    }

    /// Prepares images, and uploads those that were rendered on the CPU.
    ///
    /// # Errors
    /// If an image is too large for the device.
    pub(crate) fn show(
        &self,
        images: &[WorkerImage],
        pool: &mut TexturePool,
    ) -> Result<Option<Arc<ShownTextures>>, GpuError> {
        let mut textures = Vec::new();
        for image in images {
            textures.push(match &image.pixels {
                Pixels::Gpu(textures_of_image) => textures_of_image.clone(),
                Pixels::Cpu { rgb, lengths } => {
                    let uploaded = pool.take(image.size)?;
                    self.upload(&uploaded, rgb, lengths);
                    uploaded
                }
            });
        }
        let (Some(first), Some(second)) = (textures.first(), textures.last()) else {
            return Ok(None);
        };
        let all = [first.clone(), second.clone()];
        let colors = all
            .each_ref()
            .map(|texture| texture.color().create_view(&Default::default()));
        let distances = all
            .each_ref()
            .map(|image| image.distance().create_view(&Default::default()));
        let mut resources = vec![
            self.view.as_entire_binding(),
            wgpu::BindingResource::Sampler(&self.sampler),
        ];
        let views = colors.iter().chain(&distances);
        resources.extend(views.map(wgpu::BindingResource::TextureView));
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("viewport"),
            layout: &self.layout,
            entries: &entries,
        });
        Ok(Some(Arc::new(ShownTextures {
            group,
            _images: all,
        })))
    }

    fn upload(&self, textures: &ImageTextures, rgb: &[u8], lengths: &[f32]) {
        let pixels = rgb.as_chunks::<3>().0.iter();
        let colors: Vec<u8> = pixels.flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        for (texture, bytes) in [
            (textures.color(), &colors[..]),
            (textures.distance(), bytemuck::cast_slice(lengths)),
        ] {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * textures.size()[0]),
                rows_per_image: None,
            };
            self.queue
                .write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        }
    }
}

fn buffer(device: &wgpu::Device, bytes: usize, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("viewport"),
        size: bytes as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let texture = |filterable| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let all = [
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        texture(true),
        texture(true),
        texture(false),
        texture(false),
    ];
    let entries: Vec<_> = (0..)
        .zip(all)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("viewport"),
        entries: &entries,
    })
}

/// What is drawn into the viewport in one frame of the window.
pub(crate) struct ViewportPaint {
    pub renderer: Arc<ViewportRenderer>,
    pub shown: Arc<ShownTextures>,
    pub camera: ViewportCamera,
    pub divider: f32,
    pub shows_difference: bool,
    /// Size in points.
    pub size: Vec2,
    pub lines: Vec<GridLine>,
}

impl ViewportPaint {
    /// Returns a shape for a rectangle.
    pub(crate) fn into_shape(self, rect: Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect, self).into()
    }

    fn uniform(&self, pixels_per_point: f32) -> ViewUniform {
        let camera = self.camera.camera();
        let [right, up] = self.camera.axes();
        let size = self.size * pixels_per_point;
        let half = (0.5 * camera.field_of_view_degrees.to_radians()).tan();
        ViewUniform {
            eye: camera.eye.to_array(),
            reach: self.camera.distance,
            right: right.to_array(),
            focal: 0.5 * size.y / half,
            up: up.to_array(),
            divider: self.divider,
            forward: (-self.camera.backward()).to_array(),
            shows_difference: self.shows_difference.into(),
            size: size.to_array(),
            half_width: 0.5 * pixels_per_point,
            padding: 0.0,
        }
    }

    fn shown_lines(&self) -> &[GridLine] {
        &self.lines[..self.lines.len().min(MAX_LINES)]
    }
}

impl CallbackTrait for ViewportPaint {
    fn prepare(
        &self,
        _: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        _: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let renderer = &self.renderer;
        let view = self.uniform(screen.pixels_per_point);
        queue.write_buffer(&renderer.view, 0, bytemuck::bytes_of(&view));
        queue.write_buffer(&renderer.lines, 0, bytemuck::cast_slice(self.shown_lines()));
        Vec::new()
    }

    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &CallbackResources,
    ) {
        let renderer = &self.renderer;
        pass.set_bind_group(0, &self.shown.group, &[]);
        pass.set_pipeline(&renderer.image);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&renderer.grid);
        pass.set_vertex_buffer(0, renderer.lines.slice(..));
        pass.draw(0..4, 0..self.shown_lines().len() as u32);
    }
}
