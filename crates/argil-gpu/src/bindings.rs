//! The bindings that all passes share.

use crate::Gpu;

/// The binding of each table.
pub(crate) use argil_abi::{
    BIND_ANSWERS as ANSWERS, BIND_ARGUMENTS as ARGUMENTS, BIND_BRICK_MATERIALS as BRICK_MATERIALS,
    BIND_CANDIDATES as CANDIDATES, BIND_CASES as CASES, BIND_CELLS as CELLS,
    BIND_CENTERS as CENTERS, BIND_COLORS as COLORS, BIND_COUNTERS as COUNTERS,
    BIND_COUNTS as COUNTS, BIND_EDGE_ROWS as EDGE_ROWS, BIND_ENVIRONMENT as ENVIRONMENT,
    BIND_FEEDBACK as FEEDBACK, BIND_FILL as FILL, BIND_FRAME as FRAME, BIND_HITS as HITS,
    BIND_INSTRS as INSTRS, BIND_KEPT_COLORS as KEPT_COLORS, BIND_KEPT_DISTANCES as KEPT_DISTANCES,
    BIND_KEYS as KEYS, BIND_LIGHT_STORED as LIGHT_STORED, BIND_LIGHT_WORDS as LIGHT_WORDS,
    BIND_LINEAR as LINEAR, BIND_LISTS as LISTS, BIND_MARCHING as MARCHING,
    BIND_MATERIALS as MATERIALS, BIND_MOTIONS as MOTIONS, BIND_MOVED as MOVED, BIND_NODES as NODES,
    BIND_OCCUPIED as OCCUPIED, BIND_OLD_MATERIALS as OLD_MATERIALS, BIND_OLD_POOL as OLD_POOL,
    BIND_OWNERS as OWNERS, BIND_PARAMS as PARAMS, BIND_PATH_PIXELS as PATH_PIXELS,
    BIND_PATH_STATES as PATH_STATES, BIND_PATH_TABLES as PATH_TABLES, BIND_PATHS as PATHS,
    BIND_PIXELS as PIXELS, BIND_PRUNE as PRUNE, BIND_QUERIES as QUERIES, BIND_RASTER as DRAWN,
    BIND_REQUESTS as LIVE, BIND_SPANS as SPANS, BIND_STORED as STORED, BIND_TEXELS as TEXELS,
    BIND_TREE_WORDS as TREE_WORDS, BIND_TRIANGLES as TRIANGLES, BIND_UNINDEXED as UNINDEXED,
    BIND_UNIT_GROUPS as UNIT_GROUPS, BIND_UNITS as UNITS, BIND_VERTICES as VERTICES,
    BIND_VOLUME as VOLUME,
};

pub(crate) const TABLES_WGSL: &str = "
@group(0) @binding(BIND_INSTRS) var<storage, read> instructions: array<Instruction>;
@group(0) @binding(BIND_PARAMS) var<storage, read> params: array<f32>;
@group(0) @binding(BIND_MATERIALS) var<storage, read> materials: array<GpuMaterial>;
";

/// Lists that a pass only reads, and parameters, four at a time: a device loads them once for all threads.
pub(crate) const COLUMNS_WGSL: &str = "
@group(0) @binding(BIND_LISTS) var<storage, read> lists: array<u32>;
@group(0) @binding(BIND_PARAMS) var<storage, read> records: array<vec4<f32>>;
";

pub(crate) const FRAME_WGSL: &str = "
@group(0) @binding(BIND_FRAME) var<uniform> frame: FrameUniform;
";

pub(crate) const PICTURE_WGSL: &str = "
@group(0) @binding(BIND_HITS) var<storage, read_write> hits: array<vec4<u32>>;
@group(0) @binding(BIND_COLORS) var<storage, read_write> colors: array<vec4<f32>>;
";

pub(crate) const QUERY_WGSL: &str = "
@group(0) @binding(BIND_QUERIES) var<storage, read> queries: array<QueryPoint>;
@group(0) @binding(BIND_ANSWERS) var<storage, read_write> answers: array<QueryResult>;
";

/// A volume, whose uniform `DenseUniform`, `OctreeUniform` or `BrickUniform` is declared next to it.
pub(crate) const VOLUME_WGSL: &str = "
@group(0) @binding(BIND_STORED) var stored: texture_3d<f32>;
@group(0) @binding(BIND_LINEAR) var linear: sampler;
";

pub(crate) const TREE_WGSL: &str = "
@group(0) @binding(BIND_NODES) var<storage, read> nodes: array<OctreeNode>;
@group(0) @binding(BIND_TREE_WORDS) var<storage, read> tree_words: array<u32>;
";

pub(crate) const CELLS_WGSL: &str = "
@group(0) @binding(BIND_CELLS) var<storage, read> cells: array<u32>;
@group(0) @binding(BIND_BRICK_MATERIALS) var<storage, read> brick_materials: array<u32>;
";

