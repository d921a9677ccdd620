//! The passes of a build.

use super::lists::Lists;
use super::{BrickTables, PLACES, march_words, pool_for, pool_texture};
use crate::bake::{Bake, Groups, StagesMs};
use crate::field::check_depth;
use crate::pass::{
    ARGUMENTS, BRICK_MATERIALS, Bind, CANDIDATES, CELLS, COUNTERS, FIELD_BINDS, FILL, LISTS, PRUNE,
    TABLES_WGSL, TEXELS, VOLUME, entry, layout, pipelines,
};
use crate::table::Table;
use crate::volume::{format_of, read_table, uniform_of};
use crate::{GpuError, GpuField, GpuVolume};
use argil_abi::{self as abi, Fill, Prune, Volume as Words};
use argil_field::Program;
use argil_volume::{BrickLayout, wgsl};

/// Instructions times samples that one dispatch may take on.
const WORK_A_DISPATCH: u64 = 4_000_000_000;
/// Most bricks that one dispatch samples.
const MOST_BRICKS_A_DISPATCH: u64 = 32_768;
/// Threads that sample a brick.
const BRICK_GROUP: u32 = 256;

/// Evaluations that pruning takes as long as, with its walks along the list.
const EVALUATIONS_TO_PRUNE: u64 = 4;

/// The bindings of a build, as the shader names them.
const BINDS_WGSL: &str = "
@group(0) @binding(8) var<uniform> volume: Volume;
@group(0) @binding(18) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(19) var<storage, read_write> words: array<u32>;
@group(0) @binding(20) var<storage, read_write> brick_materials: array<u32>;
@group(0) @binding(21) var<storage, read_write> near_cells: array<u32>;
@group(0) @binding(22) var<storage, read_write> counters: array<atomic<u32>>;
@group(0) @binding(24) var<storage, read_write> lists: array<u32>;
@group(0) @binding(25) var<uniform> prune: Prune;
";

/// The passes of a build, and its tables.
pub(super) struct Build<'a> {
    field: &'a GpuField,
    measures: BrickLayout,
    pub words: Words,
    fill: Fill,
    pool: [u32; 3],
    layout: wgpu::BindGroupLayout,
    plan_layout: wgpu::BindGroupLayout,
    begin_lists: wgpu::ComputePipeline,
    prune_parts: wgpu::ComputePipeline,
    prune_cells: wgpu::ComputePipeline,
    measure: wgpu::ComputePipeline,
    plan: wgpu::ComputePipeline,
    fill_bricks: wgpu::ComputePipeline,
    fill_materials: wgpu::ComputePipeline,
    settle: wgpu::ComputePipeline,
    words_uniform: wgpu::Buffer,
    fill_uniform: wgpu::Buffer,
    prune_uniform: wgpu::Buffer,
    lists: Lists,
    arguments: wgpu::Buffer,
    cells: Table,
    materials: Table,
    candidates: Table,
    counters: Table,
}

