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
        let codes = measures.code_count();
        if order == Order::Enumerated && codes > MOST_TO_ENUMERATE {
            let limit = MOST_TO_ENUMERATE;
            return Err(GpuError::TooManyToEnumerate { codes, limit });
        }
        let words = measures.words(program, keep);
        let build = Build::new(field, measures, &words, order)?;
        let (tree_layout, [compact, rank, link]) = tree_passes(gpu)?;
        let tree_group = build.tree_group(&tree_layout)?;
        let mut bake = Bake::new(gpu)?;
        build.select(&mut bake, order).await?;
        let once = Groups::Direct([1, 1, 1]);
        let (sort, groups) = match order {
            Order::Counted => (&compact, once),
            Order::Enumerated => {
                let groups = (measures.capacity() as u32).div_ceil(256);
                (&rank, Groups::Direct([groups, 1, 1]))
            }
        };
        bake.pass("sort", sort, &tree_group, groups).await?;
        build.fill(&mut bake, program).await?;
        bake.pass("tree", &link, &tree_group, once).await?;
        let stages = bake.finish().await?;
        let (lattice, encoding) = (measures.lattice, measures.encoding);
        let Build {
            texture, tables, ..
        } = build;
        let volume = Self::new(field, (lattice, encoding), texture, words, tables)?;
        Ok((volume, stages))
    }
}

/// What a build works with; tables have room for all bricks.
struct Build<'a> {
    field: &'a GpuField,
    measures: Layout,
    texture: wgpu::Texture,
    tables: TreeTables,
    occupied: Table,
    centers: Table,
    volume: wgpu::Buffer,
    fill: wgpu::Buffer,
    arguments: wgpu::Buffer,
}

impl<'a> Build<'a> {
    fn new(
        field: &'a GpuField,
        measures: Layout,
        words: &Words,
        order: Order,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let texture = texture(gpu, &measures.lattice, measures.encoding.bits, 1)?;
        let capacity = measures.capacity();
        let nodes: u64 = (0..measures.depth)
            .map(|level| capacity.min(1 << (3 * (measures.depth - 1 - level))))
            .sum();
        let mut tables = TreeTables::new(measures);
        let bytes = 4 * u64::from(abi::TREE_WORDS);
        tables.words.reserve_exact(gpu, bytes)?;
        tables.keys.reserve_exact(gpu, 4 * (capacity + nodes))?;
        let bytes = size_of::<Node>() as u64 * nodes;
        tables.nodes.reserve_exact(gpu, bytes)?;
        let mut occupied = Table::new("occupied cells");
        let code_count = measures.code_count();
        let occupied_words = match order {
            Order::Counted => u64::from(code_count.div_ceil(32)),
            Order::Enumerated => capacity,
        };
        occupied.reserve_exact(gpu, 4 * occupied_words)?;
        let mut centers = Table::new("distances of cells");
        centers.reserve_exact(gpu, 4 * u64::from(code_count))?;
        let (volume, fill, arguments) = gpu.checked(|| {
            let arguments = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("bricks to fill"),
                size: 16,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            });
            let volume = uniform_of::<Words>(gpu, "volume");
            (volume, uniform_of::<Fill>(gpu, "fill"), arguments)
        })?;
        gpu.queue
            .write_buffer(&volume, 0, bytemuck::bytes_of(words));
        clear(gpu, [&tables.words, &tables.nodes, &occupied])?;
        Ok(Self {
            field,
            measures,
            texture,
            tables,
            occupied,
            centers,
            volume,
            fill,
            arguments,
        })
    }

    fn group(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        entries: &[wgpu::BindGroupEntry<'_>],
    ) -> Result<wgpu::BindGroup, GpuError> {
        let gpu = self.field.gpu();
        gpu.checked(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(label),
                layout,
                entries,
            })
        })
    }

    fn tree_group(&self, layout: &wgpu::BindGroupLayout) -> Result<wgpu::BindGroup, GpuError> {
        let mut entries = vec![
            entry(VOLUME, &self.volume),
            entry(ARGUMENTS, &self.arguments),
        ];
        entries.extend(self.tables.nodes.binding(NODES));
        entries.extend(self.tables.words.binding(TREE_WORDS));
        entries.extend(self.occupied.binding(OCCUPIED));
        entries.extend(self.tables.keys.binding(KEYS));
        self.group("Octree::tree", layout, &entries)
    }

    /// Find the cells in which the surface can be.
    async fn select(&self, bake: &mut Bake<'_>, order: Order) -> Result<(), GpuError> {
        let (layout, [bits, list]) = select_passes(self.field.gpu(), self.field)?;
        let mut entries: Vec<_> = self.field.table_bindings().collect();
        entries.push(entry(VOLUME, &self.volume));
        entries.extend(self.tables.words.binding(TREE_WORDS));
        entries.extend(self.occupied.binding(OCCUPIED));
        entries.extend(self.centers.binding(CENTERS));
        let group = self.group("Octree::select", &layout, &entries)?;
        let groups = self.measures.code_count().div_ceil(64);
        let groups = Groups::Direct([
            groups.min(abi::DISPATCH_ROW),
            groups.div_ceil(abi::DISPATCH_ROW),
            1,
        ]);
        let select = match order {
            Order::Counted => &bits,
            Order::Enumerated => &list,
        };
        bake.pass("select", select, &group, groups).await
    }

    /// Sample the bricks, and what tells of the cells without one.
    async fn fill(&self, bake: &mut Bake<'_>, program: &Program) -> Result<(), GpuError> {
        let (field, measures) = (self.field, &self.measures);
        let gpu = field.gpu();
        let side = tile_side(gpu, measures.brick);
        let bits = measures.encoding.bits;
        let (layout, [bricks, vacant]) = bricks_passes(gpu, field, bits, side)?;
        let view = self
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut entries: Vec<_> = field.table_bindings().collect();
        entries.push(entry(VOLUME, &self.volume));
        entries.push(entry(FILL, &self.fill));
        entries.push(wgpu::BindGroupEntry {
            binding: TEXELS,
            resource: wgpu::BindingResource::TextureView(&view),
        });
        entries.extend(self.tables.words.binding(TREE_WORDS));
        entries.extend(self.centers.binding(CENTERS));
        entries.extend(self.tables.keys.binding(KEYS));
        let group = self.group("Octree::fill", &layout, &entries)?;
        let fill = Fill {
            tile: measures.brick,
            ..measures.encoding.fill(program, &measures.lattice, 0)
        };
        let area = u64::from(measures.brick * measures.brick);
        let work = measures.capacity() * area * field.length() as u64;
        for (first, count) in layers(field, work, measures.brick, side) {
            let fill = Fill {
                first_layer: first,
                layer_count: count,
                ..fill
            };
            gpu.queue
                .write_buffer(&self.fill, 0, bytemuck::bytes_of(&fill));
            let groups = Groups::Indirect(&self.arguments, 0);
            bake.pass("fill", &bricks, &group, groups).await?;
        }
        let groups = Groups::Direct(measures.grid.to_array());
        bake.pass("vacant", &vacant, &group, groups).await
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
