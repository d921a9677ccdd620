//! Building all bricks.

use super::lists;
use super::passes::{Order, Scratch, Site, check, chunks, make};
use super::pool::Ledger;
use super::{BrickTables, PLACES, march_words, pool_for, pool_texture};
use crate::bake::{Bake, StagesMs};
use crate::table::Table;
use crate::{GpuError, GpuField, GpuVolume};
use argil_abi::{self as abi, Prune, Volume as Words};
use argil_field::Program;
use argil_volume::BrickLayout;

/// The tables of a build.
pub(super) struct Build<'a> {
    field: &'a GpuField,
    layout: BrickLayout,
    pub words: Words,
    fill: abi::Fill,
    levels: Vec<Prune>,
    mixes: bool,
    pool: [u32; 3],
    scratch: Scratch,
    cells: Table,
    materials: Table,
    ledger: Ledger,
}

impl<'a> Build<'a> {
    /// For a grid with about so many bricks.
    pub fn new(
        field: &'a GpuField,
        program: &Program,
        layout: BrickLayout,
        bricks: u64,
    ) -> Result<Self, GpuError> {
        check(field, program, &layout)?;
        let gpu = field.gpu();
        let cell_count: u64 = layout.grid.to_array().map(u64::from).iter().product();
        let [chunk, chunks] = chunks(&layout, field.length(), cell_count);
        let words = Words {
            chunk,
            chunks,
            ..layout.words(program)
        };
        let mut cells = Table::new("cells");
        cells.reserve_exact(gpu, 4 * layout.word_count())?;
        let mut scratch = Scratch::new(gpu)?;
        scratch.candidates.reserve_exact(gpu, 4 * cell_count)?;
        let levels = lists::of_all(
            gpu,
            &mut scratch.lists,
            program,
            field.length(),
            &layout,
            cell_count.min(4 * bricks),
        )?;
        Ok(Self {
            field,
            layout,
            words,
            fill: layout.encoding.fill(program, &layout.lattice, 0),
            levels,
            mixes: program.materials().len() > 1,
            pool: [1; 3],
            scratch,
            cells,
            materials: Table::new("bricks' materials"),
            ledger: Ledger::new(gpu, 0, 0)?,
        })
    }

    /// Build into a pool with room for so many bricks.
    pub async fn run(
        &mut self,
        room: u64,
        mixed_room: u64,
    ) -> Result<(wgpu::Texture, StagesMs), GpuError> {
        let gpu = self.field.gpu();
        self.pool = pool_for(gpu, &self.layout, room)?;
        let texture = pool_texture(gpu, &self.layout, self.pool)?;
        self.words.pool_x = self.pool[0];
        self.words.pool_y = self.pool[1];
        self.words.capacity = self.pool.iter().product();
        self.words.mixed = mixed_room as u32;
        let bytes = 4 * u64::from(self.words.capacity) + 8 * PLACES * mixed_room;
        self.materials.reserve_exact(gpu, bytes)?;
        self.ledger = Ledger::new(gpu, 0, 0)?;
        gpu.checked(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(buffer) = self.materials.buffer() {
                encoder.clear_buffer(buffer, 0, None);
            }
            gpu.queue.submit([encoder.finish()]);
        })?;
        let site = Site {
            texture: &texture,
            cells: &self.cells,
            materials: &self.materials,
            counters: &self.ledger.counters,
        };
        let order = Order {
            words: self.words,
            fill: self.fill,
            levels: &self.levels,
            instrs: None,
            length: self.field.length(),
            mixes: self.mixes,
        };
        let mut bake = Bake::new(gpu)?;
        make(self.field, &mut self.scratch, &site, &order, &mut bake).await?;
        Ok((texture, bake.finish().await?))
    }

    /// How many bricks the build has needed, and how many of them are mixed.
    pub async fn counts(&mut self) -> Result<[u64; 2], GpuError> {
        self.ledger.settle(self.field.gpu()).await?;
        let counters = [abi::COUNTER_TOP, abi::COUNTER_TOP_MIXED];
        Ok(counters.map(|counter| self.ledger.known.get(counter)))
    }

    /// What was built, without the room that it does not need.
    pub fn finish(
        self,
        texture: &wgpu::Texture,
        count: u64,
        mixed: u64,
    ) -> Result<GpuVolume, GpuError> {
        let mut tables = BrickTables {
            layout: self.layout,
            cells: self.cells,
            materials: self.materials,
            mixed: u64::from(self.words.mixed),
            pool: self.pool,
            ledger: self.ledger,
            lipschitz: self.words.lipschitz,
            making: None,
        };
        let texture = tables.fit(self.field, texture, count, mixed)?;
        let words = march_words(&self.layout, tables.pool, tables.lipschitz);
        GpuVolume::of_bricks(self.field, texture, words, tables)
    }
}
