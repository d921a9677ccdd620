//! Triangles out of fields and volumes, and triangles in.

pub mod exact;
pub mod marching;
mod mesh;
mod report;

pub use mesh::Mesh;
pub use report::Report;
