//! Changes bricks in place, without waiting.
//!
//! *Practice.* The CPU knows which operands can matter in the blocks that edits touch. It uploads their programs
//! with the blocks. The device then measures cells, prunes, samples and stores as for a whole build. Everything is
//! submitted in order, so an image shows everything that was submitted before it, and nothing after. Only a very
//! large edit is counted first, and waited for: if one brick per cell would be far more than there is room for.
//!
//! A host may submit an edit with its own commands, or several of them. What the CPU writes to buffers comes before all of these.
//! So each edit has its own tables until its commands are done, whatever moves is copied by commands, and blocks without a surface
//! leave the table, and give their slots away, once the device has freed their bricks. Edits for a host are never counted first.

use super::build_tables::{BrickTargets, BuildTables};
use super::cells::GpuCellTable;
use super::list_arena::BlockTables;
use super::passes::{BoundBuild, BuildParams, check, chunks};
use super::tables::BrickTables;
use crate::pass_recorder::PassRecorder;
use crate::program::NOP;
use crate::volume::VolumeStorage;
use crate::{Gpu, GpuError, GpuProgram};
use argil_abi::{self as abi, BrickBuildUniform, PruneUniform};
use argil_field::IncrementalProgram;
use argil_volume::{
    BLOCK_SIDE, BrickLayout, BrickPendingEdits, EditBatch, EditQueue, EditStats, emptied_around,
};
use glam::IVec3;

/// Cells for which room is made without counting how many have a surface.
const FEW_CELLS: u64 = 4096;
/// Cells that the device samples per millisecond, before it is measured.
const CELLS_PER_MS: f64 = 200.0;

/// Maximum batches of up to 64 blocks per run, because its tables have limits.
const MAX_BATCHES: usize = 512;

impl BrickTables {
    /// Submits the remaining edits of a volume's tables and texture.
    pub(super) async fn edit_in(
        &mut self,
        body: &mut VolumeStorage,
        edit: crate::volume::EditContext<'_>,
    ) -> Result<(), GpuError> {
        let Some(edits) = BrickPendingEdits::downcast_mut(edit.edits) else {
            return Ok(());
        };
        let (field, live, work) = (edit.field, edit.incremental, &mut edits.queue);
        check(field, live.program(), &self.layout)?;
        let gpu = field.gpu().clone();
        if edit.encoder.is_none() {
            self.wait_for_hosts(&gpu).await?;
        }
        self.accounting.poll_counters(&gpu)?;
        let mut left = edit
            .within
            .map(|within| CELLS_PER_MS * within.as_secs_f64() * 1e3);
        let mut recorder = PassRecorder::untimed(&gpu, edit.encoder);
        self.forget_gone(&mut recorder)?;
        let edit = EditRun {
            field,
            live,
            budget: edit.budget.unwrap_or(u64::MAX),
        };
        let mut result = Ok(());
        while !work.is_done() && result.is_ok() {
            let count = if left.is_some() { 4 } else { MAX_BATCHES };
            let units = work.next(count);
            let (blocks, gone) = edit.gather(&mut recorder, self, work, units)?;
            let mut making = self.take_making(&gpu)?;
            result = edit
                .submit(self, body, &mut making, &blocks, &mut recorder)
                .await;
            let submission = recorder.submission();
            self.making.push((making, submission.clone()));
            let gone = gone.into_iter();
            self.gone
                .extend(gone.map(|(block, inside)| (block, inside, submission.clone())));
            self.forget_gone(&mut recorder)?;
            if let Some(left) = &mut left {
                *left -= blocks.cells() as f64;
                if *left <= 0.0 {
                    break;
                }
            }
        }
        recorder.submit()?;
        // What remains may be as steep as before.
        let lipschitz = live.program().lipschitz();
        self.lipschitz = match work.is_done() {
            true => lipschitz,
            false => self.lipschitz.max(lipschitz),
        };
        self.describe();
        result
    }

