//! The device of a world, whichever it is.

use super::cpu::CpuDevice;
#[cfg(feature = "gpu")]
use super::gpu::GpuDevice;
use super::interface::{Device, EditWork, PathRequest, RenderRequest, StageTimings};
use crate::build_context::BuildContext;
use crate::field_mesh::Stages;
use crate::still_error::StillError;
use crate::{BuildError, Engine, MeshCounts, MeshError, MeshOptions, RenderError};
use argil_field::{IncrementalProgram, Program};
use argil_mesh::{Mesh, MeshNormals};
use argil_render::{RenderOutput, Still};
use argil_volume::{
    BrickLayout, BrickOrdering, BrickTest, DenseFill, EditStats, Encoding, Levels, OctreeLayout,
    PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use std::borrow::Cow;

/// The device of a world.
#[derive(Debug)]
#[cfg_attr(
    feature = "gpu",
    expect(
        clippy::large_enum_variant,
        reason = "worlds are few, and hold megabytes elsewhere"
    )
)]
pub(crate) enum AnyDevice {
    Cpu(CpuDevice),
    #[cfg(feature = "gpu")]
    Gpu(GpuDevice),
}

impl AnyDevice {
    /// Creates the engine's device with a program, and nothing stored.
    ///
    /// # Errors
    /// If the program nests too deep for a GPU, or the GPU fails.
    pub(crate) fn new(engine: &Engine, program: &Program) -> Result<Self, BuildError> {
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &engine.gpu {
            return Ok(Self::Gpu(GpuDevice::new(gpu, program)?));
        }
        let _ = (engine, program);
        Ok(Self::Cpu(CpuDevice::Field))
    }

    /// Creates another device of this kind, with no brush and nothing stored. On a GPU, it uses the same shaders.
    ///
    /// # Errors
    /// If the GPU fails.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn beside(&self) -> Result<Self, BuildError> {
        match self {
            Self::Cpu(_) => Ok(Self::Cpu(CpuDevice::Field)),
            #[cfg(feature = "gpu")]
            Self::Gpu(device) => Ok(Self::Gpu(GpuDevice {
                program: device.program.beside()?,
                storage: super::GpuStorage::Field,
            })),
        }
    }

    /// Whether edits can be applied to what is stored.
    pub(crate) fn is_editable(&self) -> bool {
        self.has_volume() && !self.is_specialized()
    }

    /// Returns the device, if it is the CPU.
    pub(crate) fn on_cpu(&self) -> Option<&CpuDevice> {
        match self {
            Self::Cpu(device) => Some(device),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => None,
        }
    }

    /// Returns the device, if it is the CPU, to change what it stores.
    pub(crate) fn on_cpu_mut(&mut self) -> Option<&mut CpuDevice> {
        match self {
            Self::Cpu(device) => Some(device),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => None,
        }
    }

    /// Returns the device, if it is a GPU.
    #[cfg(feature = "gpu")]
    pub(crate) fn on_gpu(&self) -> Option<&GpuDevice> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(device) => Some(device),
        }
    }
}

/// Calls the device that there is.
macro_rules! dispatch {
    (
        reads { $($(#[$read_doc:meta])* fn $read:ident(&self $(, $read_arg:ident: $read_type:ty)*) -> $read_result:ty;)* }
        writes { $($(#[$write_doc:meta])* fn $write:ident(&mut self $(, $write_arg:ident: $write_type:ty)*) -> $write_result:ty;)* }
        reads_later { $($(#[$later_doc:meta])* async fn $later:ident(&self $(, $later_arg:ident: $later_type:ty)*) -> $later_result:ty;)* }
        writes_later { $($(#[$job_doc:meta])* async fn $job:ident(&mut self $(, $job_arg:ident: $job_type:ty)*) -> $job_result:ty;)* }
    ) => {
        impl Device for AnyDevice {
            $(fn $read(&self $(, $read_arg: $read_type)*) -> $read_result {
                match self {
                    Self::Cpu(device) => device.$read($($read_arg),*),
                    #[cfg(feature = "gpu")]
                    Self::Gpu(device) => device.$read($($read_arg),*),
                }
            })*
            $(fn $write(&mut self $(, $write_arg: $write_type)*) -> $write_result {
                match self {
                    Self::Cpu(device) => device.$write($($write_arg),*),
                    #[cfg(feature = "gpu")]
                    Self::Gpu(device) => device.$write($($write_arg),*),
                }
            })*
            $(async fn $later(&self $(, $later_arg: $later_type)*) -> $later_result {
                match self {
                    Self::Cpu(device) => device.$later($($later_arg),*).await,
                    #[cfg(feature = "gpu")]
                    Self::Gpu(device) => device.$later($($later_arg),*).await,
                }
            })*
            $(async fn $job(&mut self $(, $job_arg: $job_type)*) -> $job_result {
                match self {
                    Self::Cpu(device) => device.$job($($job_arg),*).await,
                    #[cfg(feature = "gpu")]
                    Self::Gpu(device) => device.$job($($job_arg),*).await,
                }
            })*
        }
    };
}

device_methods!(dispatch);
