//! Sparse bricks on the device: building and upload. The passes of a build do not wait for the CPU.
//!
//! The pool is one 3D texture with whole bricks along each side, so that a filter finds a brick's samples side by
//! side, and no binding limit matters. It is created with room for as many bricks as a surface of the grid's size
//! needs. After the build its counters are read. Unused space is released, and a build that needs more runs again.

mod build;
mod build_tables;
mod cells;
mod download;
mod edit;
mod light;
mod list_arena;
mod passes;
mod pool;
mod pool_accounting;
mod repack;
mod tables;

use self::build::{BrickBuilder, volume_of};
use self::cells::GpuCellTable;
use self::download::read;
use self::light::GpuLight;
use self::passes::{build_module, columns_module, plan_module};
use self::pool_accounting::PoolAccounting;
use self::repack::repack_module;
use self::tables::{BrickTables, PLACES, bytes_of, pool_for, pool_texture};
use crate::bindings::{
    BRICK_MATERIALS, Bind, CELLS, CELLS_WGSL, LIGHT_STORED, LIGHT_WGSL, LIGHT_WORDS, LINEAR, LIVE,
    LIVE_WGSL, STORED, VOLUME, VOLUME_WGSL,
};
use crate::pass_module::PassModule;
use crate::resources::extent;
use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::trace_mode::{BoundResource, HostMode, PathMode, TraceMode};
use crate::volume::{ClipUpdate, EditContext, Upload, VolumeStorage, VolumeTables};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume, StageTimings};
use argil_abi::{BrickUniform, FrameUniform};
use argil_field::{Interpreter, Program};
use argil_math::Control;
use argil_volume::{
    BrickInfo, BrickLayout, BrickPendingEdits, Bricks, EditStats, Levels, PendingEdits, Volume,
    VolumeInfo, is_brick, wgsl,
};
use std::borrow::Cow;
use std::sync::Arc;

/// The uniform of bricks.
const BRICKS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickUniform;
";

/// What paths of light and shaders of a host read.
const BRICK_BINDS: [Bind; 5] = [
    Bind::Uniform(VOLUME),
    Bind::Texture(STORED),
    Bind::Filter(LINEAR),
    Bind::Read(CELLS),
    Bind::Read(BRICK_MATERIALS),
];

macro_rules! way {
    ($name:literal, $constants:expr) => {
        TraceMode {
            name: $name,
            more_name: concat!($name, " with more light"),
            march: argil_render::wgsl::BRICKS,
            tables: || {
                let bindings =
                    [BRICKS_WGSL, VOLUME_WGSL, CELLS_WGSL, LIGHT_WGSL, LIVE_WGSL].concat();
                bindings + wgsl::BRICK_CELLS + wgsl::BRICK_MATERIALS
            },
            binds: &[
                Bind::Uniform(VOLUME),
                Bind::Texture(STORED),
                Bind::Filter(LINEAR),
                Bind::Read(CELLS),
                Bind::Read(BRICK_MATERIALS),
                Bind::Words(LIGHT_WORDS),
                Bind::Texture(LIGHT_STORED),
                Bind::Write(LIVE),
            ],
            constants: $constants,
            draws: false,
            is_exact: false,
            paths: Some(PathMode {
                name: concat!("paths through ", $name),
                wgsl: argil_render::wgsl::BRICK_PATHS,
                binds: &BRICK_BINDS,
            }),
            host: Some(&BRICK_HOST),
            has_cones: true,
            by_lists: false,
        }
    };
}

/// Without node levels: a look-up costs nothing.
static FLAT: TraceMode = way!("bricks", &[("HAS_LEVELS", 0.0)]);
/// For a world so wide that its block table has node levels.
static WIDE: TraceMode = way!("wide bricks", &[]);

static BRICK_HOST: HostMode = HostMode {
    tables: || {
        let bindings = [BRICKS_WGSL, VOLUME_WGSL, CELLS_WGSL].concat();
        bindings + wgsl::BRICK_CELLS + wgsl::BRICK_MATERIALS
    },
    wgsl: argil_render::wgsl::BRICK_HOST,
    binds: &BRICK_BINDS,
};

/// Mixed bricks for which there is room, besides a quarter of all. What a build does not need is freed.
const MIXED_ROOM: u64 = 4096;

/// Returns how bricks are traced, without and with node levels.
pub(crate) fn brick_ways() -> [&'static TraceMode; 2] {
    [&FLAT, &WIDE]
}

