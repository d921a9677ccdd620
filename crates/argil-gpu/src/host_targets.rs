//! The targets of a host's render pass, and the pipeline that draws into them.

use crate::Gpu;
use argil_render::wgsl;

/// The bindings, as the shader names them.
const BINDS_WGSL: &str = "
@group(0) @binding(0) var<uniform> frame: FrameUniform;
@group(0) @binding(1) var<uniform> host_view: HostView;
@group(0) @binding(2) var<storage, read> hits: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> motions: array<vec4<f32>>;
";

/// The targets of a host's render pass. Its color attachments are the color, the normal and the motion, those that there are, in this
/// order.
#[derive(Clone, Debug, PartialEq)]
pub struct HostTargets {
    /// The format of colors. Formats with sRGB and with floats take linear colors, others sRGB.
    pub color: wgpu::TextureFormat,
    /// The format of normals in the world. Formats from 0 to 1 take half of each coordinate plus 0.5, others the coordinates.
    pub normal: Option<wgpu::TextureFormat>,
    /// The format of how far points went in the image since the frame before, in x and y, as a part of the image, with y down. It has
    /// the camera's motion. In worlds of bricks and levels, it also has that of brushes that edits moved, turned or scaled.
    pub motion: Option<wgpu::TextureFormat>,
    /// The depth buffer, with the host's comparison: `Less`, or `Greater` where depth is reversed.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Samples of each pixel of the targets.
    pub sample_count: u32,
}

impl HostTargets {
    /// Returns targets of a color alone, with one sample of each pixel.
    pub fn new(color: wgpu::TextureFormat) -> Self {
        Self {
            color,
            normal: None,
            motion: None,
            depth: None,
            sample_count: 1,
        }
    }

    /// Whether what is nearer has a greater depth, by the comparison of the depth buffer.
    pub(crate) fn is_reversed(&self) -> bool {
        use wgpu::CompareFunction as Compare;
        let compare = self.depth.as_ref().and_then(|depth| depth.depth_compare);
        matches!(compare, Some(Compare::Greater | Compare::GreaterEqual))
    }

    /// Whether colors are linear.
    pub(crate) fn takes_linear(&self) -> bool {
        use wgpu::TextureFormat as Format;
        let is_float = matches!(
            self.color,
            Format::Rgba16Float | Format::Rgba32Float | Format::Rg11b10Ufloat
        );
        is_float || self.color.is_srgb()
    }

    /// Compiles what draws a frame.
    pub(crate) fn pipeline(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
    ) -> wgpu::RenderPipeline {
        let name = "HostFrame";
        let source = [
            &argil_abi::wgsl(),
            BINDS_WGSL,
            wgsl::HIT_RECORDS,
            wgsl::CAMERA,
            wgsl::COMPOSITE,
        ]
        .concat();
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(name),
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            });
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
        let entry_point = match self.depth {
            Some(_) => "with_depth",
            None => "without_depth",
        };
        let all = [Some(self.color), self.normal, self.motion];
        let attachments: Vec<_> = all
            .into_iter()
            .flatten()
            .map(|format| Some(format.into()))
            .collect();
        let are_unsigned = self.normal.is_some_and(is_unsigned);
        gpu.counters.pipelines.add(1);
        gpu.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(name),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("cover"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: self.depth.clone(),
                multisample: wgpu::MultisampleState {
                    count: self.sample_count,
                    ..Default::default()
                },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[
                            ("HOST_RAYS", 1.0),
                            ("HAS_NORMALS", f64::from(u8::from(self.normal.is_some()))),
                            ("ARE_UNSIGNED", f64::from(u8::from(are_unsigned))),
                        ],
                        ..Default::default()
                    },
                    targets: &attachments,
                }),
                multiview_mask: None,
                cache: gpu.pipeline_cache(),
            })
    }
}

/// Whether a format stores numbers from 0 to 1.
fn is_unsigned(format: wgpu::TextureFormat) -> bool {
    use wgpu::TextureFormat as Format;
    matches!(
        format,
        Format::R8Unorm
            | Format::Rg8Unorm
            | Format::Rgba8Unorm
            | Format::Bgra8Unorm
            | Format::Rgba8UnormSrgb
            | Format::Bgra8UnormSrgb
            | Format::R16Unorm
            | Format::Rg16Unorm
            | Format::Rgba16Unorm
            | Format::Rgb10a2Unorm
    )
}
