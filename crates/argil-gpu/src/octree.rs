//! `Octree::select`, `Octree::sort`, `Octree::fill`, `Octree::build`: no step of it waits for the CPU.

use crate::StagesMs;
use crate::bake::{Bake, Groups};
use crate::dense::{layers, target_wgsl, tile_side};
use crate::pass::{
    ARGUMENTS, Bind, CENTERS, FIELD_BINDS, FILL, KEYS, NODES, OCCUPIED, TABLES_WGSL, TEXELS,
    TREE_WORDS, VOLUME, entry, layout, pipelines,
};
use crate::volume::{Kind, TreeTables, texture, uniform_of};
use crate::{Gpu, GpuError, GpuField, GpuVolume, Order};
use argil_abi::{self as abi, Fill, Node, Volume as Words};
use argil_field::Program;
use argil_volume::{Keep, Layout, wgsl};

/// Most cells for the enumeration sort.
const MOST_TO_ENUMERATE: u32 = 32_768;

/// The bindings of each module, as the shaders name them.
const SELECT_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: Volume;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read_write> tree_words: array<atomic<u32>>;
@group(0) @binding(BIND_OCCUPIED) var<storage, read_write> occupied: array<atomic<u32>>;
@group(0) @binding(BIND_CENTERS) var<storage, read_write> centers: array<f32>;
";
const TREE_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: Volume;
@group(0) @binding(BIND_NODES) var<storage, read_write> node_words: array<atomic<u32>>;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read_write> tree_words: array<atomic<u32>>;
@group(0) @binding(BIND_OCCUPIED) var<storage, read_write> occupied: array<atomic<u32>>;
@group(0) @binding(BIND_KEYS) var<storage, read_write> keys: array<u32>;
@group(0) @binding(BIND_ARGUMENTS) var<storage, read_write> arguments: array<u32>;
";
const BRICKS_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: Volume;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read> tree_words: array<u32>;
@group(0) @binding(BIND_CENTERS) var<storage, read> centers: array<f32>;
@group(0) @binding(BIND_KEYS) var<storage, read> keys: array<u32>;
";

/// A pass's layout and its pipelines.
type Passes<const N: usize> = (wgpu::BindGroupLayout, [wgpu::ComputePipeline; N]);

impl GpuVolume {
    /// Build an octree from a field; what the stages took.
    pub async fn octree(
        field: &GpuField,
        program: &Program,
        measures: Layout,
        keep: Keep,
        order: Order,
    ) -> Result<(Self, StagesMs), GpuError> {
        let gpu = field.gpu();
        let bits = measures.encoding.bits;
        let code_count = measures.code_count();
        if order == Order::Enumerated && code_count > MOST_TO_ENUMERATE {
            return Err(GpuError::TooManyToEnumerate {
                codes: code_count,
                limit: MOST_TO_ENUMERATE,
            });
        }
        let texture = texture(gpu, &measures.lattice, bits, 1)?;

        // Tables with room for all bricks.
        let capacity = measures.capacity();
        let node_capacity: u64 = (0..measures.depth)
            .map(|level| capacity.min(1 << (3 * (measures.depth - 1 - level))))
            .sum();
        let mut tables = TreeTables::new(measures);
        tables
            .words
            .reserve_exact(gpu, 4 * u64::from(abi::TREE_WORDS))?;
        tables
            .keys
            .reserve_exact(gpu, 4 * (capacity + node_capacity))?;
        tables
            .nodes
            .reserve_exact(gpu, size_of::<Node>() as u64 * node_capacity)?;
        let mut occupied = crate::table::Table::new("occupied cells");
        let occupied_words = match order {
            Order::Counted => u64::from(code_count.div_ceil(32)),
            Order::Enumerated => capacity,
        };
        occupied.reserve_exact(gpu, 4 * occupied_words)?;
        let mut centers = crate::table::Table::new("distances of cells");
        centers.reserve_exact(gpu, 4 * u64::from(code_count))?;
        let (words_uniform, fill_uniform, arguments) = gpu.checked(|| {
            let arguments = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("bricks to fill"),
                size: 16,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            });
            let words = uniform_of::<Words>(gpu, "volume");
            (words, uniform_of::<Fill>(gpu, "fill"), arguments)
        })?;
        let words = measures.words(program, keep);
        gpu.queue
            .write_buffer(&words_uniform, 0, bytemuck::bytes_of(&words));

        // Passes and their bindings.
        let (select_layout, [select_bits, select_list]) = select_passes(gpu, field)?;
        let (tree_layout, [compact, rank, build]) = tree_passes(gpu)?;
        let side = tile_side(gpu, measures.brick);
        let (bricks_layout, [fill_bricks, fill_vacant]) = bricks_passes(gpu, field, bits, side)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let volume = || entry(VOLUME, &words_uniform);
        let group = |label, layout, entries: &[wgpu::BindGroupEntry<'_>]| {
            gpu.checked(|| {
                gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(label),
                    layout,
                    entries,
                })
            })
        };
        let mut entries: Vec<_> = field.table_bindings().chain([volume()]).collect();
        entries.extend(tables.words.binding(TREE_WORDS));
        entries.extend(occupied.binding(OCCUPIED));
        entries.extend(centers.binding(CENTERS));
        let select_group = group("Octree::select", &select_layout, &entries)?;
        let mut entries = vec![volume(), entry(ARGUMENTS, &arguments)];
        entries.extend(tables.nodes.binding(NODES));
        entries.extend(tables.words.binding(TREE_WORDS));
        entries.extend(occupied.binding(OCCUPIED));
        entries.extend(tables.keys.binding(KEYS));
        let tree_group = group("Octree::tree", &tree_layout, &entries)?;
        let mut entries: Vec<_> = field.table_bindings().chain([volume()]).collect();
        entries.push(entry(FILL, &fill_uniform));
        entries.push(wgpu::BindGroupEntry {
            binding: TEXELS,
            resource: wgpu::BindingResource::TextureView(&view),
        });
        entries.extend(tables.words.binding(TREE_WORDS));
        entries.extend(centers.binding(CENTERS));
        entries.extend(tables.keys.binding(KEYS));
        let bricks_group = group("Octree::fill", &bricks_layout, &entries)?;

        // Select and sort.
        clear(gpu, [&tables.words, &tables.nodes, &occupied])?;
        let mut bake = Bake::new(gpu)?;
        let groups = code_count.div_ceil(64);
        let groups = Groups::Direct([
            groups.min(abi::DISPATCH_ROW),
            groups.div_ceil(abi::DISPATCH_ROW),
            1,
        ]);
        match order {
            Order::Counted => {
                bake.pass("select", &select_bits, &select_group, groups)
                    .await?;
                bake.pass("sort", &compact, &tree_group, Groups::Direct([1, 1, 1]))
                    .await?;
            }
            Order::Enumerated => {
                bake.pass("select", &select_list, &select_group, groups)
                    .await?;
                let groups = (capacity as u32).div_ceil(256);
                bake.pass("sort", &rank, &tree_group, Groups::Direct([groups, 1, 1]))
                    .await?;
            }
        }

        // Fill.
        let fill = Fill {
            tile: measures.brick,
            ..measures.encoding.fill(program, &measures.lattice, 0)
        };
        let area = u64::from(measures.brick * measures.brick);
        let work = capacity * area * field.length() as u64;
        for (first, count) in layers(field, work, measures.brick, side) {
            let fill = Fill {
                first_layer: first,
                layer_count: count,
                ..fill
            };
            gpu.queue
                .write_buffer(&fill_uniform, 0, bytemuck::bytes_of(&fill));
            let groups = Groups::Indirect(&arguments, 0);
            bake.pass("fill", &fill_bricks, &bricks_group, groups)
                .await?;
        }
        let groups = Groups::Direct(measures.grid.to_array());
        bake.pass("vacant", &fill_vacant, &bricks_group, groups)
            .await?;

        // Build.
        bake.pass("tree", &build, &tree_group, Groups::Direct([1, 1, 1]))
            .await?;
        let stages = bake.finish().await?;
        let (lattice, encoding) = (measures.lattice, measures.encoding);
        let kind = Kind::Octree(Box::new(tables));
        let volume = Self::new(field, lattice, encoding, texture, words, kind)?;
        Ok((volume, stages))
    }
}

