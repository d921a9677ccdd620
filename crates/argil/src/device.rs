//! The devices of worlds.
//!
//! `methods.rs` lists what a device does, once. The trait [`Device`] declares it (`interface.rs`), `cpu.rs` and `gpu.rs` implement
//! it, and [`AnyDevice`] calls one of them. Few methods ask which of them it is: those for the frames and textures of a host, such as
//! [`World::encode_frame`](crate::World::encode_frame), and those that borrow what the CPU stores.

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
