//! The devices of worlds.
//!
//! `methods.rs` lists what a device does, once. The trait [`Device`] declares it (`interface.rs`), `cpu.rs` and `gpu.rs` implement
//! it, and [`AnyDevice`] calls one of them. Only methods for the frames of a host, such as
//! [`World::encode_frame`](crate::World::encode_frame), ask for a GPU by name.

#[macro_use]
mod methods;
mod any;
mod cpu;
#[cfg(feature = "gpu")]
mod gpu;
mod interface;

pub(crate) use any::AnyDevice;
pub(crate) use cpu::CpuDevice;
#[cfg(feature = "gpu")]
pub(crate) use gpu::GpuStorage;
pub(crate) use interface::{
    Device, EditWork, HostEncoder, LazyProgram, PathRequest, RenderRequest, StageTimings,
};
