//! Argil's passes on the GPU. The only crate that names wgpu.
//!
//! *Practice.* [`Gpu`] is a device, opened once and shared. [`GpuField`] holds a program's tables and pipelines there:
//! pipelines are made once, tables grow and are kept, the frame's uniform is written for each dispatch. Passes live in
//! files of their own and do no arithmetic: [`GpuField::render`] runs `Trace::march`, `Trace::finish`, `Shade::shadow` and
//! `Shade::light`,
//! [`GpuField::evaluate`] runs `Query::points`. Nothing is compiled when a program changes, unless it was asked to be
//! specialised, or a software device's trimmed interpreter lacks an opcode.

mod device;
mod error;
mod field;
mod pass;
mod query;
mod render;
mod table;
mod timing;

pub use device::{DeviceInfo, DeviceKind, Gpu, devices};
pub use error::GpuError;
pub use field::GpuField;
