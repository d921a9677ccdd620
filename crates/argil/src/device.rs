//! The devices of worlds: what a device stores of a scene, and what it does with that.
//!
//! [`Device`] is declared once, below. `cpu.rs` and `gpu.rs` implement it, and [`AnyDevice`] calls one of them. Only methods for
//! the frames of a host, such as [`World::encode_frame`](crate::World::encode_frame), ask for a GPU by name.

mod cpu;
#[cfg(feature = "gpu")]
mod gpu;

use crate::field_mesh::Stages;
use crate::program_cache::LazyProgram;
use crate::query::Query;
use crate::representation::BuildContext;
use crate::still::StillError;
use crate::{BuildError, Engine, MeshCounts, MeshError, MeshOptions, RenderError};
use argil_abi::FrameUniform;
use argil_field::{IncrementalProgram, Program};
use argil_math::Control;
use argil_mesh::{Mesh, MeshNormals};
use argil_render::{PathView, RenderOutput, Still, StillOptions};
use argil_volume::{
    BrickLayout, BrickOrdering, BrickTest, DenseFill, EditStats, Encoding, Levels, OctreeLayout,
    PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use std::borrow::Cow;
use std::sync::Arc;
use web_time::{Duration, Instant};

#[cfg(feature = "gpu")]
pub(crate) use argil_gpu::HostEncoder;
pub(crate) use cpu::CpuDevice;
#[cfg(feature = "gpu")]
pub(crate) use gpu::{GpuDevice, GpuStorage};

/// The encoder of a host. Without GPU support there is none.
#[cfg(not(feature = "gpu"))]
#[derive(Debug)]
pub(crate) enum HostEncoder {}

/// The name and the duration in milliseconds of each stage of a build.
pub(crate) type StageTimings = Vec<(&'static str, f64)>;

/// An image to render.
pub(crate) struct RenderRequest<'a> {
    pub program: LazyProgram<'a>,
    #[cfg(feature = "gpu")]
    pub settings: &'a argil_render::RenderSettings,
    /// One for each sample of a pixel.
    pub frames: &'a [FrameUniform],
    /// The levels from which light reads distances that sparse bricks do not store.
    pub light: Option<Arc<Levels>>,
    /// Whether the output has what the rays of the first sample hit.
    pub with_hits: bool,
    pub control: &'a Control,
    /// When the image was asked for.
    pub start: Instant,
}

/// Paths of light to trace.
pub(crate) struct PathRequest<'a> {
    /// What paths on the CPU pass through.
    pub query: Query<'a>,
    pub frame: &'a FrameUniform,
    pub view: &'a PathView,
    pub options: &'a StillOptions,
    pub control: &'a Control,
}

/// How much of the edits to process.
pub(crate) struct EditWork<'a> {
    /// Maximum bytes of the result.
    pub memory_budget: Option<u64>,
    pub start: Instant,
    /// `None` for all of them.
    pub within: Option<Duration>,
    /// The encoder of a host, which submits the edits.
    #[cfg_attr(
        not(feature = "gpu"),
        expect(dead_code, reason = "only a GPU has encoders")
    )]
    pub encoder: Option<&'a mut HostEncoder>,
}