fn select_passes(gpu: &Gpu, field: &GpuField) -> Result<Passes<2>, GpuError> {
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        SELECT_BINDS_WGSL,
        field.field_wgsl(),
        argil_math::morton_wgsl(),
        wgsl::SELECT,
    ]
    .concat();
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniform(VOLUME),
        Bind::Write(TREE_WORDS),
        Bind::Write(OCCUPIED),
        Bind::Write(CENTERS),
    ]);
    let layout = gpu.checked(|| layout(gpu, "Octree::select", &binds))?;
    let pipelines = pipelines(gpu, source, &layout, &[], ["select_bits", "select_list"])?;
    Ok((layout, pipelines))
}

fn tree_passes(gpu: &Gpu) -> Result<Passes<3>, GpuError> {
    let source = [&argil_abi::wgsl(), TREE_BINDS_WGSL, wgsl::TREE].concat();
    let binds = [
        Bind::Uniform(VOLUME),
        Bind::Write(NODES),
        Bind::Write(TREE_WORDS),
        Bind::Write(OCCUPIED),
        Bind::Write(KEYS),
        Bind::Write(ARGUMENTS),
    ];
    let layout = gpu.checked(|| layout(gpu, "Octree::tree", &binds))?;
    let pipelines = pipelines(gpu, source, &layout, &[], ["compact", "rank", "build"])?;
    Ok((layout, pipelines))
}

fn bricks_passes(
    gpu: &Gpu,
    field: &GpuField,
    bits: argil_volume::Bits,
    side: u32,
) -> Result<Passes<2>, GpuError> {
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        &target_wgsl(gpu.texels(bits)),
        BRICKS_BINDS_WGSL,
        field.field_wgsl(),
        argil_math::morton_wgsl(),
        wgsl::FILL,
        wgsl::BRICKS,
    ]
    .concat();
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniform(VOLUME),
        Bind::Uniform(FILL),
        Bind::Target(TEXELS, gpu.texels(bits).format()),
        Bind::Read(TREE_WORDS),
        Bind::Read(CENTERS),
        Bind::Read(KEYS),
    ]);
    let layout = gpu.checked(|| layout(gpu, "Octree::fill", &binds))?;
    let constants = [("TILE_SIDE", f64::from(side))];
    let entry_points = ["fill_bricks", "fill_vacant"];
    let pipelines = pipelines(gpu, source, &layout, &constants, entry_points)?;
    Ok((layout, pipelines))
}

/// Set tables to zero.
fn clear<const N: usize>(gpu: &Gpu, tables: [&crate::table::Table; N]) -> Result<(), GpuError> {
    gpu.checked(|| {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for buffer in tables.into_iter().filter_map(|t| t.buffer()) {
            encoder.clear_buffer(buffer, 0, None);
        }
        gpu.queue.submit([encoder.finish()]);
    })
}
