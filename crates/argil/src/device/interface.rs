//! What a device stores of a scene, and what it does with that. `methods.rs` lists it.

use crate::build_context::BuildContext;
use crate::field_mesh::Stages;
use crate::still_error::StillError;
use crate::{BuildError, MeshCounts, MeshError, MeshOptions, RenderError};
use argil_abi::FrameUniform;
use argil_field::{IncrementalProgram, Program};
use argil_math::Control;
use argil_mesh::{Mesh, MeshNormals};
use argil_render::{PathScene, PathView, RenderOutput, Still, StillOptions};
use argil_volume::{
    BrickLayout, BrickOrdering, BrickTest, DenseFill, EditStats, Encoding, Levels, OctreeLayout,
    PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use std::borrow::Cow;
use std::sync::Arc;
use web_time::{Duration, Instant};

#[cfg(feature = "gpu")]
pub(crate) use argil_gpu::HostEncoder;

/// The encoder of a host. Without GPU support there is none.
#[cfg(not(feature = "gpu"))]
#[derive(Debug)]
pub(crate) enum HostEncoder {}

/// The name and the duration in milliseconds of each stage of a build.
pub(crate) type StageTimings = Vec<(&'static str, f64)>;

/// Returns the program of a world. After edits, it is put together when it is first needed.
pub(crate) type LazyProgram<'a> = &'a (dyn Fn() -> &'a Program + Send + Sync);

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
#[cfg_attr(
    not(feature = "gpu"),
    expect(dead_code, reason = "on the CPU, the scene knows these")
)]
pub(crate) struct PathRequest<'a> {
    /// What paths on the CPU pass through.
    pub scene: &'a dyn PathScene,
    pub program: &'a Program,
    /// Points nearer than this lie on the surface.
    pub epsilon: f32,
    /// How far above a surface rays begin that leave it.
    pub lift: f32,
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

/// Declares [`Device`].
macro_rules! declare {
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
    };
}

device_methods!(declare);