impl<'a> Build<'a> {
    /// For a grid with about so many bricks.
    pub fn new(
        field: &'a GpuField,
        program: &Program,
        measures: BrickLayout,
        bricks: u64,
    ) -> Result<Self, GpuError> {
        check_depth(program)?;
        let gpu = field.gpu();
        let samples = u64::from(measures.brick_samples());
        let each = samples
            .div_ceil(u64::from(BRICK_GROUP))
            .max(EVALUATIONS_TO_PRUNE);
        if u64::from(field.budget) < each {
            return Err(GpuError::TooLong {
                name: gpu.info.name.clone(),
                iterations: u64::from(field.budget),
                limit: each,
            });
        }
        let cell_count: u64 = measures.grid.to_array().map(u64::from).iter().product();
        let work = samples * field.length() as u64;
        let chunk = (WORK_A_DISPATCH / work.max(1)).clamp(64, MOST_BRICKS_A_DISPATCH);
        let chunks = cell_count.div_ceil(chunk);
        let words = Words {
            chunk: chunk as u32,
            chunks: chunks as u32,
            ..measures.words(program)
        };
        let bits = measures.encoding.bits;
        let mut cells = Table::new("cells");
        cells.reserve_exact(gpu, 4 * measures.word_count())?;
        let mut candidates = Table::new("cells near the surface");
        candidates.reserve_exact(gpu, 4 * cell_count)?;
        let mut counters = Table::new("counters");
        counters.reserve_exact(gpu, 16)?;
        let lists = Lists::new(
            gpu,
            program,
            field.length(),
            &measures,
            cell_count.min(4 * bricks),
        )?;
        let (words_uniform, fill_uniform, prune_uniform, arguments) = gpu.checked(|| {
            let arguments = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("bricks to fill"),
                size: (24 * chunks).next_multiple_of(16),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            });
            (
                uniform_of::<Words>(gpu, "volume"),
                uniform_of::<Fill>(gpu, "fill"),
                uniform_of::<Prune>(gpu, "prune"),
                arguments,
            )
        })?;
        let source = [
            &argil_abi::wgsl(),
            TABLES_WGSL,
            &crate::dense::target_wgsl(bits),
            BINDS_WGSL,
            &field.opcodes.pruning_wgsl(),
            wgsl::FILL,
            wgsl::WORDS,
            wgsl::MATERIAL,
            wgsl::SPARSE,
        ]
        .concat();
        let mut binds = FIELD_BINDS.to_vec();
        binds.extend([
            Bind::Uniform(VOLUME),
            Bind::Uniform(FILL),
            Bind::Target(TEXELS, format_of(bits).0),
            Bind::Write(CELLS),
            Bind::Write(CANDIDATES),
            Bind::Write(COUNTERS),
            Bind::Write(BRICK_MATERIALS),
            Bind::Write(LISTS),
            Bind::Uniform(PRUNE),
        ]);
        let layout = gpu.checked(|| self::layout(gpu, "Bricks::build", &binds))?;
        let constants = [("BRICK_GROUP", f64::from(BRICK_GROUP))];
        let entry_points = [
            "begin_lists",
            "measure",
            "fill_bricks",
            "fill_materials",
            "settle",
        ];
        let [begin_lists, measure, fill_bricks, fill_materials, settle] =
            pipelines(gpu, source.clone(), &layout, &constants, entry_points)?;
        let marking = [constants[0], ("MARKING", 1.0)];
        let entry_points = ["prune_parts", "prune_cells"];
        let [prune_parts, prune_cells] =
            pipelines(gpu, source.clone(), &layout, &marking, entry_points)?;
        // What says how much is dispatched is not bound where that is dispatched.
        let binds = [
            Bind::Uniform(VOLUME),
            Bind::Write(ARGUMENTS),
            Bind::Write(COUNTERS),
        ];
        let plan_layout = gpu.checked(|| self::layout(gpu, "Bricks::plan", &binds))?;
        let [plan] = pipelines(gpu, source, &plan_layout, &[], ["plan"])?;
        Ok(Self {
            field,
            measures,
            words,
            fill: measures.encoding.fill(program, &measures.lattice, 0),
            pool: [1; 3],
            layout,
            plan_layout,
            begin_lists,
            prune_parts,
            prune_cells,
            measure,
            plan,
            fill_bricks,
            fill_materials,
            settle,
            words_uniform,
            fill_uniform,
            prune_uniform,
            lists,
            arguments,
            cells,
            materials: Table::new("bricks' materials"),
            candidates,
            counters,
        })
    }

    /// Build into a pool with room for so many bricks.
    pub fn run(
        &mut self,
        room: u64,
        mixed_room: u64,
    ) -> Result<(wgpu::Texture, StagesMs), GpuError> {
        let gpu = self.field.gpu();
        self.pool = pool_for(gpu, &self.measures, room)?;
        let texture = pool_texture(gpu, &self.measures, self.pool)?;
        self.words.pool_x = self.pool[0];
        self.words.pool_y = self.pool[1];
        self.words.capacity = self.pool.iter().product();
        self.words.mixed = mixed_room as u32;
        let bytes = 4 * u64::from(self.words.capacity) + 8 * PLACES * mixed_room;
        self.materials.reserve_exact(gpu, bytes)?;
        gpu.queue
            .write_buffer(&self.words_uniform, 0, bytemuck::bytes_of(&self.words));
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let bind_group = gpu.checked(|| {
            let mut entries: Vec<_> = self.field.table_bindings().collect();
            entries.push(entry(VOLUME, &self.words_uniform));
            entries.push(entry(FILL, &self.fill_uniform));
            entries.push(entry(PRUNE, &self.prune_uniform));
            entries.extend(self.lists.table.binding(LISTS));
            entries.push(wgpu::BindGroupEntry {
                binding: TEXELS,
                resource: wgpu::BindingResource::TextureView(&view),
            });
            entries.extend(self.cells.binding(CELLS));
            entries.extend(self.candidates.binding(CANDIDATES));
            entries.extend(self.counters.binding(COUNTERS));
            entries.extend(self.materials.binding(BRICK_MATERIALS));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Bricks::build"),
                layout: &self.layout,
                entries: &entries,
            })
        })?;
        let plan_group = gpu.checked(|| {
            let mut entries = vec![
                entry(VOLUME, &self.words_uniform),
                entry(ARGUMENTS, &self.arguments),
            ];
            entries.extend(self.counters.binding(COUNTERS));
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("Bricks::plan"),
                layout: &self.plan_layout,
                entries: &entries,
            })
        })?;
        gpu.checked(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for table in [&self.counters, &self.materials] {
                if let Some(buffer) = table.buffer() {
                    encoder.clear_buffer(buffer, 0, None);
                }
            }
            gpu.queue.submit([encoder.finish()]);
        })?;

        let rows = |groups: u32| {
            Groups::Direct([
                groups.min(abi::DISPATCH_ROW),
                groups.div_ceil(abi::DISPATCH_ROW),
                1,
            ])
        };
        let blocks = self.measures.block_count() as u32;
        let mut bake = Bake::new(gpu)?;
        for (nth, level) in self.lists.levels.iter().enumerate() {
            gpu.queue
                .write_buffer(&self.prune_uniform, 0, bytemuck::bytes_of(level));
            if nth == 0 {
                let groups = rows((self.field.length() as u32).div_ceil(64));
                bake.pass("prune", &self.begin_lists, &bind_group, groups)?;
            }
            let parts = level.parts_x * level.parts_y * level.parts_z;
            bake.pass(
                "prune",
                &self.prune_parts,
                &bind_group,
                rows(parts.div_ceil(64)),
            )?;
        }
        bake.pass("measure", &self.measure, &bind_group, rows(blocks))?;
        let groups = Groups::Direct([self.words.chunks.div_ceil(64), 1, 1]);
        bake.pass("measure", &self.plan, &plan_group, groups)?;
        for chunk in 0..self.words.chunks {
            let fill = Fill {
                first_layer: chunk * self.words.chunk,
                ..self.fill
            };
            gpu.queue
                .write_buffer(&self.fill_uniform, 0, bytemuck::bytes_of(&fill));
            let groups = Groups::Indirect(&self.arguments, 24 * u64::from(chunk) + 12);
            bake.pass("prune", &self.prune_cells, &bind_group, groups)?;
            let groups = Groups::Indirect(&self.arguments, 24 * u64::from(chunk));
            bake.pass("fill", &self.fill_bricks, &bind_group, groups)?;
            if mixed_room > 0 {
                bake.pass("materials", &self.fill_materials, &bind_group, groups)?;
            }
        }
        let groups = rows(blocks.div_ceil(64));
        bake.pass("settle", &self.settle, &bind_group, groups)?;
        Ok((texture, bake.finish()?))
    }

    /// How many bricks the build has needed, and how many of them are mixed.
    pub fn counts(&self) -> Result<[u64; 2], GpuError> {
        let counters = read_table(self.field.gpu(), &self.counters, 16)?;
        let count = |counter: u32| {
            let at = 4 * counter as usize;
            let word = counters.get(at..at + 4).and_then(|w| w.try_into().ok());
            u64::from(u32::from_le_bytes(word.unwrap_or_default()))
        };
        Ok([abi::COUNTER_BRICKS, abi::COUNTER_MIXED].map(count))
    }

    fn shrink(
        &mut self,
        texture: wgpu::Texture,
        count: u64,
        mixed: u64,
    ) -> Result<wgpu::Texture, GpuError> {
        let gpu = self.field.gpu();
        let [x, y, z] = self.pool;
        let layers = count.div_ceil(u64::from(x) * u64::from(y)).max(1) as u32;
        if layers >= z && mixed >= u64::from(self.words.mixed) {
            return Ok(texture);
        }
        let pool = [x, y, layers];
        let smaller = pool_texture(gpu, &self.measures, pool)?;
        let capacity: u64 = pool.map(u64::from).iter().product();
        let looks = 4 * capacity;
        let of_mixed = 8 * PLACES * mixed;
        let mut materials = Table::new("bricks' materials");
        materials.reserve_exact(gpu, looks + of_mixed)?;
        let from_mixed = 4 * u64::from(self.words.capacity);
        gpu.checked(|| {
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_texture(
                texture.as_image_copy(),
                smaller.as_image_copy(),
                smaller.size(),
            );
            if let (Some(from), Some(to)) = (self.materials.buffer(), materials.buffer()) {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, looks);
                encoder.copy_buffer_to_buffer(from, from_mixed, to, looks, of_mixed);
            }
            gpu.queue.submit([encoder.finish()]);
        })?;
        (self.pool, self.materials) = (pool, materials);
        Ok(smaller)
    }

    /// What was built, without the room that it does not need.
    pub fn finish(
        mut self,
        texture: wgpu::Texture,
        count: u64,
        mixed: u64,
    ) -> Result<GpuVolume, GpuError> {
        let texture = self.shrink(texture, count, mixed)?;
        let words = march_words(&self.measures, self.pool, self.words.lipschitz);
        let tables = BrickTables {
            layout: self.measures,
            cells: self.cells,
            materials: self.materials,
            mixed,
            pool: self.pool,
            count,
            lipschitz: self.words.lipschitz,
        };
        GpuVolume::of_bricks(self.field, texture, words, tables)
    }
}
