//! The passes of marching cubes.

use crate::bindings::{
    Bind, CASES, CELLS, EDGE_ROWS, MARCHING, OWNERS, SPANS, STORED, TRIANGLES, UNINDEXED,
    UNIT_GROUPS, UNITS, VERTICES, VOLUME,
};
use crate::near_lists::field_tables;
use crate::pass_module::{PassModule, Passes};
use crate::resources::uniform_of;
use crate::{GpuError, GpuProgram};
use argil_mesh::{marching::case_table::cases, wgsl};

/// The bindings, as the shaders name them.
const BINDS_WGSL: &str = "
@group(0) @binding(BIND_STORED) var stored: texture_3d<f32>;
@group(0) @binding(BIND_MARCHING) var<uniform> marching: MarchingUniform;
@group(0) @binding(BIND_CASES) var<uniform> cases: array<vec4<u32>, 128>;
@group(0) @binding(BIND_UNITS) var<storage, read_write> units: array<Unit>;
@group(0) @binding(BIND_UNIT_GROUPS) var<storage, read_write> groups: array<vec4<u32>>;
@group(0) @binding(BIND_EDGE_ROWS) var<storage, read_write> rows: array<vec4<u32>>;
";

const OUT_WGSL: &str = "
@group(0) @binding(BIND_MARCHING) var<uniform> marching: MarchingUniform;
";

const MESH_WGSL: &str = "
@group(0) @binding(BIND_VERTICES) var<storage, read_write> vertices: array<f32>;
@group(0) @binding(BIND_TRIANGLES) var<storage, read_write> triangles: array<u32>;
";

const SPANS_WGSL: &str = "
@group(0) @binding(BIND_SPANS) var<storage, read_write> spans: array<vec4<f32>>;
";

const DENSE_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: DenseUniform;
";

const CELLS_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: BrickUniform;
@group(0) @binding(BIND_CELLS) var<storage, read> cells: array<u32>;
@group(0) @binding(BIND_OWNERS) var<storage, read_write> owners: array<u32>;
";

const UNINDEXED_WGSL: &str = "
@group(0) @binding(BIND_UNINDEXED) var<storage, read_write> unindexed: array<f32>;
";

/// Projection needs these, and no triangles.
const EXACT_WGSL: &str = "
@group(0) @binding(BIND_VERTICES) var<storage, read_write> vertices: array<f32>;
";

/// Describes the passes that march through bricks, or through a dense volume.
pub(crate) fn march_module(of_bricks: bool) -> PassModule {
    let (cells, march) = if of_bricks {
        let cells = [CELLS_WGSL, argil_volume::wgsl::BRICK_CELLS].concat();
        (cells, wgsl::BRICKS)
    } else {
        (DENSE_WGSL.to_owned(), wgsl::DENSE)
    };
    let abi = argil_abi::wgsl();
    let source = [&abi, BINDS_WGSL, MESH_WGSL, SPANS_WGSL, &cells, march];
    let mut binds = vec![
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Uniform(MARCHING),
        Bind::Uniform(CASES),
    ];
    binds.extend([UNITS, UNIT_GROUPS, EDGE_ROWS].map(Bind::Write));
    binds.extend([VERTICES, TRIANGLES, SPANS].map(Bind::Write));
    let mut entry_points = vec![
        "count_units",
        "add_units",
        "add_groups",
        "assign_row_offsets",
        "emit",
    ];
    if of_bricks {
        binds.extend([Bind::Read(CELLS), Bind::Write(OWNERS)]);
        entry_points.push("find_owners");
    }
    let label = if of_bricks {
        "March::bricks"
    } else {
        "March::dense"
    };
    PassModule::new(label, &source, binds, &[], &entry_points)
}

/// Describes the pass that moves vertices to the field's surface, by lists or not.
pub(crate) fn project_module(field_wgsl: &str, by_lists: bool) -> PassModule {
    let (mut binds, tables) = field_tables(by_lists);
    let source = [
        &argil_abi::wgsl(),
        &tables,
        OUT_WGSL,
        EXACT_WGSL,
        SPANS_WGSL,
        field_wgsl,
        wgsl::PROJECT_TO_FIELD,
    ];
    binds.push(Bind::Uniform(MARCHING));
    binds.extend([VERTICES, SPANS].map(Bind::Write));
    let label = match by_lists {
        true => "March::project by lists",
        false => "March::project",
    };
    PassModule::new(label, &source, binds, &[], &["project_to_field"])
}

/// Describes the pass that gives each triangle its own vertices.
pub(crate) fn unindex_module() -> PassModule {
    let abi = argil_abi::wgsl();
    let source = [&abi, OUT_WGSL, MESH_WGSL, UNINDEXED_WGSL, wgsl::UNINDEX];
    let mut binds = vec![Bind::Uniform(MARCHING)];
    binds.extend([VERTICES, TRIANGLES, UNINDEXED].map(Bind::Write));
    PassModule::new("March::unindex", &source, binds, &[], &["unindex"])
}

/// The passes for a program and a kind of volume.
pub(crate) struct MarchPasses {
    pub(super) march: Passes,
    pub(super) unindex: Passes,
    pub(super) of_bricks: bool,
    pub(super) cases: wgpu::Buffer,
}

impl MarchPasses {
    pub(crate) fn new(field: &GpuProgram, of_bricks: bool) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let cases = gpu.with_error_scope(|| {
            let cases = uniform_of::<[u64; 256]>(gpu, "cases");
            let packed = cases_packed();
            gpu.write_buffer(&cases, 0, bytemuck::cast_slice(&packed));
            cases
        })?;
        Ok(Self {
            march: Passes::new(gpu, march_module(of_bricks))?,
            unindex: Passes::new(gpu, unindex_module())?,
            of_bricks,
            cases,
        })
    }
}

/// Returns each case's edges, four bits each, with the number of triangles above them.
fn cases_packed() -> Vec<u64> {
    let pack = |case: &argil_mesh::marching::case_table::MarchingCase| {
        let edges = case.triangles().iter().flatten();
        let words = edges.enumerate().fold(0, |words, (index, &edge)| {
            words | u64::from(edge) << (4 * index)
        });
        words | u64::from(case.count) << 60
    };
    cases().iter().map(pack).collect()
}
