//! Builds an octree. No step waits for the CPU.

use super::OctreeTables;
use crate::bindings::{
    ARGUMENTS, Bind, CENTERS, FIELD_BINDS, FILL, KEYS, NODES, OCCUPIED, TABLES_WGSL, TEXELS,
    TREE_WORDS, VOLUME, entry,
};
use crate::dense::{layers, target_wgsl, tile_side};
use crate::pass_module::{PassModule, Passes};
use crate::pass_recorder::{DispatchSize, PassRecorder};
use crate::resources::{texture, uniform_of};
use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::tile_source::TileSource;
use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume, StageTimings};
use argil_abi::{self as abi, FillUniform, OctreeNode, OctreeUniform};
use argil_field::Program;
use argil_volume::{BrickOrdering, BrickTest, OctreeLayout, wgsl};

/// Maximum cells for the enumeration sort.
const MAX_TO_ENUMERATE: u32 = 32_768;

/// The bindings of each module, as the shaders name them.
const SELECT_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: OctreeUniform;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read_write> tree_words: array<atomic<u32>>;
@group(0) @binding(BIND_OCCUPIED) var<storage, read_write> occupied: array<atomic<u32>>;
@group(0) @binding(BIND_CENTERS) var<storage, read_write> centers: array<f32>;
";

const TREE_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: OctreeUniform;
@group(0) @binding(BIND_NODES) var<storage, read_write> node_words: array<atomic<u32>>;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read_write> tree_words: array<atomic<u32>>;
@group(0) @binding(BIND_OCCUPIED) var<storage, read_write> occupied: array<atomic<u32>>;
@group(0) @binding(BIND_KEYS) var<storage, read_write> keys: array<u32>;
@group(0) @binding(BIND_ARGUMENTS) var<storage, read_write> arguments: array<u32>;
";

const BRICKS_BINDS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: OctreeUniform;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read> tree_words: array<u32>;
@group(0) @binding(BIND_CENTERS) var<storage, read> centers: array<f32>;
@group(0) @binding(BIND_KEYS) var<storage, read> keys: array<u32>;
";

impl GpuVolume {
    /// Builds an octree from a field. Returns the volume and the timings.
    ///
    /// # Errors
    /// If the octree exceeds the device's limits or memory, or the device fails.
    pub async fn octree(
        field: &GpuProgram,
        program: &Program,
        measures: OctreeLayout,
        keep: BrickTest,
        order: BrickOrdering,
    ) -> Result<(Self, StageTimings), GpuError> {
        let gpu = field.gpu();
        let codes = measures.code_count();
        if order == BrickOrdering::EnumerationSort && codes > MAX_TO_ENUMERATE {
            let limit = MAX_TO_ENUMERATE;
            return Err(GpuError::TooManyToEnumerate { codes, limit });
        }
        let words = measures.uniform(program, keep);
        let build = OctreeBuilder::new(field, measures, &words, order)?;
        let tree = field.plain_passes("octree", || Passes::new(gpu, tree_module()))?;
        let tree_group = build.tree_group(&tree.layout)?;
        let mut recorder = PassRecorder::new(gpu)?;
        build.select(&mut recorder, order).await?;
        let once = DispatchSize::Direct([1, 1, 1]);
        let (sort, groups) = match order {
            BrickOrdering::PrefixSum => (tree.get(gpu, "compact")?, once),
            BrickOrdering::EnumerationSort => {
                let groups = (measures.capacity() as u32).div_ceil(256);
                (tree.get(gpu, "rank")?, DispatchSize::Direct([groups, 1, 1]))
            }
        };
        recorder.pass("sort", sort, &tree_group, groups).await?;
        build.fill(&mut recorder, program).await?;
        let link = tree.get(gpu, "build")?;
        recorder.pass("tree", link, &tree_group, once).await?;
        let stages = recorder.finish().await?;
        let (voxel_grid, encoding) = (measures.voxel_grid, measures.encoding);
        let OctreeBuilder {
            texture, tables, ..
        } = build;
        let volume = Self::new(field, (voxel_grid, encoding), texture, tables)?;
        Ok((volume, stages))
    }
}

/// The state of a build. Its tables have room for all bricks.
struct OctreeBuilder<'a> {
    field: &'a GpuProgram,
    measures: OctreeLayout,
    texture: wgpu::Texture,
    tables: OctreeTables,
    occupied: StorageBuffer,
    centers: StorageBuffer,
    volume: wgpu::Buffer,
    fill: wgpu::Buffer,
    arguments: wgpu::Buffer,
}

