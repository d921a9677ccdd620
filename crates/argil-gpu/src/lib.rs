//! Argil's passes on the GPU. The only crate that names wgpu.
//!
//! *Practice.* [`Gpu`] is a device, opened once and shared. [`GpuField`] holds a program's tables and pipelines there,
//! [`GpuVolume`] a volume's texture and tables: pipelines are made once, tables grow and are kept, uniforms are written
//! for each dispatch. Passes live in files of their own and do no arithmetic: pictures run `Trace::march`,
//! `Trace::finish`, `Shade::shadow` and `Shade::light`; [`GpuField::evaluate`] runs `Query::points`; volumes are built by
//! `DenseFill` and `Octree::…`. Nothing is compiled when a program changes, unless it was asked to be specialised, or a
//! software device's trimmed interpreter lacks an opcode.
//! Without the feature `device`, which is on by default, there is none of that: the same names stand for a device that no
//! machine has, and nothing is compiled of wgpu.

mod error;
mod options;

pub use error::GpuError;
pub use options::{DenseFill, DeviceInfo, DeviceKind, MarchNormals, MarchOptions, Order, StagesMs};

#[cfg(feature = "device")]
mod bake;
#[cfg(feature = "device")]
mod bricks;
#[cfg(feature = "device")]
mod cache;
#[cfg(feature = "device")]
mod dense;
#[cfg(feature = "device")]
mod device;
#[cfg(feature = "device")]
mod field;
#[cfg(feature = "device")]
mod frame;
#[cfg(feature = "device")]
mod march_passes;
#[cfg(feature = "device")]
mod marching;
#[cfg(feature = "device")]
mod mesh;
#[cfg(feature = "device")]
mod octree;
#[cfg(feature = "device")]
mod pass;
#[cfg(feature = "device")]
mod picture;
#[cfg(feature = "device")]
mod query;
#[cfg(feature = "device")]
mod recording;
#[cfg(feature = "device")]
mod resolve;
#[cfg(feature = "device")]
mod resources;
#[cfg(feature = "device")]
mod table;
#[cfg(feature = "device")]
mod texels;
#[cfg(feature = "device")]
mod timing;
#[cfg(feature = "device")]
mod volume;
#[cfg(feature = "device")]
mod way;
#[cfg(feature = "device")]
mod work;

#[cfg(feature = "device")]
pub use {
    device::{Gpu, devices},
    field::GpuField,
    mesh::GpuMesh,
    volume::GpuVolume,
};

#[cfg(not(feature = "device"))]
mod none;
#[cfg(not(feature = "device"))]
pub use none::{Gpu, GpuField, GpuMesh, GpuVolume, devices};
