//! Triangles out of fields and volumes, and triangles in.

pub mod dual;
pub mod exact;
pub mod marching;
mod mesh;
mod read;
mod repair;
mod report;
mod simplify;
mod solid;
mod write;

pub use mesh::Mesh;
pub use read::{MeshInput, bytes, from_bytes, read};
pub use repair::{Repairs, repair};
pub use report::Report;
pub use simplify::simplify;
pub use solid::Solid;
pub use write::{Axes, Format, WriteOptions, write};
