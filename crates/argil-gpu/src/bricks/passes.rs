//! The passes that build all bricks or some, compiled once for a program and a sample format.

use super::build_tables::{ARGUMENT_BYTES, BrickTargets, EditScratch};
use super::repack::RepackPass;
use crate::bindings::{
    ARGUMENTS, BRICK_MATERIALS, Bind, CANDIDATES, CELLS, COLUMNS_WGSL, COUNTERS, FIELD_BINDS, FILL,
    LISTS, PARAMS, PRUNE, TABLES_WGSL, TEXELS, VOLUME, entry,
};
use crate::pass_module::{PassModule, Passes, compile_together};
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
/// Threads that sample a brick by columns.
const COLUMN_GROUP: u32 = 243;

/// The cost of pruning, in evaluations.
const EVALUATIONS_TO_PRUNE: u64 = 4;

/// The bindings, as the shader names them.
const BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickBuildUniform;
@group(0) @binding(BIND_CELLS) var<storage, read_write> cells: array<u32>;
@group(0) @binding(BIND_BRICK_MATERIALS) var<storage, read_write> brick_materials: array<u32>;
@group(0) @binding(BIND_CANDIDATES) var<storage, read_write> near_cells: array<u32>;
@group(0) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
@group(0) @binding(BIND_PRUNE) var<uniform> prune: PruneUniform;
";

/// Lists that passes write.
const LISTS_WGSL: &str = "
@group(0) @binding(BIND_LISTS) var<storage, read_write> lists: array<u32>;
";

const PLAN_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickBuildUniform;
@group(0) @binding(BIND_ARGUMENTS) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
";

/// Returns the samples of a brick that each thread of its group has.
pub(crate) fn samples_per_thread(brick_size_voxels: u32) -> u32 {
    (brick_size_voxels + 1).pow(3).div_ceil(BRICK_GROUP)
}

/// Describes the passes that build bricks of a size, from the interpreter with pruning.
pub(crate) fn build_module(
    pruning_wgsl: &str,
    texels: TexelFormat,
    brick_size_voxels: u32,
) -> PassModule {
    let samples = samples_per_thread(brick_size_voxels);
    let samples = format!("const SAMPLES_PER_THREAD: u32 = {samples}u;\n");
    let source = [
        &argil_abi::wgsl(),
        &samples,
        TABLES_WGSL,
        &crate::dense::target_wgsl(texels),
        BINDS_WGSL,
        LISTS_WGSL,
        pruning_wgsl,
        wgsl::BRICK_CELLS,
        wgsl::BRICK_MATERIALS,
        wgsl::BRICK_BUILD,
    ];
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniform(VOLUME),
        Bind::Uniform(FILL),
        Bind::Target(TEXELS, texels.format()),
        Bind::Write(CELLS),
        Bind::Write(CANDIDATES),
        Bind::Write(COUNTERS),
        Bind::Write(BRICK_MATERIALS),
        Bind::Write(LISTS),
        Bind::Uniform(PRUNE),
    ]);
    let constants = [("BRICK_GROUP", f64::from(BRICK_GROUP))];
    let entry_points = [
        "begin_lists",
        "prune_cells",
        "measure",
        "fill_bricks",
        "fill_materials",
        "mark_empty_blocks",
        "release_freed",
    ];
    PassModule::new("Bricks::build", &source, binds, &constants, &entry_points).with_constant(
        "prune_cells",
        "MARKING",
        1.0,
    )
}

/// Describes the pass that samples bricks of a size by columns, from the interpreter for those.
pub(crate) fn columns_module(
    column_wgsl: &str,
    texels: TexelFormat,
    brick_size_voxels: u32,
) -> PassModule {
    let side = brick_size_voxels + 1;
    let columns = (side * side * side.div_ceil(3)).div_ceil(COLUMN_GROUP);
    let columns = format!("const COLUMNS_PER_THREAD: u32 = {columns}u;\n");
    let source = [
        &argil_abi::wgsl(),
        &columns,
        &crate::dense::target_wgsl(texels),
        BINDS_WGSL,
        COLUMNS_WGSL,
        column_wgsl,
        wgsl::BRICK_CELLS,
        wgsl::BRICK_MATERIALS,
        wgsl::BRICK_COLUMNS,
    ];
    let binds = vec![
        Bind::Read(PARAMS),
        Bind::Uniform(VOLUME),
        Bind::Uniform(FILL),
        Bind::Target(TEXELS, texels.format()),
        Bind::Write(CELLS),
        Bind::Write(CANDIDATES),
        Bind::Write(COUNTERS),
        Bind::Write(BRICK_MATERIALS),
        Bind::Read(LISTS),
        Bind::Uniform(PRUNE),
    ];
    let constants = [("COLUMN_GROUP", f64::from(COLUMN_GROUP))];
    PassModule::new(
        "Bricks::columns",
        &source,
        binds,
        &constants,
        &["fill_columns"],
    )
}

