#![doc = include_str!("crate.md")]

mod bindings;
mod bricks;
mod cache;
mod counters;
mod dense;
mod device;
mod error;
mod frame;
mod frame_extras;
mod frame_pipelines;
mod frame_stages;
mod host_device;
mod host_frame;
mod host_motion;
mod host_targets;
mod image_textures;
mod levels;
mod march_passes;
mod marching_cubes;
mod near_lists;
mod octree;
mod options;
mod pass_module;
mod pass_recorder;
mod path_buffers;
mod paths;
mod pipeline_cache;
mod program;
mod query;
mod raster;
mod read_back;
mod recording;
mod render;
mod resolve;
mod resources;
mod shader_modules;
mod shader_volume;
mod staging;
mod storage_buffer;
mod submission;
mod texel_format;
mod tile_source;
mod timing;
mod trace_mode;
mod volume;
mod work;

/// The encoder of a host.
pub type HostEncoder = wgpu::CommandEncoder;

/// The version of wgpu whose devices [`Gpu::from_wgpu`] takes.
pub use wgpu;
pub use {
    device::{Gpu, devices},
    error::GpuError,
    host_frame::{HostFrame, HostSight},
    host_targets::HostTargets,
    image_textures::{ImageOutput, ImageTextures},
    options::{DeviceInfo, DeviceKind, GpuCounters, StageTimings, SurfaceOptions},
    path_buffers::PathWork,
    program::GpuProgram,
    raster::GpuMesh,
    shader_modules::{ShaderModule, hardware_modules},
    shader_volume::ShaderVolume,
    volume::GpuVolume,
};
