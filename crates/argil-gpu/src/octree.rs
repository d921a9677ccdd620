//! `Octree::select`, `Octree::sort`, `Octree::fill`, `Octree::build`: no step of it waits for the CPU.

use crate::StagesMs;
use crate::bake::{Bake, Groups};
use crate::dense::{dense_words, layers, target_wgsl, tile_side};
use crate::pass::{
    ARGUMENTS, Bind, CENTERS, FIELD_BINDS, FILL, KEYS, LINEAR, NODES, OCCUPIED, STORED,
    TABLES_WGSL, TEXELS, TREE_WORDS, VOLUME, entry, layout, pipelines,
};
use crate::pass::{TREE_WGSL, VOLUME_WGSL};
use crate::resources::{read_level, read_table, texture, uniform_of, upload};
use crate::table::Table;
use crate::volume::{Body, Kind, Upload};
use crate::way::{Bound, Way};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuField, GpuVolume, Order};
use argil_abi::{self as abi, Fill, Node, Volume as Words};
use argil_field::Program;
use argil_volume::{Keep, Layout, Octree, Tree, TreeInfo, Volume, VolumeInfo, wgsl};

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

/// An octree's tables.
struct TreeTables {
    layout: Layout,
    keys: Table,
    nodes: Table,
    words: Table,
}

static OCTREE: Way = Way {
    name: "octree",
    march: argil_march::wgsl::OCTREE,
    tables: || [VOLUME_WGSL, TREE_WGSL, argil_math::morton_wgsl()].concat(),
    binds: &[
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Filter(LINEAR),
        Bind::Read(NODES),
        Bind::Read(TREE_WORDS),
    ],
    constants: &[],
    draws: false,
    is_exact: false,
    has_cones: false,
};

impl Kind for TreeTables {
    fn way(&self) -> &'static Way {
        &OCTREE
    }

    fn bind(&self, bound: &mut Vec<Bound>) {
        bound.extend(self.nodes.bound(NODES));
        bound.extend(self.words.bound(TREE_WORDS));
    }

    fn memory_bytes(&self, body: &Body) -> u64 {
        body.texture_bytes() + self.keys.size() + self.nodes.size() + self.words.size()
    }

    fn info<'a>(&'a self, info: VolumeInfo, gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move {
            let words = self.read_words(gpu).await?;
            let word = |i: u32| u64::from(words.get(i as usize).copied().unwrap_or(0));
            let mut info = info;
            info.tree = Some(TreeInfo {
                layout: self.layout,
                bricks: word(abi::TREE_BRICKS),
                nodes: word(abi::TREE_NODES),
            });
            Ok(info)
        })
    }

    fn read<'a>(&'a self, body: &'a Body, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move {
            let tree = self.read_tree(gpu).await?;
            let measures = (&body.lattice, body.encoding.bits);
            let texels = read_level(gpu, &body.texture, measures, 0).await?;
            let octree = Octree::from_parts(self.layout, tree, texels);
            Ok(Volume::Octree(octree.ok_or_else(GpuError::odd_volume)?))
        })
    }
}

impl Upload for Octree {
    fn upload<'a>(&'a self, field: &'a GpuField) -> Work<'a, GpuVolume> {
        Box::pin(async move {
            let gpu = field.gpu();
            let layout = *self.layout();
            let texture = texture(gpu, &layout.lattice, layout.encoding.bits, 1)?;
            upload(gpu, &texture, &layout.lattice, 0, self.texels()).await?;
            let tree = self.tree();
            let mut tables = TreeTables::new(layout);
            let mut words = [0u32; abi::TREE_WORDS as usize];
            words[abi::TREE_BRICKS as usize] = tree.codes().len() as u32;
            words[abi::TREE_NODES as usize] = tree.nodes().len() as u32;
            let levels = &mut words[abi::TREE_LEVELS as usize..];
            for (to, from) in levels.iter_mut().zip(tree.levels()) {
                *to = *from;
            }
            tables.words.write(gpu, &words)?;
            tables.keys.write(gpu, tree.codes())?;
            tables.nodes.write(gpu, tree.nodes())?;
            let words = octree_words(&layout);
            let measures = (layout.lattice, layout.encoding);
            GpuVolume::new(field, measures, texture, words, tables)
        })
    }
}

impl TreeTables {
    fn new(layout: Layout) -> Self {
        Self {
            layout,
            keys: Table::new("bricks' codes"),
            nodes: Table::new("nodes"),
            words: Table::new("tree"),
        }
    }

    async fn read_words(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let bytes = read_table(gpu, &self.words, 4 * u64::from(abi::TREE_WORDS)).await?;
        Ok(bytes
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }

    /// Bring the tree back.
    async fn read_tree(&self, gpu: &Gpu) -> Result<Tree, GpuError> {
        let words = self.read_words(gpu).await?;
        let word = |i: u32| words.get(i as usize).copied().unwrap_or(0);
        let (bricks, nodes) = (word(abi::TREE_BRICKS), word(abi::TREE_NODES));
        let codes = read_table(gpu, &self.keys, 4 * u64::from(bricks))
            .await?
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let nodes = read_table(
            gpu,
            &self.nodes,
            size_of::<Node>() as u64 * u64::from(nodes),
        )
        .await?
        .chunks_exact(size_of::<Node>())
        .map(bytemuck::pod_read_unaligned)
        .collect();
        let levels = (0..self.layout.depth)
            .map(|level| word(abi::TREE_LEVELS + level))
            .collect();
        Ok(Tree::from_parts(codes, nodes, levels))
    }
}

/// Words for marching, which needs nothing of the field.
fn octree_words(layout: &Layout) -> Words {
    Words {
        grid_x: layout.grid.x,
        grid_y: layout.grid.y,
        grid_z: layout.grid.z,
        brick: layout.brick,
        depth: layout.depth,
        code_count: layout.code_count(),
        ..dense_words(&layout.lattice, &layout.encoding, 1)
    }
}

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
        let mut occupied = Table::new("occupied cells");
        let occupied_words = match order {
            Order::Counted => u64::from(code_count.div_ceil(32)),
            Order::Enumerated => capacity,
        };
        occupied.reserve_exact(gpu, 4 * occupied_words)?;
        let mut centers = Table::new("distances of cells");
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
        let volume = Self::new(field, (lattice, encoding), texture, words, tables)?;
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