/// Describes the pass that plans dispatches. It has a module of its own, because an indirect dispatch's arguments must not
/// be bound in the same pass.
pub(crate) fn plan_module() -> PassModule {
    let source = [&argil_abi::wgsl(), PLAN_BINDS_WGSL, wgsl::BRICK_PLAN];
    let binds = vec![
        Bind::Uniform(VOLUME),
        Bind::Write(ARGUMENTS),
        Bind::Write(COUNTERS),
    ];
    PassModule::new("Bricks::plan", &source, binds, &[], &["plan"])
}

/// The passes that build bricks.
pub(crate) struct BrickPasses {
    build: Passes,
    /// Nothing where no shape of the program is common.
    columns: Option<Passes>,
    plan: Passes,
    /// Moves bricks from one pool to another.
    pub(super) repack: RepackPass,
}

impl BrickPasses {
    /// Returns the passes for a program, a sample format and a brick size.
    pub(super) fn of(
        field: &GpuProgram,
        bits: SampleFormat,
        side: u32,
    ) -> Result<Arc<Self>, GpuError> {
        let key = ("bricks", bits.bytes() as u32 + 16 * side);
        field.passes(key, || Self::new(field, bits, side))
    }

    /// Returns what a build runs.
    fn of_build(&self, mixes: bool) -> Vec<(&Passes, usize)> {
        let names = [
            "begin_lists",
            "measure",
            "prune_cells",
            "fill_bricks",
            "mark_empty_blocks",
            "release_freed",
        ];
        let materials = mixes.then_some("fill_materials");
        let build = names.into_iter().chain(materials);
        let build = build.map(|name| (Some(&self.build), name));
        let others = [
            (self.columns.as_ref(), "fill_columns"),
            (Some(&self.plan), "plan"),
        ];
        let all = build.chain(others);
        all.filter_map(|(passes, name)| Some((passes?, passes?.index(name)?)))
            .collect()
    }

    fn new(field: &GpuProgram, bits: SampleFormat, side: u32) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let build = build_module(&field.pruning_wgsl(), gpu.texels(bits), side);
        let columns = field.column_wgsl();
        let columns = columns.map(|text| columns_module(&text, gpu.texels(bits), side));
        Ok(Self {
            build: Passes::new(gpu, build)?,
            columns: columns.map(|module| Passes::new(gpu, module)).transpose()?,
            plan: Passes::new(gpu, plan_module())?,
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
    let each = u64::from(samples_per_thread(layout.brick_size_voxels())).max(EVALUATIONS_TO_PRUNE);
    field.check_evaluations(each)
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

/// What the passes of a build read and write.
struct BuildGroups {
    build: wgpu::BindGroup,
    columns: Option<wgpu::BindGroup>,
    plan: wgpu::BindGroup,
}

/// Returns the bind groups of a build.
fn groups_of(
    field: &GpuProgram,
    scratch: &EditScratch,
    site: &BrickTargets<'_>,
    order: &BuildParams<'_>,
    passes: &BrickPasses,
) -> Result<BuildGroups, GpuError> {
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
        entries.extend(scratch.arguments.binding(ARGUMENTS));
        entries.extend(site.counters.binding(COUNTERS));
        entries.extend(site.materials.binding(BRICK_MATERIALS));
        let group = |label, passes: &Passes| {
            let has = |place: u32| passes.places().any(|bound_place| bound_place == place);
            let needed = entries.iter().filter(|entry| has(entry.binding));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout: &passes.layout,
                entries: &needed.cloned().collect::<Vec<_>>(),
            })
        };
        let columns = passes.columns.as_ref();
        BuildGroups {
            build: group("Bricks::build", &passes.build),
            columns: columns.map(|passes| group("Bricks::columns", passes)),
            plan: group("Bricks::plan", &passes.plan),
        }
    })
}

