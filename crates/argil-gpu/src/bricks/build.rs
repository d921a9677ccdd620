//! Builds all bricks, like an edit of all blocks. The CPU plans the blocks with their programs, and the device does
//! everything else.

use super::cells::GpuCellTable;
use super::light::GpuLight;

use super::build_tables::{BrickTargets, EditScratch};
use super::list_arena::BlockTables;
use super::passes::{BoundBuild, BuildParams, check, chunks};
use super::pool_accounting::PoolAccounting;
use super::tables::{BrickTables, PLACES, pool_for, pool_texture};
use crate::pass_recorder::PassRecorder;
use crate::program::NOP;
use crate::storage_buffer::StorageBuffer;
use crate::{GpuError, GpuProgram, GpuVolume, StageTimings};
use argil_abi::{self as abi, BrickBuildUniform, BrickUniform, PruneUniform};
use argil_field::Program;
use argil_math::Control;
use argil_volume::{BLOCK_SIDE, BlockPlan, BlockTable, BrickLayout, FAR_SLOTS};

/// Maximum blocks per run, and instructions of their lists, because its tables have limits.
const MAX_BLOCKS: usize = 4096;
const MAX_INSTRUCTIONS: usize = 1 << 20;

/// The tables of a build.
pub(super) struct BrickBuilder<'a> {
    field: &'a GpuProgram,
    program: &'a Program,
    layout: BrickLayout,
    runs: Vec<BlockTables>,
    pool: [u32; 3],
    mixed_room: u64,
    scratch: EditScratch,
    instructions: StorageBuffer,
    cells: GpuCellTable,
    materials: StorageBuffer,
    accounting: PoolAccounting,
    /// The only run, if its cells near the surface are found and not sampled yet.
    measured: Option<PruneUniform>,
}

impl<'a> BrickBuilder<'a> {
    /// Creates the tables for a field, within `budget` bytes.
    pub(super) fn new(
        field: &'a GpuProgram,
        program: &'a Program,
        layout: BrickLayout,
        budget: u64,
        control: &Control,
    ) -> Result<Self, GpuError> {
        check(field, program, &layout)?;
        let gpu = field.gpu();
        let plan = BlockPlan::of(program, &layout, Some(budget), control)?;
        if control.is_cancelled() {
            return Err(GpuError::Cancelled);
        }
        let needed = GpuCellTable::bytes_for(plan.blocks.len() as u64);
        if needed > budget {
            return Err(GpuError::Budget {
                bricks: 0,
                needed,
                budget,
            });
        }
        let mut runs: Vec<BlockTables> = Vec::new();
        for (slot, (block, range)) in (FAR_SLOTS..).zip(&plan.blocks) {
            let is_full = |run: &BlockTables| {
                run.slots.len() >= MAX_BLOCKS
                    || run.instructions.len() + range.len() > MAX_INSTRUCTIONS
            };
            if runs.last().is_none_or(is_full) {
                runs.push(BlockTables::default());
            }
            if let Some(run) = runs.last_mut() {
                let list = &plan.instructions[range.clone()];
                let first = *block * BLOCK_SIDE as i32;
                let bounds = layout.block_words(program, first, list);
                run.push(slot, u64::MAX, list, bounds);
            }
        }
        let table = BlockTable::of(&layout, &plan);
        Ok(Self {
            field,
            program,
            layout,
            runs,
            pool: [1; 3],
            mixed_room: 0,
            scratch: EditScratch::new(gpu)?,
            instructions: StorageBuffer::new("instructions of lists"),
            cells: GpuCellTable::new(gpu, table, layout.far_length(), None)?,
            materials: StorageBuffer::new("bricks' materials"),
            accounting: PoolAccounting::new(gpu, 0, 0)?,
            measured: None,
        })
    }

    /// Returns the block table.
    pub(super) fn cells(&self) -> &GpuCellTable {
        &self.cells
    }

    /// Returns the number of cells near the surface: as many bricks as there can be.
    pub(super) async fn count(
        &mut self,
        control: &Control,
    ) -> Result<(u64, StageTimings), GpuError> {
        let gpu = self.field.gpu();
        let (mode, counter) = match self.runs.len() {
            1 => (abi::BUILD_BLOCKS, abi::COUNTER_CANDIDATES),
            _ => (abi::BUILD_COUNT_ONLY, abi::COUNTER_BRICKS),
        };
        // Nothing is sampled.
        let texture = pool_texture(gpu, &self.layout, self.pool)?;
        self.materials.reserve_exact(gpu, 4)?;
        let mut recorder = PassRecorder::new(gpu)?;
        let mut cells = 0;
        for index in 0..self.runs.len() {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            let prune = self.upload(index, mode)?;
            self.submit(index, prune, &texture, [true, false], &mut recorder)
                .await?;
            cells += self.accounting.read(gpu).await?.get(counter);
            self.measured = (mode == abi::BUILD_BLOCKS).then_some(prune);
        }
        Ok((cells, recorder.finish().await?))
    }

