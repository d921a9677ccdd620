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

pub(crate) const TABLES_WGSL: &str = "
@group(0) @binding(1) var<storage, read> instrs: array<Instr>;
@group(0) @binding(2) var<storage, read> params: array<f32>;
@group(0) @binding(3) var<storage, read> materials: array<MaterialWords>;
";

pub(crate) const PICTURE_WGSL: &str = "
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
@group(0) @binding(5) var<storage, read_write> colors: array<vec4<f32>>;
";

pub(crate) const QUERY_WGSL: &str = "
@group(0) @binding(6) var<storage, read> queries: array<Query>;
@group(0) @binding(7) var<storage, read_write> answers: array<Answer>;
";

/// A layout of the given bindings.
pub(crate) fn layout(gpu: &Gpu, label: &str, bindings: &[u32]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = bindings
        .iter()
        .map(|&binding| {
            let ty = match binding {
                FRAME => wgpu::BufferBindingType::Uniform,
                HITS | COLORS | ANSWERS => wgpu::BufferBindingType::Storage { read_only: false },
                _ => wgpu::BufferBindingType::Storage { read_only: true },
            };
            wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
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

/// One pipeline for each entry point of a module.
pub(crate) fn pipelines<const N: usize>(
    gpu: &Gpu,
    source: String,
    layout: &wgpu::BindGroupLayout,
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
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
        })
    })
}