/// Describes the modules that build bricks of a size.
pub(crate) fn brick_modules(
    interpreter: Interpreter,
    texels: TexelFormat,
    brick_size_voxels: u32,
) -> Vec<PassModule> {
    let build = build_module(&interpreter.pruning_wgsl(), texels, brick_size_voxels);
    let mut all = vec![build, plan_module(), repack_module(texels)];
    let columns = interpreter.column_wgsl();
    all.extend(columns.map(|text| columns_module(&text, texels, brick_size_voxels)));
    all
}

impl VolumeTables for BrickTables {
    fn way(&self) -> &'static TraceMode {
        if self.cells.table.levels() > 0 {
            &WIDE
        } else {
            &FLAT
        }
    }

    fn bind(&self, bound: &mut Vec<BoundResource>) {
        bound.extend(self.cells.buffer.bound(CELLS));
        bound.extend(self.materials.bound(BRICK_MATERIALS));
        self.light.bind(bound);
    }

    fn uniform(&self, _: &FrameUniform) -> Cow<'_, [u8]> {
        bytemuck::bytes_of(&self.uniform).into()
    }

    fn memory_bytes(&self, body: &VolumeStorage) -> u64 {
        let bricks: u64 = self.pool.map(u64::from).iter().product();
        let tables =
            self.cells.memory_bytes() + self.materials.size() + self.accounting.counters.size();
        let making = self
            .making
            .iter()
            .map(|(making, _)| making.size())
            .sum::<u64>();
        let brick = u64::from(self.layout.brick_samples()) * body.texel_bytes();
        bricks * brick + tables + making
    }

    fn info<'a>(&'a self, mut info: VolumeInfo, gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move {
            info.bricks = Some(BrickInfo {
                layout: self.layout,
                bricks: self.count(gpu).await?,
            });
            Ok(info)
        })
    }

    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move { Ok(Volume::Bricks(read(gpu, &body.texture, self).await?)) })
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        Some(Box::new(BrickPendingEdits::of(self.layout)))
    }

    fn grow(&mut self, body: &mut VolumeStorage, edits: &dyn PendingEdits) {
        if let Some(edits) = BrickPendingEdits::downcast_ref(edits) {
            self.grow_to(body, edits.layout);
        }
    }

    fn has_lost_edits(&self) -> bool {
        self.making
            .iter()
            .any(|(_, submission)| submission.is_dropped())
    }

    fn edit<'a>(&'a mut self, body: &'a mut VolumeStorage, edit: EditContext<'a>) -> Work<'a, ()> {
        Box::pin(self.edit_in(body, edit))
    }

    fn wait_for_counters<'a>(&'a mut self, gpu: &'a Gpu) -> Work<'a, EditStats> {
        Box::pin(self.wait_in(gpu))
    }

    fn trim<'a>(&'a mut self, body: &'a mut VolumeStorage, field: &'a GpuProgram) -> Work<'a, ()> {
        Box::pin(self.trim_in(body, field))
    }

    fn brick_layout(&self) -> Option<BrickLayout> {
        Some(self.layout)
    }

    fn light_memory_bytes(&self) -> u64 {
        self.light.memory_bytes()
    }

    fn set_light(&self, gpu: &Gpu, levels: Option<&Arc<Levels>>) -> Result<(), GpuError> {
        self.light.set(gpu, levels)
    }

    fn cut(&self) -> Option<ClipUpdate<'_>> {
        Some(ClipUpdate::Bricks(&self.cells.buffer, &self.uniform))
    }
}

impl Upload for Bricks {
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume> {
        Box::pin(GpuVolume::upload_bricks(field, self))
    }
}

/// Adds the timings of another run.
fn add(stages: &mut StageTimings, took: &StageTimings) {
    for &(stage, ms) in took {
        match stages.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, total)) => *total += ms,
            None => stages.push((stage, ms)),
        }
    }
}

impl GpuVolume {
    /// Builds sparse bricks from a field. Returns the volume and the timings.
    ///
    /// # Errors
    /// If pool and tables would exceed `budget` bytes.
    pub async fn bricks(
        field: &GpuProgram,
        program: &Program,
        measures: BrickLayout,
        budget: Option<u64>,
    ) -> Result<(Self, StageTimings), GpuError> {
        Self::bricks_with_control(field, program, measures, budget, &Control::default()).await
    }