impl<'a> OctreeBuilder<'a> {
    fn new(
        field: &'a GpuProgram,
        measures: OctreeLayout,
        words: &OctreeUniform,
        order: BrickOrdering,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let texture = texture(gpu, &measures.voxel_grid, measures.encoding.format, 1)?;
        let capacity = measures.capacity();
        let nodes: u64 = (0..measures.depth)
            .map(|level| capacity.min(1 << (3 * (measures.depth - 1 - level))))
            .sum();
        let mut tables = OctreeTables::new(measures);
        let bytes = 4 * u64::from(abi::OCTREE_HEADER_WORDS);
        tables.words.reserve_exact(gpu, bytes)?;
        tables.keys.reserve_exact(gpu, 4 * (capacity + nodes))?;
        let bytes = size_of::<OctreeNode>() as u64 * nodes;
        tables.nodes.reserve_exact(gpu, bytes)?;
        let mut occupied = StorageBuffer::new("occupied cells");
        let code_count = measures.code_count();
        let occupied_words = match order {
            BrickOrdering::PrefixSum => u64::from(code_count.div_ceil(32)),
            BrickOrdering::EnumerationSort => capacity,
        };
        occupied.reserve_exact(gpu, 4 * occupied_words)?;
        let mut centers = StorageBuffer::new("distances of cells");
        centers.reserve_exact(gpu, 4 * u64::from(code_count))?;
        let (volume, fill, arguments) = gpu.with_error_scope(|| {
            let arguments = gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("bricks to fill"),
                size: 16,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            });
            let volume = uniform_of::<OctreeUniform>(gpu, "volume");
            (volume, uniform_of::<FillUniform>(gpu, "fill"), arguments)
        })?;
        gpu.write_buffer(&volume, 0, bytemuck::bytes_of(words));
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
        gpu.with_error_scope(|| {
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

    /// Finds the cells that the surface can pass through.
    async fn select(
        &self,
        recorder: &mut PassRecorder<'_>,
        order: BrickOrdering,
    ) -> Result<(), GpuError> {
        let (field, gpu) = (self.field, self.field.gpu());
        let passes = field.passes("select bricks", || {
            Passes::new(gpu, select_module(&field.field_wgsl()))
        })?;
        let mut entries: Vec<_> = self.field.table_bindings().collect();
        entries.push(entry(VOLUME, &self.volume));
        entries.extend(self.tables.words.binding(TREE_WORDS));
        entries.extend(self.occupied.binding(OCCUPIED));
        entries.extend(self.centers.binding(CENTERS));
        let group = self.group("Octree::select", &passes.layout, &entries)?;
        let groups = self.measures.code_count().div_ceil(64);
        let groups = DispatchSize::Direct([
            groups.min(abi::DISPATCH_ROW),
            groups.div_ceil(abi::DISPATCH_ROW),
            1,
        ]);
        let select = match order {
            BrickOrdering::PrefixSum => passes.get(gpu, "select_bits")?,
            BrickOrdering::EnumerationSort => passes.get(gpu, "select_list")?,
        };
        recorder.pass("select", select, &group, groups).await
    }

    /// Samples the bricks and the vacant cells.
    async fn fill(
        &self,
        recorder: &mut PassRecorder<'_>,
        program: &Program,
    ) -> Result<(), GpuError> {
        let (field, measures) = (self.field, &self.measures);
        let gpu = field.gpu();
        let side = tile_side(gpu, measures.brick_size_voxels);
        let texels = gpu.texels(measures.encoding.format);
        let variant = texels.bits().bytes() as u32 + 16 * side;
        let area = u64::from(measures.brick_size_voxels * measures.brick_size_voxels);
        let samples = measures.capacity() * area * u64::from(measures.brick_size_voxels);
        let tiles = field.tile_field(true, samples)?;
        let key = tiles.source.name_of([
            "fill octree",
            "fill octree by columns",
            "fill octree by lists",
        ]);
        let passes = field.passes((key, variant), || {
            Passes::new(gpu, fill_module(&tiles.source, texels, side))
        })?;
        let view = self
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut entries: Vec<_> = tiles.bound.iter().map(BoundResource::entry).collect();
        entries.push(entry(VOLUME, &self.volume));
        entries.push(entry(FILL, &self.fill));
        entries.push(wgpu::BindGroupEntry {
            binding: TEXELS,
            resource: wgpu::BindingResource::TextureView(&view),
        });
        entries.extend(self.tables.words.binding(TREE_WORDS));
        entries.extend(self.centers.binding(CENTERS));
        entries.extend(self.tables.keys.binding(KEYS));
        let group = self.group("Octree::fill", &passes.layout, &entries)?;
        let fill = FillUniform {
            tile: measures.brick_size_voxels,
            ..measures
                .encoding
                .fill_uniform(program, &measures.voxel_grid, 0)
        };
        let work = measures.capacity() * area * field.length() as u64;
        for (first, count) in layers(field, work, measures.brick_size_voxels, side) {
            let fill = FillUniform {
                first_layer: first,
                layer_count: count,
                ..fill
            };
            gpu.write_buffer(&self.fill, 0, bytemuck::bytes_of(&fill));
            let groups = DispatchSize::Indirect(&self.arguments, 0);
            let bricks = passes.get(gpu, "fill_bricks")?;
            recorder.pass("fill", bricks, &group, groups).await?;
        }
        let groups = DispatchSize::Direct(measures.size_bricks.to_array());
        let vacant = passes.get(gpu, "fill_vacant")?;
        recorder.pass("vacant", vacant, &group, groups).await
    }
}

/// Describes the passes that find the cells with a surface.
pub(crate) fn select_module(field_wgsl: &str) -> PassModule {
    let source = [
        &argil_abi::wgsl(),
        TABLES_WGSL,
        SELECT_BINDS_WGSL,
        field_wgsl,
        argil_math::morton_wgsl(),
        wgsl::OCTREE_SELECT,
    ];
    let mut binds = FIELD_BINDS.to_vec();
    binds.extend([
        Bind::Uniform(VOLUME),
        Bind::Write(TREE_WORDS),
        Bind::Write(OCCUPIED),
        Bind::Write(CENTERS),
    ]);
    let entry_points = ["select_bits", "select_list"];
    PassModule::new("Octree::select", &source, binds, &[], &entry_points)
}

/// Describes the passes that sort cells and link nodes.
pub(crate) fn tree_module() -> PassModule {
    let source = [&argil_abi::wgsl(), TREE_BINDS_WGSL, wgsl::OCTREE_BUILD];
    let binds = vec![
        Bind::Uniform(VOLUME),
        Bind::Write(NODES),
        Bind::Write(TREE_WORDS),
        Bind::Write(OCCUPIED),
        Bind::Write(KEYS),
        Bind::Write(ARGUMENTS),
    ];
    let entry_points = ["compact", "rank", "build"];
    PassModule::new("Octree::tree", &source, binds, &[], &entry_points)
}

/// Describes the passes that sample bricks and vacant cells, with `side`² threads in a group.
pub(crate) fn fill_module(source: &TileSource, texels: TexelFormat, side: u32) -> PassModule {
    let [field, fill] = source.wgsl();
    let text = [
        &argil_abi::wgsl(),
        &source.tables(),
        &target_wgsl(texels),
        BRICKS_BINDS_WGSL,
        field,
        argil_math::morton_wgsl(),
        fill,
        wgsl::OCTREE_FILL,
    ];
    let mut binds = source.binds();
    binds.extend([
        Bind::Uniform(VOLUME),
        Bind::Uniform(FILL),
        Bind::Target(TEXELS, texels.format()),
        Bind::Read(TREE_WORDS),
        Bind::Read(CENTERS),
        Bind::Read(KEYS),
    ]);
    let constants = [("TILE_SIDE", f64::from(side))];
    let entry_points = ["fill_bricks", "fill_vacant"];
    let label = source.name_of([
        "Octree::fill",
        "Octree::fill by columns",
        "Octree::fill by lists",
    ]);
    PassModule::new(label, &text, binds, &constants, &entry_points)
}

/// Clears buffers.
fn clear<const N: usize>(
    gpu: &Gpu,
    tables: [&crate::storage_buffer::StorageBuffer; N],
) -> Result<(), GpuError> {
    gpu.with_error_scope(|| {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for buffer in tables.into_iter().filter_map(|t| t.buffer()) {
            encoder.clear_buffer(buffer, 0, None);
        }
        gpu.submit(encoder);
    })
}
