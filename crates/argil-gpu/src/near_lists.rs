//! Lists of instructions for the parts of a grid, with which frames and paths evaluate the field.

use crate::bindings::{Bind, COUNTERS, FIELD_BINDS, LISTS, PRUNE, TABLES_WGSL};
use crate::pass_module::{PassModule, Passes};
use crate::pass_recorder::PassRecorder;
use crate::resources::uniform_of;
use crate::storage_buffer::StorageBuffer;
use crate::submission::Submission;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError, HostEncoder};
use argil_abi::{COUNTER_LISTS, NearUniform};
use argil_field::Program;
use std::sync::Arc;

/// Shorter programs are evaluated whole.
const SHORT: usize = 8;
/// As many instructions take longer than to compile what makes lists, and to make them: on a software device, and on hardware.
const MUCH: [u64; 2] = [1 << 20, 1 << 30];
/// Words reserved for the lists of a part, for those of a block per instruction, and at most for all.
const PART_WORDS: u64 = 32;
const BLOCK_WORDS: u64 = 2;
const MOST_WORDS: u64 = 1 << 24;
/// How far the grid reaches beyond the solid, as a fraction of its longest side. Occlusion evaluates points there.
const AROUND: f32 = 0.125;
/// Threads of a workgroup, and workgroups in a row of a dispatch.
const GROUP: u64 = 64;
const ROW: u32 = 32_768;

/// Tables to read.
const READ_WGSL: &str = "
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;
@group(0) @binding(BIND_PRUNE) var<uniform> near: NearUniform;
";

/// The same, to write.
const WRITE_WGSL: &str = "
@group(0) @binding(BIND_LISTS) var<storage, read_write> lists: array<u32>;
@group(0) @binding(BIND_PRUNE) var<uniform> prune: NearUniform;
@group(0) @binding(BIND_COUNTERS) var<storage, read_write> counters: array<atomic<u32>>;
";

/// The bindings of what reads lists, for trace modes.
pub(crate) const NEAR_BINDS: [Bind; 2] = [Bind::Read(LISTS), Bind::Uniform(PRUNE)];

/// Returns the WGSL of these.
pub(crate) fn near_tables() -> String {
    READ_WGSL.to_owned()
}

/// Returns the bindings and the WGSL of what evaluates the field, by lists or not.
pub(crate) fn field_tables(by_lists: bool) -> (Vec<Bind>, String) {
    let (mut binds, mut wgsl) = (FIELD_BINDS.to_vec(), TABLES_WGSL.to_owned());
    if by_lists {
        binds.extend(NEAR_BINDS);
        wgsl += READ_WGSL;
    }
    (binds, wgsl)
}

/// What makes the lists of a program: passes, and what is bound of the program.
pub(crate) struct NearPasses<'a> {
    pub passes: Arc<Passes>,
    pub tables: Vec<wgpu::BindGroupEntry<'a>>,
}

/// The lists of a program.
#[derive(Debug)]
pub(crate) struct NearLists {
    lists: StorageBuffer,
    counters: StorageBuffer,
    uniform: Option<wgpu::Buffer>,
    /// The grid of the program, and the program's length. `None` if it is evaluated whole.
    grid: Option<(NearUniform, usize)>,
    /// The submission that makes the lists of the program.
    made: Option<Submission>,
}

impl Default for NearLists {
    fn default() -> Self {
        Self {
            lists: StorageBuffer::new("lists of parts"),
            counters: StorageBuffer::new("counters of lists"),
            uniform: None,
            grid: None,
            made: None,
        }
    }
}

impl NearLists {
    /// Follows a program, whose lists are made when they are first asked for.
    pub(crate) fn follow(&mut self, program: &Program) {
        let length = program.instructions().len();
        let solid = program.aabb();
        let around = solid.grown(AROUND * solid.size().max_element());
        let grid = program.near_grid(around).filter(|_| length > SHORT);
        self.grid = grid.map(|grid| (grid, length));
        self.made = None;
    }

