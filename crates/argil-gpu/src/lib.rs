#![doc = include_str!("crate.md")]

mod error;
mod options;

pub use error::GpuError;
pub use options::{
    BrickOrdering, DenseFill, DeviceInfo, DeviceKind, GpuCounters, StageTimings, SurfaceOptions,
};

#[cfg(feature = "device")]
mod bindings;
#[cfg(feature = "device")]
mod bricks;
#[cfg(feature = "device")]
mod cache;
#[cfg(feature = "device")]
mod counters;
#[cfg(feature = "device")]
mod dense;
#[cfg(feature = "device")]
mod device;
#[cfg(feature = "device")]
mod frame;
#[cfg(feature = "device")]
mod frame_extras;
#[cfg(feature = "device")]
mod frame_pipelines;
#[cfg(feature = "device")]
mod frame_stages;
#[cfg(feature = "device")]
mod host_device;
#[cfg(feature = "device")]
mod host_frame;
#[cfg(feature = "device")]
mod host_motion;
#[cfg(feature = "device")]
mod host_targets;
#[cfg(feature = "device")]
mod image_textures;
#[cfg(feature = "device")]
mod levels;
#[cfg(feature = "device")]
mod march_passes;
#[cfg(feature = "device")]
mod marching_cubes;
#[cfg(feature = "device")]
mod near_lists;
#[cfg(feature = "device")]
mod octree;
#[cfg(feature = "device")]
mod pass_module;
#[cfg(feature = "device")]
mod pass_recorder;
#[cfg(feature = "device")]
mod path_buffers;
#[cfg(feature = "device")]
mod paths;
#[cfg(feature = "device")]
mod pipeline_cache;
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
mod shader_modules;
#[cfg(feature = "device")]
mod shader_volume;
#[cfg(feature = "device")]
mod staging;
#[cfg(feature = "device")]
mod storage_buffer;
#[cfg(feature = "device")]
mod submission;
#[cfg(feature = "device")]
mod texel_format;
#[cfg(feature = "device")]
mod tile_source;
#[cfg(feature = "device")]
mod timing;
#[cfg(feature = "device")]
mod trace_mode;
#[cfg(feature = "device")]
mod volume;
#[cfg(feature = "device")]
mod work;

/// The encoder of a host.
#[cfg(feature = "device")]
pub type HostEncoder = wgpu::CommandEncoder;

/// The version of wgpu whose devices [`Gpu::from_wgpu`] takes.
#[cfg(feature = "device")]
pub use wgpu;
#[cfg(feature = "device")]
pub use {
    device::{Gpu, devices},
    host_frame::{HostFrame, HostSight},
    host_targets::HostTargets,
    image_textures::{ImageOutput, ImageTextures},
    path_buffers::PathWork,
    program::GpuProgram,
    raster::GpuMesh,
    shader_modules::{ShaderModule, hardware_modules},
    shader_volume::ShaderVolume,
    volume::GpuVolume,
};

#[cfg(not(feature = "device"))]
mod no_device;
#[cfg(not(feature = "device"))]
pub use no_device::{
    Gpu, GpuMesh, GpuProgram, GpuVolume, HostEncoder, ImageOutput, ImageTextures, PathWork, devices,
};