    /// Returns tables that no command reads any more.
    fn take_making(&mut self, gpu: &Gpu) -> Result<Box<BuildTables>, GpuError> {
        let done = self
            .making
            .iter()
            .position(|(_, submission)| submission.is_done());
        match done {
            Some(place) => Ok(self.making.swap_remove(place).0),
            None => BuildTables::new(gpu).map(Box::new),
        }
    }

    /// Takes blocks out of the table whose bricks the device has freed, and uploads it.
    fn forget_gone(&mut self, recorder: &mut PassRecorder<'_>) -> Result<(), GpuError> {
        let table = &mut self.cells.table;
        self.gone.retain(|(block, inside, submission)| {
            let is_freed = submission.is_done();
            if is_freed {
                table.set_far(*block, *block + 1, *inside);
            }
            !is_freed
        });
        self.cells.follow(&[], recorder)
    }

    /// Waits for edits that hosts have submitted.
    async fn wait_for_hosts(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let are_made = |volume: &Self| {
            volume
                .making
                .iter()
                .all(|(_, submission)| submission.is_done())
        };
        if are_made(self) {
            return Ok(());
        }
        gpu.wait().await?;
        match are_made(self) {
            true => Ok(()),
            false => Err(GpuError::NotSubmitted),
        }
    }

    /// Waits for edits. Returns what they did since the last call.
    pub(super) async fn wait_in(&mut self, gpu: &Gpu) -> Result<EditStats, GpuError> {
        self.wait_for_hosts(gpu).await?;
        let counted = self.accounting.wait_for_counters(gpu).await?;
        let mut recorder = PassRecorder::untimed(gpu, None);
        self.forget_gone(&mut recorder)?;
        recorder.submit()?;
        self.describe();
        Ok(counted)
    }

    /// Grows to a larger box with the same voxels. The next edit uploads the table.
    pub(super) fn grow_to(&mut self, body: &mut VolumeStorage, layout: BrickLayout) {
        self.layout = layout;
        let [low, high] = layout.block_range();
        self.cells.table.grow_to(low, high);
        body.voxel_grid = *layout.voxel_grid();
    }

    /// Waits for edits, and frees unused memory.
    pub(super) async fn trim_in(
        &mut self,
        body: &mut VolumeStorage,
        field: &GpuProgram,
    ) -> Result<(), GpuError> {
        self.wait_for_hosts(field.gpu()).await?;
        let counted = self.accounting.read(field.gpu()).await?;
        self.making.clear();
        let fit = self.fit(field, &body.texture, counted.bricks(), counted.mixed())?;
        body.set_texture(fit);
        self.describe();
        Ok(())
    }
}

struct EditRun<'a> {
    field: &'a GpuProgram,
    live: &'a IncrementalProgram,
    budget: u64,
}

