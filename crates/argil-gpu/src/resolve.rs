//! Converts a frame's colors to bytes, and counts what its rays did.

use crate::bindings::{
    Bind, COLORS, COUNTS, FRAME, FRAME_WGSL, HITS, PICTURE_WGSL, PIXELS, layout, pipelines,
};
use crate::{Gpu, GpuError};
use argil_render::wgsl;

const RESOLVE_WGSL: &str = "
@group(0) @binding(BIND_PIXELS) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(BIND_COUNTS) var<storage, read_write> counts: array<atomic<u32>>;
";

/// The last passes of a frame, for any representation.
pub(crate) struct ResolvePass {
    pub layout: wgpu::BindGroupLayout,
    pub count: wgpu::ComputePipeline,
    pub resolve: wgpu::ComputePipeline,
}

impl ResolvePass {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let source = [
            &argil_abi::wgsl(),
            FRAME_WGSL,
            PICTURE_WGSL,
            RESOLVE_WGSL,
            wgsl::RESOLVE_SAMPLES,
        ]
        .concat();
        let binds = [
            Bind::Uniforms(FRAME),
            Bind::Write(HITS),
            Bind::Write(COLORS),
            Bind::Write(PIXELS),
            Bind::Write(COUNTS),
        ];
        let layout = gpu.with_error_scope(|| layout(gpu, "Resolve", &binds))?;
        let [count, resolve] = pipelines(gpu, source, &layout, &[], ["count", "resolve"])?;
        Ok(Self {
            layout,
            count,
            resolve,
        })
    }
}
