//! The passes that build all bricks or some, compiled once for a program and a sample format.

use super::build_tables::{BrickTargets, EditScratch};
use super::repack::RepackPass;
use crate::bindings::{
    ARGUMENTS, BRICK_MATERIALS, Bind, CANDIDATES, CELLS, COUNTERS, FIELD_BINDS, FILL, LISTS, PRUNE,
    TABLES_WGSL, TEXELS, VOLUME, entry, layout, pipelines,
};
use crate::pass_recorder::{DispatchSize, PassRecorder};
use crate::program::check_depth;
use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::{GpuError, GpuProgram};
use argil_abi::{self as abi, BrickBuildUniform, FillUniform, PruneUniform};
use argil_field::Program;
use argil_volume::{BrickLayout, SampleFormat, wgsl};
use std::sync::Arc;

/// Maximum instructions times samples per dispatch.
const WORK_PER_DISPATCH: u64 = 4_000_000_000;
/// Maximum bricks that one dispatch samples.
const MAX_BRICKS_PER_DISPATCH: u64 = 32_768;
/// Threads that sample a brick.
const BRICK_GROUP: u32 = 256;

/// The cost of pruning, in evaluations.
const EVALUATIONS_TO_PRUNE: u64 = 4;

/// The bindings, as the shader names them.
const BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickBuildUniform;
@group(0) @binding(BIND_ARGUMENTS) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(BIND_CELLS) var<storage, read_write> cells: array<u32>;
@group(0) @binding(BIND_BRICK_MATERIALS) var<storage, read_write> brick_materials: array<u32>;
@group(0) @binding(BIND_CANDIDATES) var<storage, read_write> near_cells: array<u32>;
@group(0) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
@group(0) @binding(BIND_LISTS) var<storage, read_write> lists: array<u32>;
@group(0) @binding(BIND_PRUNE) var<uniform> prune: PruneUniform;
";

/// The passes that build bricks.
pub(crate) struct BrickPasses {
    layout: wgpu::BindGroupLayout,
    plan_layout: wgpu::BindGroupLayout,
    begin_lists: wgpu::ComputePipeline,
    prune_cells: wgpu::ComputePipeline,
    measure: wgpu::ComputePipeline,
    plan: wgpu::ComputePipeline,
    fill_bricks: wgpu::ComputePipeline,
    fill_materials: wgpu::ComputePipeline,
    mark_empty_blocks: wgpu::ComputePipeline,
    release_freed: wgpu::ComputePipeline,
    /// Moves bricks from one pool to another.
    pub(super) repack: RepackPass,
}

impl BrickPasses {
    /// Returns the passes for a program and a sample format, and compiles them when first asked for.
    pub(super) fn of(field: &GpuProgram, bits: SampleFormat) -> Result<Arc<Self>, GpuError> {
        let name = match bits {
            SampleFormat::Snorm8 => "bricks of 8 bits",
            SampleFormat::Snorm16 => "bricks of 16 bits",
        };
        field.passes(name, || Self::new(field, bits))
    }