    /// Builds into a pool with room for a number of bricks.
    pub(super) async fn run(
        &mut self,
        room: u64,
        mixed_room: u64,
        control: &Control,
    ) -> Result<(wgpu::Texture, StageTimings), GpuError> {
        let gpu = self.field.gpu();
        self.pool = pool_for(gpu, &self.layout, room)?;
        self.mixed_room = mixed_room;
        let texture = pool_texture(gpu, &self.layout, self.pool)?;
        let capacity: u64 = self.pool.map(u64::from).iter().product();
        let bytes = 4 * capacity + 8 * PLACES * mixed_room;
        self.materials.reserve_exact(gpu, bytes)?;
        let measured = self.measured.take();
        if measured.is_none() {
            self.accounting = PoolAccounting::new(gpu, 0, 0)?;
            self.cells.clear(gpu);
        }
        self.accounting.reserve_stack(gpu, capacity + mixed_room)?;
        gpu.with_error_scope(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(buffer) = self.materials.buffer() {
                encoder.clear_buffer(buffer, 0, None);
            }
            gpu.submit(encoder);
        })?;
        let mut recorder = PassRecorder::new(gpu)?;
        let blocks = self.runs.iter().map(|run| run.slots.len() as u64);
        control.begin("blocks", blocks.sum());
        for index in 0..self.runs.len() {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            control.advance(self.runs[index].slots.len() as u64);
            let prune = match measured {
                Some(prune) => prune,
                None => self.upload(index, abi::BUILD_BLOCKS)?,
            };
            let parts = [measured.is_none(), true];
            self.submit(index, prune, &texture, parts, &mut recorder)
                .await?;
        }
        Ok((texture, recorder.finish().await?))
    }

    /// Uploads the blocks of a run, and their programs.
    fn upload(&mut self, index: usize, build_mode: u32) -> Result<PruneUniform, GpuError> {
        let (gpu, run) = (self.field.gpu(), &self.runs[index]);
        let instructions = if run.instructions.is_empty() {
            NOP
        } else {
            &run.instructions
        };
        self.instructions.write(gpu, instructions)?;
        let lists = &mut self.scratch.lists;
        let prune = run.write(gpu, lists, self.program, &self.layout)?;
        self.scratch.reserve_candidates(gpu, prune.count)?;
        Ok(PruneUniform {
            build_mode,
            ..prune
        })
    }

    /// Submits the passes of a run: those that find cells near the surface, and those that sample them.
    async fn submit(
        &mut self,
        index: usize,
        prune: PruneUniform,
        texture: &wgpu::Texture,
        [measures, fills]: [bool; 2],
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let run = &self.runs[index];
        let [chunk, chunks] = chunks(&self.layout, run.longest(), run.cells());
        let words = BrickBuildUniform {
            chunk,
            chunks: chunks.max(1),
            pool_x: self.pool[0],
            pool_y: self.pool[1],
            capacity: self.pool.iter().product(),
            mixed: self.mixed_room as u32,
            table: self.cells.described(),
            ..self.layout.build_uniform(self.program)
        };
        let encoding = self.layout.encoding();
        let order = BuildParams {
            words,
            fill: encoding.fill_uniform(self.program, self.layout.voxel_grid(), 0),
            prune,
            instructions: &self.instructions,
            length: run.instructions.len(),
            mixes: self.program.materials().len() > 1,
        };
        let site = BrickTargets {
            texture,
            cells: &self.cells.buffer,
            materials: &self.materials,
            counters: &self.accounting.counters,
        };
        let build = BoundBuild::new(self.field, &mut self.scratch, &site, &order)?;
        if measures {
            build.measure(&self.scratch, &order, recorder).await?;
        }
        if fills {
            build.fill(&self.scratch, &order, recorder).await?;
        }
        Ok(())
    }

    /// Returns how many bricks the build needed, and how many of them are mixed.
    pub(super) async fn counts(&mut self) -> Result<[u64; 2], GpuError> {
        self.accounting.wait_for_counters(self.field.gpu()).await?;
        let counters = [abi::COUNTER_HIGH_WATER, abi::COUNTER_HIGH_WATER_MIXED];
        Ok(counters.map(|counter| self.accounting.known.get(counter)))
    }

    /// Whether there was room for these numbers of bricks and mixed ones.
    pub(super) fn has_room_for(&self, bricks: u64, mixed: u64) -> bool {
        let capacity: u64 = self.pool.map(u64::from).iter().product();
        bricks <= capacity && mixed <= self.mixed_room
    }

    /// Returns the result, with little unused space.
    pub(super) fn finish(
        self,
        texture: &wgpu::Texture,
        count: u64,
        mixed: u64,
    ) -> Result<GpuVolume, GpuError> {
        let mut tables = BrickTables {
            layout: self.layout,
            cells: self.cells,
            materials: self.materials,
            mixed: self.mixed_room,
            pool: self.pool,
            accounting: self.accounting,
            lipschitz: self.program.lipschitz(),
            making: Vec::new(),
            gone: Vec::new(),
            light: GpuLight::new(self.field.gpu())?,
            uniform: BrickUniform::default(),
        };
        let texture = tables.fit_closely(self.field, texture, count, mixed)?;
        volume_of(self.field, texture, tables)
    }
}

/// Creates a volume from tables and a pool.
pub(super) fn volume_of(
    field: &GpuProgram,
    texture: wgpu::Texture,
    mut tables: BrickTables,
) -> Result<GpuVolume, GpuError> {
    let measures = (*tables.layout.voxel_grid(), *tables.layout.encoding());
    tables.describe();
    GpuVolume::new(field, measures, texture, tables)
}
