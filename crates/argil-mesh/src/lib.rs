//! Triangles out of fields and volumes, and triangles in.

pub mod exact;
pub mod marching;
mod mesh;
mod report;
mod write;

pub use mesh::Mesh;
pub use report::Report;
pub use write::{Axes, Format, WriteOptions, write};
