//! Pipelines and the bindings that all of them share.

use crate::{Gpu, GpuError};

/// Where each table is bound; the shader's text below says the same.
pub(crate) const FRAME: u32 = 0;
pub(crate) const INSTRS: u32 = 1;
pub(crate) const PARAMS: u32 = 2;
pub(crate) const MATERIALS: u32 = 3;
pub(crate) const HITS: u32 = 4;
pub(crate) const COLORS: u32 = 5;
pub(crate) const QUERIES: u32 = 6;
pub(crate) const ANSWERS: u32 = 7;
pub(crate) const VOLUME: u32 = 8;
pub(crate) const STORED: u32 = 9;
pub(crate) const LINEAR: u32 = 10;
pub(crate) const NODES: u32 = 11;
pub(crate) const TREE_WORDS: u32 = 12;
pub(crate) const FILL: u32 = 13;
pub(crate) const TEXELS: u32 = 14;
pub(crate) const OCCUPIED: u32 = 15;
pub(crate) const CENTERS: u32 = 16;
pub(crate) const KEYS: u32 = 17;
pub(crate) const ARGUMENTS: u32 = 18;
pub(crate) const CELLS: u32 = 19;
pub(crate) const BRICK_MATERIALS: u32 = 20;
pub(crate) const CANDIDATES: u32 = 21;
pub(crate) const COUNTERS: u32 = 22;
pub(crate) const LIVE: u32 = 23;
pub(crate) const LISTS: u32 = 24;
pub(crate) const PRUNE: u32 = 25;
pub(crate) const OLD_MATERIALS: u32 = 26;
pub(crate) const OLD_POOL: u32 = 27;
pub(crate) const DRAWN: u32 = 28;
pub(crate) const MARCHING: u32 = 29;
pub(crate) const CASES: u32 = 30;
pub(crate) const OWNERS: u32 = 31;
pub(crate) const UNITS: u32 = 32;
pub(crate) const UNIT_GROUPS: u32 = 33;
pub(crate) const EDGE_ROWS: u32 = 34;
pub(crate) const VERTICES: u32 = 35;
pub(crate) const TRIANGLES: u32 = 36;
pub(crate) const SPANS: u32 = 37;
pub(crate) const SPREAD: u32 = 38;

pub(crate) const TABLES_WGSL: &str = "
@group(0) @binding(1) var<storage, read> instrs: array<Instr>;
@group(0) @binding(2) var<storage, read> params: array<f32>;
@group(0) @binding(3) var<storage, read> materials: array<MaterialWords>;
";

pub(crate) const FRAME_WGSL: &str = "
@group(0) @binding(0) var<uniform> frame: Frame;
";

pub(crate) const PICTURE_WGSL: &str = "
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
@group(0) @binding(5) var<storage, read_write> colors: array<vec4<f32>>;
";

pub(crate) const QUERY_WGSL: &str = "
@group(0) @binding(6) var<storage, read> queries: array<Query>;
@group(0) @binding(7) var<storage, read_write> answers: array<Answer>;
";

pub(crate) const VOLUME_WGSL: &str = "
@group(0) @binding(8) var<uniform> volume: Volume;
@group(0) @binding(9) var stored: texture_3d<f32>;
@group(0) @binding(10) var linear: sampler;
";

pub(crate) const TREE_WGSL: &str = "
@group(0) @binding(11) var<storage, read> nodes: array<Node>;
@group(0) @binding(12) var<storage, read> tree_words: array<u32>;
";

pub(crate) const CELLS_WGSL: &str = "
@group(0) @binding(19) var<storage, read> cells: array<u32>;
@group(0) @binding(20) var<storage, read> brick_materials: array<u32>;
// Of each block of pixels its cone; and a list of those that are left.
struct PixelBlock {
    begin: f32,
    steps: u32,
    place: u32,
    spare: u32,
}
struct Live {
    groups_x: atomic<u32>,
    groups_y: u32,
    groups_z: u32,
    spare: u32,
    blocks: array<PixelBlock>,
}
@group(0) @binding(23) var<storage, read_write> live: Live;
";

pub(crate) const DRAWN_WGSL: &str = "
@group(0) @binding(28) var drawn: texture_2d<f32>;
";

/// What a shader does with a binding.
#[derive(Clone, Copy)]
pub(crate) enum Bind {
    Uniform(u32),
    Read(u32),
    Write(u32),
    /// A 3D texture to be filtered.
    Texture(u32),
    Filter(u32),
    /// A picture whose texels are read as they are.
    Picture(u32),
    /// A 3D texture to be written.
    Target(u32, wgpu::TextureFormat),
}

/// The tables of a field.
pub(crate) const FIELD_BINDS: [Bind; 3] = [
    Bind::Read(INSTRS),
    Bind::Read(PARAMS),
    Bind::Read(MATERIALS),
];

/// A layout of the given bindings.
pub(crate) fn layout(gpu: &Gpu, label: &str, binds: &[Bind]) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let entries: Vec<_> = binds
        .iter()
        .map(|bind| {
            let (binding, ty) = match *bind {
                Bind::Uniform(at) => (at, buffer(wgpu::BufferBindingType::Uniform)),
                Bind::Read(at) => (at, storage(true)),
                Bind::Write(at) => (at, storage(false)),
                Bind::Texture(at) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D3,
                        multisampled: false,
                    };
                    (at, ty)
                }
                Bind::Picture(at) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: false },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    };
                    (at, ty)
                }
                Bind::Filter(at) => {
                    let ty = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
                    (at, ty)
                }
                Bind::Target(at, format) => {
                    let ty = wgpu::BindingType::StorageTexture {
                        access: wgpu::StorageTextureAccess::WriteOnly,
                        format,
                        view_dimension: wgpu::TextureViewDimension::D3,
                    };
                    (at, ty)
                }
            };
            wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count: None,
            }
        })
        .collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
}

/// A whole buffer as a binding.
pub(crate) fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}

/// One pipeline for each entry point of a module.
pub(crate) fn pipelines<const N: usize>(
    gpu: &Gpu,
    source: String,
    layout: &wgpu::BindGroupLayout,
    constants: &[(&str, f64)],
    entry_points: [&str; N],
) -> Result<[wgpu::ComputePipeline; N], GpuError> {
    gpu.checked(|| {
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("argil"),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("argil"),
                bind_group_layouts: &[Some(layout)],
                immediate_size: 0,
            });
        entry_points.map(|entry_point| {
            gpu.device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(entry_point),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants,
                        ..Default::default()
                    },
                    cache: None,
                })
        })
    })
}
