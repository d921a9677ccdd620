//! Argil's passes on the GPU. The only crate that names wgpu.
//!
//! *Practice.* [`Gpu`] is a device, opened once and shared. [`GpuField`] holds a program's tables and pipelines there,
//! [`GpuVolume`] a volume's texture and tables: pipelines are made once, tables grow and are kept, uniforms are written
//! for each dispatch. Passes live in files of their own and do no arithmetic: pictures run `Trace::march`,
//! `Trace::finish`, `Shade::shadow` and `Shade::light`; [`GpuField::evaluate`] runs `Query::points`; volumes are built by
//! `DenseFill` and `Octree::…`. Nothing is compiled when a program changes, unless it was asked to be specialised, or a
//! software device's trimmed interpreter lacks an opcode.

mod bake;
mod bricks;
mod dense;
mod device;
mod error;
mod field;
mod marching;
mod mesh;
mod octree;
mod pass;
mod picture;
mod query;
mod table;
mod texels;
mod timing;
mod volume;

pub use bake::StagesMs;
pub use dense::DenseFill;
pub use device::{DeviceInfo, DeviceKind, Gpu, devices};
pub use error::GpuError;
pub use field::GpuField;
pub use marching::{MarchNormals, MarchOptions};
pub use mesh::GpuMesh;
pub use octree::Order;
pub use volume::GpuVolume;
