//! Builds all bricks, like an edit of all blocks. The CPU plans the blocks with their programs, and the device does
//! everything else.

use super::cells::GpuCellTable;
use super::light::GpuLight;

use super::build_tables::{BrickTargets, EditScratch};
use super::list_arena::BlockTables;
use super::passes::{BuildParams, check, chunks, encode_build};
use super::pool_accounting::PoolAccounting;
use super::tables::{BrickTables, PLACES, pool_for, pool_texture};
use crate::pass_recorder::PassRecorder;
use crate::program::NOP;
use crate::storage_buffer::StorageBuffer;
use crate::{GpuError, GpuProgram, GpuVolume, StageTimings};
use argil_abi::{self as abi, BrickBuildUniform, BrickUniform};
use argil_field::Program;
use argil_math::Control;
use argil_volume::{BLOCK_SIDE, BlockPlan, BlockTable, BrickLayout, FAR_SLOTS};

/// Maximum blocks per run, and instructions of their lists, because its tables have limits.
const MAX_BLOCKS: usize = 4096;
const MAX_INSTRUCTIONS: usize = 1 << 20;
/// Typical bricks per block, with more room than a surface needs.
const BRICKS_PER_BLOCK: u64 = 16;

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
        })
    }

    /// Returns the block table.
    pub(super) fn cells(&self) -> &GpuCellTable {
        &self.cells
    }

    /// Returns an estimate of the number of bricks, or more.
    pub(super) fn guess(&self) -> u64 {
        let blocks: u64 = self.runs.iter().map(|run| run.slots.len() as u64).sum();
        BRICKS_PER_BLOCK * blocks + 64
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
        let capacity: u32 = self.pool.iter().product();
        let bytes = 4 * u64::from(capacity) + 8 * PLACES * mixed_room;
        self.materials.reserve_exact(gpu, bytes)?;
        self.accounting = PoolAccounting::new(gpu, 0, 0)?;
        self.cells.clear(gpu);
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
        for run in &self.runs {
            if control.is_cancelled() {
                return Err(GpuError::Cancelled);
            }
            control.advance(run.slots.len() as u64);
            let instructions = if run.instructions.is_empty() {
                NOP
            } else {
                &run.instructions
            };
            self.instructions.write(gpu, instructions)?;
            let lists = &mut self.scratch.lists;
            let prune = run.write(gpu, lists, self.program, &self.layout)?;
            self.scratch.reserve_candidates(gpu, prune.count)?;
            let [chunk, chunks] = chunks(&self.layout, run.longest(), run.cells());
            let words = BrickBuildUniform {
                chunk,
                chunks: chunks.max(1),
                pool_x: self.pool[0],
                pool_y: self.pool[1],
                capacity,
                mixed: mixed_room as u32,
                table: self.cells.described(),
                ..self.layout.build_uniform(self.program)
            };
            let order = BuildParams {
                words,
                fill: self.layout.encoding().fill_uniform(
                    self.program,
                    self.layout.voxel_grid(),
                    0,
                ),
                prune,
                instructions: &self.instructions,
                length: run.instructions.len(),
                mixes: self.program.materials().len() > 1,
            };
            let site = BrickTargets {
                texture: &texture,
                cells: &self.cells.buffer,
                materials: &self.materials,
                counters: &self.accounting.counters,
            };
            encode_build(self.field, &mut self.scratch, &site, &order, &mut recorder).await?;
        }
        Ok((texture, recorder.finish().await?))
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

    /// Returns the result, without unused space.
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
            making: None,
            light: GpuLight::new(self.field.gpu())?,
            uniform: BrickUniform::default(),
        };
        let texture = tables.fit(self.field, texture, count, mixed)?;
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