/// Declares [`Device`], and implements it for [`AnyDevice`], which calls the device that it holds.
macro_rules! devices {
    (
        reads { $($(#[$read_doc:meta])* fn $read:ident(&self $(, $read_arg:ident: $read_type:ty)*) -> $read_result:ty;)* }
        writes { $($(#[$write_doc:meta])* fn $write:ident(&mut self $(, $write_arg:ident: $write_type:ty)*) -> $write_result:ty;)* }
        reads_later { $($(#[$later_doc:meta])* async fn $later:ident(&self $(, $later_arg:ident: $later_type:ty)*) -> $later_result:ty;)* }
        writes_later { $($(#[$job_doc:meta])* async fn $job:ident(&mut self $(, $job_arg:ident: $job_type:ty)*) -> $job_result:ty;)* }
    ) => {
        /// What a device stores of a scene, and what it does with that.
        pub(crate) trait Device {
            $($(#[$read_doc])* fn $read(&self $(, $read_arg: $read_type)*) -> $read_result;)*
            $($(#[$write_doc])* fn $write(&mut self $(, $write_arg: $write_type)*) -> $write_result;)*
            $($(#[$later_doc])* async fn $later(&self $(, $later_arg: $later_type)*) -> $later_result;)*
            $($(#[$job_doc])* async fn $job(&mut self $(, $job_arg: $job_type)*) -> $job_result;)*
        }

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

devices! {
    reads {
        /// Whether its shaders are for one program only, so that they cannot follow edits.
        fn is_specialized(&self) -> bool;
        /// Returns the bytes of the program's tables on the device, besides those of the CPU.
        fn program_bytes(&self) -> u64;
        /// Returns the bytes of what is stored, or `None` if nothing but the program is.
        fn stored_bytes(&self) -> Option<u64>;
        /// Returns the bytes of the levels from which light reads distances, besides those of the CPU.
        fn light_bytes(&self) -> u64;
        /// Whether a volume is stored.
        fn has_volume(&self) -> bool;
        /// Whether paths of light pass through what is stored.
        fn has_paths(&self) -> bool;
        /// Returns the voxel grid that the stored volume has, or that the stored triangles came from.
        fn voxel_grid(&self) -> Option<VoxelGrid>;
        /// Returns the layout of stored sparse bricks.
        fn brick_layout(&self) -> Option<BrickLayout>;
        /// Returns the stored levels of detail.
        fn levels(&self) -> Option<&Levels>;
        /// Returns the numbers of stored triangles and vertices.
        fn mesh_counts(&self) -> Option<MeshCounts>;
        /// Returns the state for edits in place, if the stored volume supports them.
        fn edits(&self) -> Option<Box<dyn PendingEdits>>;
        /// Whether a host dropped an encoder with edits.
        fn has_lost_edits(&self) -> bool;
    }
    writes {
        /// Takes another program.
        fn set_program(&mut self, program: &Program) -> Result<(), BuildError>;
        /// Follows the edits of a program.
        fn follow_program(&mut self, live: &IncrementalProgram) -> Result<(), BuildError>;
        /// Compiles shaders for a program.
        fn specialize(&mut self, program: &Program) -> Result<(), BuildError>;
        /// Frees what is stored.
        fn clear(&mut self) -> ();
        /// Stores triangles.
        fn store_mesh(&mut self, mesh: Mesh, voxel_grid: VoxelGrid) -> Result<(), BuildError>;
        /// Returns the stored levels of detail, to change them.
        fn levels_mut(&mut self) -> Option<&mut Levels>;
        /// Follows changes of the stored levels of detail.
        fn follow_levels(&mut self) -> Result<(), RenderError>;
        /// Grows to the box that the edits have grown to.
        fn grow(&mut self, edits: &dyn PendingEdits) -> ();
    }
    reads_later {
        /// Describes the stored volume.
        async fn info(&self) -> Result<Option<VolumeInfo>, BuildError>;
        /// Returns the stored volume.
        async fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError>;
        /// Renders an image. Returns it, and the time in milliseconds.
        async fn render(&self, request: RenderRequest<'_>) -> Result<(RenderOutput, f64), RenderError>;
        /// Adds paths of light to a still, if paths pass through what is stored.
        async fn trace_paths(&self, request: PathRequest<'_>, still: &mut Still) -> Result<(), StillError>;
        /// Extracts triangles from the stored volume, if there is one.
        async fn volume_mesh(&self, options: &MeshOptions, stages: &mut Stages) -> Result<Option<Mesh>, MeshError>;
        /// Extracts triangles of the field by marching cubes, unless the CPU does that.
        async fn field_mesh(&self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, normals: MeshNormals, stages: &mut Stages) -> Result<Option<Mesh>, MeshError>;
    }
    writes_later {
        /// Builds and stores a dense volume.
        async fn build_dense(&mut self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, encoding: Encoding, mips: bool, fill: DenseFill) -> Result<StageTimings, BuildError>;
        /// Builds and stores an octree.
        async fn build_octree(&mut self, site: &BuildContext<'_>, layout: OctreeLayout, brick_test: BrickTest, order: BrickOrdering) -> Result<StageTimings, BuildError>;
        /// Builds and stores sparse bricks of at most `budget` bytes.
        async fn build_bricks(&mut self, site: &BuildContext<'_>, layout: BrickLayout, budget: Option<u64>) -> Result<StageTimings, BuildError>;
        /// Builds and stores triangles of the field by marching cubes, unless the CPU does that.
        async fn build_mesh(&mut self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, flat: bool) -> Result<Option<StageTimings>, BuildError>;
        /// Stores a volume of the CPU.
        async fn store_volume(&mut self, volume: Volume) -> Result<(), BuildError>;
        /// Processes remaining edits of the stored volume. Returns what they did, as far as that is known.
        async fn edit(&mut self, live: &IncrementalProgram, edits: &mut dyn PendingEdits, work: EditWork<'_>) -> Result<EditStats, BuildError>;
        /// Waits for edits. Returns what they did since the last call, and was not known before.
        async fn flush(&mut self) -> Result<EditStats, BuildError>;
        /// Frees unused memory, and waits for that.
        async fn shrink_to_fit(&mut self) -> Result<(), BuildError>;
    }
}

/// The device of a world.
#[derive(Debug)]
#[cfg_attr(
    all(target_pointer_width = "64", feature = "gpu"),
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