/// A build with its bindings.
pub(super) struct BoundBuild<'a> {
    field: &'a GpuProgram,
    passes: Arc<BrickPasses>,
    bound: BuildGroups,
}

impl<'a> BoundBuild<'a> {
    /// Uploads what to build, and binds it. Compiles the passes.
    pub(super) fn new(
        field: &'a GpuProgram,
        scratch: &mut EditScratch,
        site: &BrickTargets<'_>,
        order: &BuildParams<'_>,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let bits = TexelFormat::of(site.texture.format()).bits();
        let passes = BrickPasses::of(field, bits, order.words.brick_size_voxels)?;
        compile_together(gpu, &passes.of_build(order.mixes))?;
        scratch.reserve_arguments(gpu, order.words.chunks)?;
        gpu.write_buffer(&scratch.words, 0, bytemuck::bytes_of(&order.words));
        gpu.write_buffer(&scratch.prune, 0, bytemuck::bytes_of(&order.prune));
        let fills: Vec<FillUniform> = (0..order.words.chunks)
            .map(|chunk| FillUniform {
                first_layer: chunk * order.words.chunk,
                ..order.fill
            })
            .collect();
        scratch.fills.write(gpu, &fills)?;
        let bound = groups_of(field, scratch, site, order, &passes)?;
        Ok(Self {
            field,
            passes,
            bound,
        })
    }

    /// Submits the passes that find the cells near the surface.
    pub(super) async fn measure(
        &self,
        scratch: &EditScratch,
        order: &BuildParams<'_>,
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let gpu = self.field.gpu();
        let build = |name| self.passes.build.get(gpu, name);
        let bind_group = &self.bound.build;
        scratch.clear_candidates(&order.prune, recorder);
        let groups = rows((order.length as u32).div_ceil(64).max(1));
        recorder
            .pass("prune", build("begin_lists")?, bind_group, groups)
            .await?;
        let groups = rows(order.prune.count);
        recorder
            .pass("measure", build("measure")?, bind_group, groups)
            .await
    }

    /// Submits the passes that sample these cells.
    pub(super) async fn fill(
        &self,
        scratch: &EditScratch,
        order: &BuildParams<'_>,
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let (gpu, passes, bound) = (self.field.gpu(), &self.passes, &self.bound);
        let build = |name| passes.build.get(gpu, name);
        let (bind_group, last) = (&bound.build, &order.prune);
        let groups = DispatchSize::Direct([order.words.chunks.div_ceil(64), 1, 1]);
        recorder
            .pass(
                "measure",
                passes.plan.get(gpu, "plan")?,
                &bound.plan,
                groups,
            )
            .await?;
        let (Some(arguments), Some(indirect)) = (scratch.arguments.buffer(), &scratch.indirect)
        else {
            return Err(GpuError::Lost("no buffer".into()));
        };
        let bytes = ARGUMENT_BYTES * u64::from(order.words.chunks);
        recorder
            .encoder()
            .copy_buffer_to_buffer(arguments, 0, indirect, 0, bytes);
        recorder
            .pass("prune", build("prune_cells")?, bind_group, rows(last.count))
            .await?;
        for chunk in 0..order.words.chunks {
            if chunk > 0 {
                // No driver considers short submissions hung.
                recorder.submit()?;
            }
            if let Some(fills) = scratch.fills.buffer() {
                let bytes = size_of::<FillUniform>() as u64;
                let at = bytes * u64::from(chunk);
                let encoder = recorder.encoder();
                encoder.copy_buffer_to_buffer(fills, at, &scratch.fill, 0, bytes);
            }
            let groups = DispatchSize::Indirect(indirect, ARGUMENT_BYTES * u64::from(chunk));
            recorder
                .pass("fill", build("fill_bricks")?, bind_group, groups)
                .await?;
            if let (Some(columns), Some(group)) = (&passes.columns, &bound.columns) {
                recorder
                    .pass("fill", columns.get(gpu, "fill_columns")?, group, groups)
                    .await?;
            }
            if order.mixes {
                recorder
                    .pass("materials", build("fill_materials")?, bind_group, groups)
                    .await?;
            }
        }
        let groups = rows(last.count.div_ceil(64));
        recorder
            .pass("release", build("mark_empty_blocks")?, bind_group, groups)
            .await?;
        let groups = DispatchSize::Direct([1, 1, 1]);
        recorder
            .pass("release", build("release_freed")?, bind_group, groups)
            .await?;
        Ok(())
    }
}