impl EditRun<'_> {
    /// Returns the blocks of batches in which something can have changed, with their programs, and the blocks that
    /// are far from everything now, with their side.
    fn gather(
        &self,
        recorder: &mut PassRecorder<'_>,
        tables: &mut BrickTables,
        work: &EditQueue,
        units: Vec<EditBatch>,
    ) -> Result<(BlockTables, Vec<(IVec3, bool)>), GpuError> {
        let layout = &tables.layout;
        let mut blocks = BlockTables::default();
        let (mut gone, mut new) = (Vec::new(), Vec::new());
        let table = &mut tables.cells.table;
        for list in work.lists(layout, self.live, units) {
            let block = list.first / BLOCK_SIDE as i32;
            let slot = table.find(block);
            // An edit before has freed its bricks, or will; this one decides again.
            tables.gone.retain(|(gone_block, ..)| *gone_block != block);
            if let Some(inside) = list.far {
                gone.push((block, inside));
                if slot.is_none() {
                    continue;
                }
            }
            let slot = slot.unwrap_or_else(|| {
                let slot = table.insert(block);
                new.push(slot);
                slot
            });
            let dirty = work.dirty_cells(layout, self.live, list.first);
            let bounds = layout.block_words(self.live.program(), list.first, &list.current);
            blocks.push(slot, dirty, &list.current, bounds);
        }
        let needed = GpuCellTable::bytes_for(new.len() as u64) + tables.cells.memory_bytes();
        if !new.is_empty() && needed > self.budget {
            return Err(GpuError::Budget {
                bricks: tables.accounting.known.bricks(),
                needed,
                budget: self.budget,
            });
        }
        if !gone.is_empty() {
            gone.extend(emptied_around(
                &tables.cells.table,
                layout,
                self.live,
                &gone,
            ));
        }
        tables.cells.follow(&new, recorder)?;
        Ok((blocks, gone))
    }

    async fn submit(
        &self,
        tables: &mut BrickTables,
        body: &mut VolumeStorage,
        making: &mut BuildTables,
        blocks: &BlockTables,
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        if blocks.slots.is_empty() {
            return Ok(());
        }
        let gpu = self.field.gpu();
        let program = self.live.program();
        let mixes = program.materials().len() > 1;
        let instructions = if blocks.instructions.is_empty() {
            NOP
        } else {
            &blocks.instructions
        };
        making.instructions.write(gpu, instructions)?;
        let lists = &mut making.scratch.lists;
        let prune = blocks.write(gpu, lists, program, &tables.layout)?;
        making.scratch.reserve_candidates(gpu, prune.count)?;

        let mut more = [blocks.cells(); 2];
        let few = match recorder.is_for_host() {
            true => u64::MAX,
            false => FEW_CELLS.max(tables.accounting.known.bricks() / 4),
        };
        let make_room = |tables: &mut BrickTables, more, recorder: &mut PassRecorder<'_>| {
            let place = (&body.texture, recorder);
            tables.make_room(self.field, place, more, mixes, self.budget)
        };
        let room = (more[0] <= few).then(|| make_room(tables, more, recorder));
        let room = match room {
            None | Some(Err(GpuError::Budget { .. })) if !recorder.is_for_host() => {
                let counted = PruneUniform {
                    build_mode: abi::BUILD_COUNT_ONLY,
                    ..prune
                };
                self.encode(tables, &body.texture, (making, blocks), counted, recorder)
                    .await?;
                recorder.submit()?;
                tables.accounting.take_known(gpu).await?;
                more = [abi::COUNTER_BRICKS, abi::COUNTER_MIXED]
                    .map(|counter| tables.accounting.known.get(counter));
                make_room(tables, more, recorder)?
            }
            Some(room) => room?,
            None => None,
        };
        if let Some(moved) = room {
            body.set_texture(moved);
        }
        self.encode(tables, &body.texture, (making, blocks), prune, recorder)
            .await?;
        let accounting = &mut tables.accounting;
        accounting.record_upper_bound(gpu, more, recorder)
    }

    async fn encode(
        &self,
        tables: &BrickTables,
        texture: &wgpu::Texture,
        (making, blocks): (&mut BuildTables, &BlockTables),
        prune: PruneUniform,
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let program = self.live.program();
        let layout = &tables.layout;
        let [chunk, chunks] = chunks(layout, blocks.longest(), blocks.cells());
        let order = BuildParams {
            words: BrickBuildUniform {
                chunk,
                // Without cells to sample, there is one empty chunk.
                chunks: chunks.max(1),
                pool_x: tables.pool[0],
                pool_y: tables.pool[1],
                capacity: tables.pool.iter().product(),
                mixed: tables.mixed as u32,
                table: tables.cells.described(),
                ..layout.build_uniform(program)
            },
            fill: layout
                .encoding()
                .fill_uniform(program, layout.voxel_grid(), 0),
            prune,
            instructions: &making.instructions,
            length: blocks.instructions.len(),
            mixes: program.materials().len() > 1,
        };
        let site = BrickTargets {
            texture,
            cells: &tables.cells.buffer,
            materials: &tables.materials,
            counters: &tables.accounting.counters,
        };
        let scratch = &mut making.scratch;
        let build = BoundBuild::new(self.field, scratch, &site, &order)?;
        build.measure(scratch, &order, recorder).await?;
        if prune.build_mode == abi::BUILD_COUNT_ONLY {
            return Ok(());
        }
        build.fill(scratch, &order, recorder).await
    }
}