    pub(super) fn new(field: &GpuProgram, bits: SampleFormat) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let source = [
            &argil_abi::wgsl(),
            TABLES_WGSL,
            &crate::dense::target_wgsl(gpu.texels(bits)),
            BINDS_WGSL,
            &field.opcodes.pruning_wgsl(),
            wgsl::BAKE_LEVEL,
            wgsl::BRICK_CELLS,
            wgsl::BRICK_MATERIALS,
            wgsl::BRICK_BUILD,
        ]
        .concat();
        let mut binds = FIELD_BINDS.to_vec();
        binds.extend([
            Bind::Uniform(VOLUME),
            Bind::Uniform(FILL),
            Bind::Target(TEXELS, gpu.texels(bits).format()),
            Bind::Write(CELLS),
            Bind::Write(CANDIDATES),
            Bind::Write(COUNTERS),
            Bind::Write(BRICK_MATERIALS),
            Bind::Write(LISTS),
            Bind::Uniform(PRUNE),
        ]);
        let layout = gpu.with_error_scope(|| self::layout(gpu, "Bricks::make", &binds))?;
        let constants = [("BRICK_GROUP", f64::from(BRICK_GROUP))];
        let entry_points = [
            "begin_lists",
            "measure",
            "fill_bricks",
            "fill_materials",
            "mark_empty_blocks",
            "release_freed",
        ];
        let [
            begin_lists,
            measure,
            fill_bricks,
            fill_materials,
            mark_empty_blocks,
            release_freed,
        ] = pipelines(gpu, source.clone(), &layout, &constants, entry_points)?;
        let marking = [constants[0], ("MARKING", 1.0)];
        let [prune_cells] = pipelines(gpu, source.clone(), &layout, &marking, ["prune_cells"])?;
        // An indirect dispatch's arguments must not be bound in the same pass.
        let binds = [
            Bind::Uniform(VOLUME),
            Bind::Write(ARGUMENTS),
            Bind::Write(COUNTERS),
        ];
        let plan_layout = gpu.with_error_scope(|| self::layout(gpu, "Bricks::plan", &binds))?;
        let [plan] = pipelines(gpu, source, &plan_layout, &[], ["plan"])?;
        Ok(Self {
            layout,
            plan_layout,
            begin_lists,
            prune_cells,
            measure,
            plan,
            fill_bricks,
            fill_materials,
            mark_empty_blocks,
            release_freed,
            repack: RepackPass::new(gpu, bits)?,
        })
    }
}

/// Refuses a program whose loops the device would cut short.
pub(super) fn check(
    field: &GpuProgram,
    program: &Program,
    layout: &BrickLayout,
) -> Result<(), GpuError> {
    check_depth(program)?;
    let samples = u64::from(layout.brick_samples());
    let each = samples
        .div_ceil(u64::from(BRICK_GROUP))
        .max(EVALUATIONS_TO_PRUNE);
    if u64::from(field.budget) < each {
        return Err(GpuError::TooLong {
            name: field.gpu().info.name.clone(),
            iterations: u64::from(field.budget),
            limit: each,
        });
    }
    Ok(())
}

/// Returns how many of `cells` a dispatch samples with lists of a length, and the number of dispatches.
pub(super) fn chunks(layout: &BrickLayout, length: usize, cells: u64) -> [u32; 2] {
    let work = u64::from(layout.brick_samples()) * length as u64;
    let chunk = (WORK_PER_DISPATCH / work.max(1)).clamp(64, MAX_BRICKS_PER_DISPATCH);
    [chunk as u32, cells.div_ceil(chunk) as u32]
}

/// What to build.
pub(super) struct BuildParams<'a> {
    pub words: BrickBuildUniform,
    pub fill: FillUniform,
    /// The blocks, and the positions of their lists.
    pub prune: PruneUniform,
    /// The instructions of the lists.
    pub instructions: &'a StorageBuffer,
    /// Number of instructions.
    pub length: usize,
    /// Whether there is more than one material.
    pub mixes: bool,
}

/// Returns workgroups in rows.
fn rows(groups: u32) -> DispatchSize<'static> {
    DispatchSize::Direct([
        groups.min(abi::DISPATCH_ROW),
        groups.div_ceil(abi::DISPATCH_ROW),
        1,
    ])
}

