//! Argil's passes on the GPU. The only crate that names wgpu.
//!
//! *Practice.* [`Gpu`] is a device, opened once and shared. [`GpuProgram`] holds a program's tables and pipelines there,
//! [`GpuVolume`] a volume's texture and tables: pipelines are made once, tables grow and are kept, uniforms are written
//! for each dispatch. Passes live in files of their own and do no arithmetic: pictures run `Trace::march`,
//! `Trace::finish`, `Shade::shadow` and `Shade::light`; [`GpuProgram::evaluate`] runs `Query::points`; volumes are built by
//! `DenseFill` and `Octree::…`. Nothing is compiled when a program changes, unless it was asked to be specialised, or a
//! software device's trimmed interpreter lacks an opcode.
//! Without the feature `device`, which is on by default, there is none of that: the same names stand for a device that no
//! machine has, and nothing is compiled of wgpu.

mod error;
mod options;

pub use error::GpuError;
pub use options::{
    BrickOrdering, DenseFill, DeviceInfo, DeviceKind, StageTimings, SurfaceNormals, SurfaceOptions,
};

#[cfg(feature = "device")]
mod bindings;
#[cfg(feature = "device")]
mod bricks;
#[cfg(feature = "device")]
mod cache;
#[cfg(feature = "device")]
mod dense;
#[cfg(feature = "device")]
mod device;
#[cfg(feature = "device")]
mod frame;
#[cfg(feature = "device")]
mod march_passes;
#[cfg(feature = "device")]
mod marching_cubes;
#[cfg(feature = "device")]
mod octree;
#[cfg(feature = "device")]
mod pass_recorder;
#[cfg(feature = "device")]
mod program;
#[cfg(feature = "device")]
mod query;
#[cfg(feature = "device")]
mod raster;
#[cfg(feature = "device")]
mod recording;
#[cfg(feature = "device")]
mod render;
#[cfg(feature = "device")]
mod resolve;
#[cfg(feature = "device")]
mod resources;
#[cfg(feature = "device")]
mod storage_buffer;
#[cfg(feature = "device")]
mod texel_format;
#[cfg(feature = "device")]
mod timing;
#[cfg(feature = "device")]
mod trace_mode;
#[cfg(feature = "device")]
mod volume;
#[cfg(feature = "device")]
mod work;

#[cfg(feature = "device")]
pub use {
    device::{Gpu, devices},
    program::GpuProgram,
    raster::GpuMesh,
    volume::GpuVolume,
};

#[cfg(not(feature = "device"))]
mod no_device;
#[cfg(not(feature = "device"))]
pub use no_device::{Gpu, GpuField, GpuMesh, GpuVolume, devices};