    /// Builds as [`GpuVolume::bricks`] does, reports progress as the stage "blocks", and can be canceled.
    ///
    /// # Errors
    /// If pool and tables would exceed `budget` bytes, or if it was canceled.
    pub async fn bricks_with_control(
        field: &GpuProgram,
        program: &Program,
        measures: BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<(Self, StageTimings), GpuError> {
        let budget = budget.unwrap_or(u64::MAX);
        let mut build = BrickBuilder::new(field, program, measures, budget, control)?;
        let (cells, mut stages) = build.count(control).await?;
        // Only a program of several materials has mixed bricks.
        let mixes = program.materials().len() > 1;
        let mixed_for = |room: u64| match mixes {
            true => room.min(room / 4 + MIXED_ROOM),
            false => 0,
        };
        let needed = |build: &BrickBuilder<'_>, room: u64, mixed: u64| -> Result<u64, GpuError> {
            let pool = pool_for(field.gpu(), &measures, room)?;
            Ok(bytes_of(field.gpu(), &measures, build.cells(), pool, mixed))
        };
        // Few cells near the surface need no brick.
        let mut room = cells;
        while room > 1 && needed(&build, room, mixed_for(room))? > budget {
            room = room * 7 / 8;
        }
        let mut mixed_room = mixed_for(room);
        let check = |build: &BrickBuilder<'_>, bricks: u64, mixed: u64| {
            let needed = needed(build, bricks, mixed)?;
            if needed <= budget {
                return Ok(());
            }
            Err(GpuError::Budget {
                bricks,
                needed,
                budget,
            })
        };
        check(&build, room, mixed_room.min(1))?;
        loop {
            let (texture, took) = build.run(room, mixed_room, control).await?;
            add(&mut stages, &took);
            let [count, mixed] = build.counts().await?;
            if build.has_room_for(count, mixed) {
                return Ok((build.finish(&texture, count, mixed)?, stages));
            }
            check(&build, count, mixed)?;
            room = room.max(count);
            mixed_room = mixed_room.max(mixed);
            if needed(&build, room, mixed_room)? > budget {
                (room, mixed_room) = (count, mixed);
            }
        }
    }

    async fn upload_bricks(field: &GpuProgram, bricks: &Bricks) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let measures = *bricks.layout();
        let pool = pool_for(gpu, &measures, bricks.len() as u64)?;
        let texture = pool_texture(gpu, &measures, pool)?;
        let side = (measures.brick_size_voxels() + 1) as usize;
        let [width, height] = [pool[0] as usize * side, pool[1] as usize * side];
        let bytes = measures.encoding().format.bytes();
        let per_layer = (pool[0] * pool[1]) as usize;
        let samples = bricks.pool().bytes();
        let format = gpu.texels(measures.encoding().format);
        // One layer of bricks at a time.
        let mut staged = vec![0u8; width * height * side * bytes];
        for (z, layer) in samples.chunks(per_layer * side.pow(3) * bytes).enumerate() {
            for (at, brick) in layer.chunks_exact(side.pow(3) * bytes).enumerate() {
                let (bx, by) = (at % pool[0] as usize, at / pool[0] as usize);
                for (row, line) in brick.chunks_exact(side * bytes).enumerate() {
                    let (y, k) = (row % side, row / side);
                    let to = ((k * height + by * side + y) * width + bx * side) * bytes;
                    staged[to..to + line.len()].copy_from_slice(line);
                }
            }
            gpu.with_error_scope(|| {
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d {
                            x: 0,
                            y: 0,
                            z: (z * side) as u32,
                        },
                        aspect: wgpu::TextureAspect::All,
                    },
                    &format.texels_of(&staged),
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some((width * format.bytes()) as u32),
                        rows_per_image: Some(height as u32),
                    },
                    extent(width as u32, height as u32, side as u32),
                );
            })?;
            gpu.flush()?;
            gpu.wait().await?;
        }
        let words: Vec<u32> = bricks
            .words()
            .iter()
            .map(|&word| packed(word, pool))
            .collect();
        let table = bricks.table().clone();
        let cells = GpuCellTable::new(gpu, table, measures.far_length(), Some(&words))?;
        let mut looks = bricks.materials().to_vec();
        looks.resize(pool.iter().product::<u32>() as usize, 0);
        looks.extend(bricks.mixed().iter().flatten());
        let mut materials = StorageBuffer::new("bricks' materials");
        materials.write(gpu, &looks)?;
        let tables = BrickTables {
            layout: measures,
            cells,
            materials,
            mixed: (bricks.mixed().len() as u64) / PLACES,
            pool,
            accounting: PoolAccounting::new(
                gpu,
                bricks.len() as u64,
                bricks.mixed().len() as u64 / PLACES,
            )?,
            lipschitz: bricks.lipschitz(),
            making: Vec::new(),
            gone: Vec::new(),
            light: GpuLight::new(gpu)?,
            uniform: BrickUniform::default(),
        };
        volume_of(field, texture, tables)
    }
}

/// Returns a brick's position in the pool, ten bits per axis, as the device's words hold it.
fn packed(word: u32, [x, y, _]: [u32; 3]) -> u32 {
    if is_brick(word) {
        (word % x) | ((word / x % y) << 10) | ((word / x / y) << 20)
    } else {
        word
    }
}
