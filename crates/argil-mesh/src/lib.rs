#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

pub mod dual_contouring;
pub mod levels;
pub mod marching;
mod mesh;
mod mesh_format;
mod mesh_normals;
mod mesh_report;
mod mesh_sdf;
mod nearest;
pub mod project_to_field;
mod read;
mod repair;
#[cfg(all(not(target_arch = "wasm32"), feature = "simplify"))]
mod separate_sheets;
mod simplify;
mod thicken;
mod write;

/// Shader text, to follow `argil_abi::wgsl()`, the bindings that it names, and `argil_volume::wgsl::BRICK_CELLS` for
/// bricks.
pub mod wgsl {
    /// Marching cubes over the units of a dense volume.
    pub const DENSE: &str = concat!(
        include_str!("marching/march.wgsl"),
        include_str!("marching/cells.wgsl"),
        include_str!("marching/count.wgsl"),
        include_str!("marching/vertices.wgsl"),
        include_str!("marching/emit.wgsl"),
        include_str!("marching/dense.wgsl")
    );
    /// Marching cubes over bricks.
    pub const BRICKS: &str = concat!(
        include_str!("marching/march.wgsl"),
        include_str!("marching/cells.wgsl"),
        include_str!("marching/count.wgsl"),
        include_str!("marching/vertices.wgsl"),
        include_str!("marching/emit.wgsl"),
        include_str!("marching/bricks.wgsl")
    );
    /// Moves vertices to the surface of a field.
    pub const PROJECT_TO_FIELD: &str = include_str!("project_to_field.wgsl");
    /// Gives each triangle its own vertices.
    pub const UNINDEX: &str = include_str!("unindex.wgsl");
}

pub use mesh::Mesh;
pub use mesh_format::MeshFormat;
pub use mesh_normals::MeshNormals;
pub use mesh_report::MeshReport;
pub use mesh_sdf::MeshSdf;
pub use nearest::SurfacePoints;
pub use read::{MeshFile, MeshReadError, MeshSource, bytes, from_bytes, path_within, read};
pub use repair::{RepairReport, repair};
pub use simplify::simplify;
pub use thicken::thicken;
pub use write::{MeshWriteOptions, UpAxis, write};
#[cfg(feature = "files")]
pub use write::{ThreeMfMetadata, write_3mf};