    /// Returns the bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.lists.size() + self.counters.size()
    }

    /// Whether the lists are those of the program.
    fn are_made(&self) -> bool {
        self.made
            .as_ref()
            .is_some_and(|submission| !submission.is_dropped())
    }

    /// Whether some evaluations are faster by lists, with the time to make them.
    pub(crate) fn pays_for(&self, gpu: &Gpu, evaluations: u64) -> bool {
        let much = MUCH[usize::from(gpu.is_hardware())];
        let work = |&(_, length): &(NearUniform, usize)| evaluations.saturating_mul(length as u64);
        self.are_made() || self.grid.as_ref().is_some_and(|grid| work(grid) >= much)
    }

    /// Makes the lists, unless they are made, in the encoder of a host if there is one. Returns what is bound of them, or `None` if
    /// the program is evaluated whole.
    pub(crate) fn bound<'a>(
        &mut self,
        gpu: &Gpu,
        made_by: impl FnOnce() -> Result<NearPasses<'a>, GpuError>,
        host: Option<&mut HostEncoder>,
    ) -> Result<Option<Vec<BoundResource>>, GpuError> {
        let Some((mut grid, length)) = self.grid else {
            return Ok(None);
        };
        // What is submitted here may come before what a host still has to submit.
        let comes_after = |submission: &Submission| {
            submission.is_done() || host.is_some() && !submission.is_dropped()
        };
        if !self.made.as_ref().is_some_and(comes_after) {
            self.reserve(gpu, &mut grid, length as u64)?;
            let mut recorder = PassRecorder::untimed(gpu, host);
            self.make(gpu, made_by()?, &grid, length as u64, recorder.encoder())?;
            recorder.submit()?;
            self.made = Some(recorder.submission());
        }
        let uniform = self
            .uniform
            .iter()
            .map(|uniform| BoundResource::buffer(PRUNE, uniform));
        Ok(Some(
            self.lists.bound(LISTS).into_iter().chain(uniform).collect(),
        ))
    }

    /// Reserves memory. What does not fit into it uses the list that it would be pruned from.
    fn reserve(&mut self, gpu: &Gpu, grid: &mut NearUniform, length: u64) -> Result<(), GpuError> {
        let blocks = blocks_of(grid);
        let head = 2 * (65 * blocks + 1);
        let wanted = BLOCK_WORDS * blocks * length + 64 * blocks * PART_WORDS;
        let words = wanted.min(MOST_WORDS).max(length);
        self.lists.reserve(gpu, 4 * (head + words))?;
        self.counters
            .reserve(gpu, 4 * (u64::from(COUNTER_LISTS) + 1))?;
        (grid.arena_first, grid.arena_words) = (head as u32, words as u32);
        if self.uniform.is_none() {
            self.uniform =
                Some(gpu.with_error_scope(|| uniform_of::<NearUniform>(gpu, "grid of lists"))?);
        }
        if let Some(uniform) = &self.uniform {
            gpu.write_buffer(uniform, 0, bytemuck::bytes_of(grid));
        }
        Ok(())
    }

    /// Encodes the passes that make the lists.
    fn make(
        &self,
        gpu: &Gpu,
        NearPasses { passes, tables }: NearPasses<'_>,
        grid: &NearUniform,
        length: u64,
        encoder: &mut HostEncoder,
    ) -> Result<(), GpuError> {
        let blocks = blocks_of(grid);
        let mut stages = Vec::new();
        for (name, groups) in [
            ("begin_near_lists", length.div_ceil(GROUP)),
            ("prune_near_blocks", blocks.div_ceil(GROUP)),
            ("prune_near_parts", blocks),
        ] {
            stages.push((passes.get(gpu, name)?, groups as u32));
        }
        gpu.with_error_scope(|| {
            let mut entries = tables;
            entries.extend(self.lists.binding(LISTS));
            entries.extend(self.counters.binding(COUNTERS));
            entries.extend(
                self.uniform
                    .iter()
                    .map(|uniform| crate::bindings::entry(PRUNE, uniform)),
            );
            let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Field::lists"),
                layout: &passes.layout,
                entries: &entries,
            });
            for (pipeline, groups) in stages {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &bound, &[]);
                pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), 1);
            }
        })
    }
}

fn blocks_of(grid: &NearUniform) -> u64 {
    [grid.blocks_x, grid.blocks_y, grid.blocks_z]
        .map(u64::from)
        .iter()
        .product()
}

/// Describes the passes that make lists.
pub(crate) fn near_lists_module(lists_wgsl: &str) -> PassModule {
    let source = [&argil_abi::wgsl(), TABLES_WGSL, WRITE_WGSL, lists_wgsl];
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Write(LISTS),
        Bind::Uniform(PRUNE),
        Bind::Write(COUNTERS),
    ]);
    let entry_points = ["begin_near_lists", "prune_near_blocks", "prune_near_parts"];
    PassModule::new(
        "Field::lists",
        &source,
        binds,
        &[("MARKING", 1.0)],
        &entry_points,
    )
}
