//! Moves bricks from one pool to another.

use super::build_tables::BrickTargets;
use super::cells::GpuCellTable;
use super::tables::march_words;
use crate::bindings::{
    BRICK_MATERIALS, Bind, CELLS, COUNTERS, OLD_MATERIALS, OLD_POOL, STORED, TEXELS, VOLUME, entry,
};
use crate::pass_module::{PassModule, Passes};
use crate::resources::uniform_of;
use crate::texel_format::TexelFormat;
use crate::{Gpu, GpuError};
use argil_abi::{self as abi, BrickUniform};
use argil_volume::{BrickLayout, SampleFormat, wgsl};

/// The bindings, as the shader names them.
const BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickUniform;
@group(0) @binding(BIND_STORED) var old_texels: texture_3d<f32>;
@group(0) @binding(BIND_CELLS) var<storage, read_write> cells: array<u32>;
@group(0) @binding(BIND_BRICK_MATERIALS) var<storage, read_write> brick_materials: array<u32>;
@group(0) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
@group(0) @binding(BIND_OLD_MATERIALS) var<storage, read> old_materials: array<u32>;
@group(0) @binding(BIND_OLD_POOL) var<uniform> old: Repack;
";

/// Describes the pass for a texel format.
pub(crate) fn repack_module(texels: TexelFormat) -> PassModule {
    let target = format!(
        "@group(0) @binding(BIND_TEXELS) var texels: texture_storage_3d<{}, write>;\n",
        texels.wgsl()
    );
    let source = [
        &argil_abi::wgsl(),
        BINDS_WGSL,
        &target,
        wgsl::BRICK_CELLS,
        wgsl::BRICK_REPACK,
    ];
    let binds = vec![
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Target(TEXELS, texels.format()),
        Bind::Write(CELLS),
        Bind::Write(BRICK_MATERIALS),
        Bind::Write(COUNTERS),
        Bind::Read(OLD_MATERIALS),
        Bind::Uniform(OLD_POOL),
    ];
    PassModule::new("Bricks::repack", &source, binds, &[], &["repack"])
}

/// The pass on a device.
pub(crate) struct RepackPass(Passes);

impl RepackPass {
    pub(super) fn new(gpu: &Gpu, bits: SampleFormat) -> Result<Self, GpuError> {
        Passes::new(gpu, repack_module(gpu.texels(bits))).map(Self)
    }

    /// Encodes a pass that moves all bricks from one pool to another, and updates the cells.
    pub(super) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (measures, cells): (&BrickLayout, &GpuCellTable),
        [from, to]: [[u32; 3]; 2],
        old: &BrickTargets<'_>,
        new: &BrickTargets<'_>,
    ) -> Result<(), GpuError> {
        let words = march_words(measures, cells, to, 1.0);
        let before = [from[0], from[1], from.iter().product(), 0];
        let [old_view, view] = [old.texture, new.texture]
            .map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let repack = self.0.get(gpu, "repack")?;
        gpu.with_error_scope(|| {
            let volume = uniform_of::<BrickUniform>(gpu, "volume");
            let old_pool = uniform_of::<[u32; 4]>(gpu, "the pool before");
            gpu.write_buffer(&volume, 0, bytemuck::bytes_of(&words));
            gpu.write_buffer(&old_pool, 0, bytemuck::bytes_of(&before));
            let texture = |binding, view| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::TextureView(view),
            };
            let mut entries = vec![
                entry(VOLUME, &volume),
                entry(OLD_POOL, &old_pool),
                texture(STORED, &old_view),
                texture(TEXELS, &view),
            ];
            entries.extend(new.cells.binding(CELLS));
            entries.extend(new.materials.binding(BRICK_MATERIALS));
            entries.extend(new.counters.binding(COUNTERS));
            entries.extend(old.materials.binding(OLD_MATERIALS));
            let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Bricks::repack"),
                layout: &self.0.layout,
                entries: &entries,
            });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(repack);
            pass.set_bind_group(0, &bind_group, &[]);
            let blocks = cells.table.slots() as u32;
            let rows = blocks.div_ceil(abi::DISPATCH_ROW);
            pass.dispatch_workgroups(blocks.min(abi::DISPATCH_ROW), rows, 1);
        })
    }
}