/// Returns the bind groups of a build, and the size of its plan.
fn groups_of(
    field: &GpuProgram,
    scratch: &EditScratch,
    site: &BrickTargets<'_>,
    order: &BuildParams<'_>,
    passes: &BrickPasses,
) -> Result<(wgpu::BindGroup, wgpu::BindGroup), GpuError> {
    let gpu = field.gpu();
    let view = site
        .texture
        .create_view(&wgpu::TextureViewDescriptor::default());
    gpu.with_error_scope(|| {
        let mut entries: Vec<_> = field.bindings_with(order.instructions).collect();
        entries.push(entry(VOLUME, &scratch.words));
        entries.push(entry(FILL, &scratch.fill));
        entries.push(entry(PRUNE, &scratch.prune));
        entries.extend(scratch.lists.binding(LISTS));
        entries.push(wgpu::BindGroupEntry {
            binding: TEXELS,
            resource: wgpu::BindingResource::TextureView(&view),
        });
        entries.extend(site.cells.binding(CELLS));
        entries.extend(scratch.candidates.binding(CANDIDATES));
        entries.extend(site.counters.binding(COUNTERS));
        entries.extend(site.materials.binding(BRICK_MATERIALS));
        let group = |label, layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries,
            })
        };
        let bind_group = group("Bricks::make", &passes.layout, &entries);
        let mut entries = vec![entry(VOLUME, &scratch.words)];
        entries.extend(scratch.arguments.binding(ARGUMENTS));
        entries.extend(site.counters.binding(COUNTERS));
        let plan_group = group("Bricks::plan", &passes.plan_layout, &entries);
        (bind_group, plan_group)
    })
}

/// Submits all passes of a build.
pub(super) async fn encode_build(
    field: &GpuProgram,
    scratch: &mut EditScratch,
    site: &BrickTargets<'_>,
    order: &BuildParams<'_>,
    recorder: &mut PassRecorder<'_>,
) -> Result<(), GpuError> {
    let gpu = field.gpu();
    let last = &order.prune;
    let bits = TexelFormat::of(site.texture.format()).bits();
    let passes = BrickPasses::of(field, bits)?;
    scratch.reserve_arguments(gpu, order.words.chunks)?;
    gpu.queue
        .write_buffer(&scratch.words, 0, bytemuck::bytes_of(&order.words));
    let (bind_group, plan_group) = groups_of(field, scratch, site, order, &passes)?;
    gpu.queue
        .write_buffer(&scratch.prune, 0, bytemuck::bytes_of(last));
    let groups = rows((order.length as u32).div_ceil(64).max(1));
    recorder
        .pass("prune", &passes.begin_lists, &bind_group, groups)
        .await?;
    recorder
        .pass("measure", &passes.measure, &bind_group, rows(last.count))
        .await?;
    if last.build_mode == abi::BUILD_COUNT_ONLY {
        return Ok(());
    }
    let groups = DispatchSize::Direct([order.words.chunks.div_ceil(64), 1, 1]);
    recorder
        .pass("measure", &passes.plan, &plan_group, groups)
        .await?;
    let (Some(arguments), Some(indirect)) = (scratch.arguments.buffer(), &scratch.indirect) else {
        return Err(GpuError::Lost("no buffer".into()));
    };
    gpu.with_error_scope(|| {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let bytes = 24 * u64::from(order.words.chunks);
        encoder.copy_buffer_to_buffer(arguments, 0, indirect, 0, bytes);
        gpu.queue.submit([encoder.finish()]);
    })?;
    for chunk in 0..order.words.chunks {
        let fill = FillUniform {
            first_layer: chunk * order.words.chunk,
            ..order.fill
        };
        gpu.queue
            .write_buffer(&scratch.fill, 0, bytemuck::bytes_of(&fill));
        let groups = DispatchSize::Indirect(indirect, 24 * u64::from(chunk) + 12);
        recorder
            .pass("prune", &passes.prune_cells, &bind_group, groups)
            .await?;
        let groups = DispatchSize::Indirect(indirect, 24 * u64::from(chunk));
        recorder
            .pass("fill", &passes.fill_bricks, &bind_group, groups)
            .await?;
        if order.mixes {
            recorder
                .pass("materials", &passes.fill_materials, &bind_group, groups)
                .await?;
        }
    }
    let groups = rows(last.count.div_ceil(64));
    recorder
        .pass("release", &passes.mark_empty_blocks, &bind_group, groups)
        .await?;
    let groups = DispatchSize::Direct([1, 1, 1]);
    recorder
        .pass("release", &passes.release_freed, &bind_group, groups)
        .await?;
    Ok(())
}