/// The levels from which light reads distances that bricks do not store.
pub(crate) const LIGHT_WGSL: &str = "
@group(0) @binding(BIND_LIGHT_WORDS) var light_words: texture_2d<u32>;
@group(0) @binding(BIND_LIGHT_STORED) var light_stored: texture_3d<f32>;
";

pub(crate) const LEVELS_WGSL: &str = "
@group(0) @binding(BIND_CELLS) var<storage, read> cells: array<u32>;
";

/// What the rays of an image used and lacked.
pub(crate) const FEEDBACK_WGSL: &str = "
@group(0) @binding(BIND_FEEDBACK) var<storage, read_write> feedback: array<atomic<u32>>;
";

/// Blocks of pixels, for representations whose cones go first.
pub(crate) const LIVE_WGSL: &str = "
// For each block of pixels its cone, whether the eye is in the solid, and a list of active blocks; later, the number of
// pixels without a material.
struct PixelBlock {
    begin: f32,
    steps: u32,
    place: u32,
    is_inside: u32,
}
struct Live {
    groups_x: atomic<u32>,
    groups_y: u32,
    groups_z: u32,
    deferred: atomic<u32>,
    blocks: array<PixelBlock>,
}
@group(0) @binding(BIND_REQUESTS) var<storage, read_write> live: Live;
";

pub(crate) const DRAWN_WGSL: &str = "
@group(0) @binding(BIND_RASTER) var drawn: texture_2d<f32>;
";

/// Paths of light.
pub(crate) const PATHS_WGSL: &str = "
@group(0) @binding(BIND_PATHS) var<uniform> paths: PathUniform;
@group(0) @binding(BIND_PATH_STATES) var<storage, read_write> states: array<PathState>;
@group(0) @binding(BIND_PATH_TABLES) var<storage, read> path_tables: array<vec4<f32>>;
@group(0) @binding(BIND_ENVIRONMENT) var environment: texture_2d<f32>;
// The number of pixels all of whose paths ended, and what those found.
struct PathPixels {
    finished: atomic<u32>,
    rows: array<PathPixel>,
}
@group(0) @binding(BIND_PATH_PIXELS) var<storage, read_write> pixels: PathPixels;
";

impl Bind {
    /// Returns the number of the binding.
    pub(crate) fn place(self) -> u32 {
        match self {
            Self::Uniform(at)
            | Self::Uniforms(at)
            | Self::Read(at)
            | Self::Write(at)
            | Self::Texture(at)
            | Self::Filter(at)
            | Self::Picture(at)
            | Self::Words(at)
            | Self::Target(at, _)
            | Self::Image(at, _) => at,
        }
    }
}

/// How a shader uses a binding.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bind {
    Uniform(u32),
    /// A uniform with one value per pass, found by an offset.
    Uniforms(u32),
    Read(u32),
    Write(u32),
    /// A 3D texture to filter.
    Texture(u32),
    Filter(u32),
    /// An image whose texels are read directly.
    Picture(u32),
    /// A texture of words.
    Words(u32),
    /// A 3D texture to write.
    Target(u32, wgpu::TextureFormat),
    /// A 2D texture to write.
    Image(u32, wgpu::TextureFormat),
}

/// The tables of a program.
pub(crate) const FIELD_BINDS: [Bind; 3] = [
    Bind::Read(INSTRS),
    Bind::Read(PARAMS),
    Bind::Read(MATERIALS),
];

/// Creates a layout of the given bindings for compute shaders.
pub(crate) fn layout(gpu: &Gpu, label: &str, binds: &[Bind]) -> wgpu::BindGroupLayout {
    layout_for(gpu, label, wgpu::ShaderStages::COMPUTE, binds)
}

/// Creates a layout of the given bindings for shaders of some stages.
pub(crate) fn layout_for(
    gpu: &Gpu,
    label: &str,
    visibility: wgpu::ShaderStages,
    binds: &[Bind],
) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let written = |format, view_dimension| wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension,
    };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let entries: Vec<_> = binds
        .iter()
        .map(|bind| {
            let (binding, ty) = match *bind {
                Bind::Uniform(at) => (at, buffer(wgpu::BufferBindingType::Uniform)),
                Bind::Uniforms(at) => {
                    let ty = wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: true,
                        min_binding_size: None,
                    };
                    (at, ty)
                }
                Bind::Read(at) => (at, storage(true)),
                Bind::Write(at) => (at, storage(false)),
                Bind::Texture(at) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D3,
                        multisampled: false,
                    };
                    (at, ty)
                }
                Bind::Picture(at) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: false },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    };
                    (at, ty)
                }
                Bind::Words(at) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Uint,
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    };
                    (at, ty)
                }
                Bind::Filter(at) => {
                    let ty = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
                    (at, ty)
                }
                Bind::Target(at, format) => (at, written(format, wgpu::TextureViewDimension::D3)),
                Bind::Image(at, format) => (at, written(format, wgpu::TextureViewDimension::D2)),
            };
            wgpu::BindGroupLayoutEntry {
                binding,
                visibility,
                ty,
                count: None,
            }
        })
        .collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
}

/// Returns a whole buffer as a binding.
pub(crate) fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}
