//! Triangles out of fields and volumes, and triangles in.
//!
//! *Theory.* A surface is where a distance is 0. Marching cubes put a corner on each edge of a grid on which the sign changes,
//! dual contouring one into each cell that the surface goes through. The other way round, a point's distance to triangles is
//! that to the nearest of them, negative where they wind around it.
//!
//! *Practice.* [`marching`] makes meshes of dense grids and sparse bricks, [`project_to_field`] moves their corners to the field's own
//! surface and asks it for normals and materials, [`dual_contouring`] makes sharp ones of them. [`MeshReport`] says whether a mesh is closed
//! and manifold, [`simplify`] leaves triangles out, [`write`](fn@write) and [`read`] are the files. [`MeshSdf`] repairs
//! triangles and measures distances to them.
//!
//! ```
//! use argil_field::Grid;
//! use argil_mesh::{MeshReport, MeshSdf, marching};
//! use glam::Vec3;
//! let grid = Grid::spanning(Vec3::splat(-1.0), Vec3::ONE, 33);
//! let at = |i: usize| Vec3::new((i % 33) as f32, (i / 33 % 33) as f32, (i / 1089) as f32) / 16.0 - 1.0;
//! let ball: Vec<f32> = (0..35937).map(|i| at(i).length() - 0.5).collect();
//! let mesh = marching::dense::march(&ball, &grid, 0.0, true);
//! assert!(MeshReport::of(&mesh).is_watertight());
//! let solid = MeshSdf::new(&mesh)?;
//! assert!((solid.distance(Vec3::X) - 0.5).abs() < 0.01);
//! # Ok::<(), argil_mesh::MeshReadError>(())
//! ```

pub mod dual_contouring;
pub mod marching;
mod mesh;
mod mesh_report;
mod mesh_sdf;
pub mod project_to_field;
mod read;
mod repair;
mod simplify;
mod thicken;
mod write;

/// Shader text, to be put after `argil_abi::wgsl()`, the bindings that it names, and `argil_volume::wgsl::WORDS` for bricks.
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
    /// Moving vertices to the surface of a field.
    pub const EXACT: &str = include_str!("exact.wgsl");
    /// Triangles with corners of their own.
    pub const UNSHARED: &str = include_str!("unshared.wgsl");
}

pub use mesh::Mesh;
pub use mesh_report::MeshReport;
pub use mesh_sdf::MeshSdf;
pub use read::{MeshReadError, bytes, from_bytes, read};
pub use repair::{RepairReport, repair};
pub use simplify::simplify;
pub use thicken::thicken;
pub use write::{MeshFormat, MeshWriteOptions, UpAxis, write};
