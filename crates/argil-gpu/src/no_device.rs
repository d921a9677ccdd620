//! Replaces the device if none is compiled in: types without values, so that nothing here can ever be called.

use crate::{
    BrickOrdering, DenseFill, DeviceInfo, GpuCounters, GpuError, StageTimings, SurfaceOptions,
};
use argil_abi::FrameUniform;
use argil_field::{IncrementalProgram, Program};
use argil_math::Control;
use argil_mesh::Mesh;
use argil_render::{PathTables, RenderOutput, Still, StillOptions, Triangles};
use argil_volume::{
    BrickLayout, BrickTest, EditStats, Encoding, Levels, OctreeLayout, PendingEdits, Volume,
    VolumeInfo, VoxelGrid,
};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Lists the graphics devices of this machine: none.
pub async fn devices() -> Vec<DeviceInfo> {
    Vec::new()
}

/// A graphics device.
#[derive(Debug)]
pub enum Gpu {}

/// The encoder of a host.
#[derive(Debug)]
pub enum HostEncoder {}

/// An image that stays on a device.
#[derive(Debug)]
pub enum ImageTextures {}

/// Where a rendered image goes.
#[derive(Clone, Copy, Debug)]
pub enum ImageOutput<'a> {
    /// To the CPU.
    Cpu,
    /// To the CPU, with what the rays of the first sample hit.
    CpuWithHits,
    /// Into textures, with the lengths of the rays of the first sample. The image on the CPU has no pixels.
    Textures(&'a ImageTextures),
}

/// A program on a device.
#[derive(Debug)]
pub enum GpuProgram {}

/// A volume on a device.
#[derive(Debug)]
pub enum GpuVolume {}

/// Triangles on a device.
#[derive(Debug)]
pub enum GpuMesh {}

/// What paths are to be traced.
#[derive(Clone, Copy, Debug)]
pub struct PathWork<'a> {
    /// The camera, the size and the ground.
    pub frame: &'a FrameUniform,
    /// Lights.
    pub tables: &'a PathTables,
    /// The program on the device.
    pub program: &'a Program,
    /// How many paths.
    pub options: &'a StillOptions,
    /// Cancels the work, and learns of its progress.
    pub control: &'a Control,
}

impl Gpu {
    /// Opens the best device.
    ///
    /// # Errors
    /// Always: this program was compiled without GPU support.
    pub async fn open() -> Result<Self, GpuError> {
        Err(GpuError::NotCompiled)
    }

    /// Describes the device.
    pub fn info(&self) -> &DeviceInfo {
        match *self {}
    }

    /// Returns the number of pixels of the largest image.
    pub fn max_pixels(&self) -> u64 {
        match *self {}
    }

    /// Returns what the device has been asked to do.
    pub fn counters(&self) -> GpuCounters {
        match *self {}
    }

    /// Keeps compiled pipelines in a folder.
    #[must_use]
    pub fn with_pipeline_cache(self, _: &Path) -> Self {
        match self {}
    }
}

impl GpuProgram {
    /// Uploads a program.
    ///
    /// # Errors
    /// Never: there is no device.
    pub fn new(gpu: Arc<Gpu>, _: &Program, _: bool) -> Result<Self, GpuError> {
        match *gpu {}
    }

    /// Replaces the program.
    ///
    /// # Errors
    /// Never.
    pub fn update(&mut self, _: &Program) -> Result<(), GpuError> {
        match *self {}
    }

    /// Follows an incremental program.
    ///
    /// # Errors
    /// Never.
    pub fn update_from(&mut self, _: &IncrementalProgram) -> Result<(), GpuError> {
        match *self {}
    }

    /// Uploads the instructions.
    pub fn upload_instructions<'a>(&self, _: impl FnOnce() -> &'a Program) {
        match *self {}
    }

    /// Whether its shaders are for one program only.
    pub fn is_specialized(&self) -> bool {
        match *self {}
    }

    /// Renders.
    ///
    /// # Errors
    /// Never.
    pub async fn render(
        &self,
        _: &[FrameUniform],
        _: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), GpuError> {
        match *self {}
    }

    /// Adds paths of light to a still.
    ///
    /// # Errors
    /// Never.
    pub async fn trace_paths(&self, _: PathWork<'_>, _: &mut Still) -> Result<(), GpuError> {
        match *self {}
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        match *self {}
    }

    /// Returns the bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }
}

/// Functions that create a volume, which cannot exist, and methods of such a value.
macro_rules! never {
    ($($(#[$doc:meta])* $name:ident($($argument:ty),*) -> $result:ty;)*) => {
        $($(#[$doc])*
        ///
        /// # Errors
        /// Never.
        pub async fn $name(&self, $(_: $argument),*) -> Result<$result, GpuError> {
            match *self {}
        })*
    };
}

impl GpuVolume {
    /// Uploads a volume.
    ///
    /// # Errors
    /// Never.
    pub async fn upload(field: &GpuProgram, _: &Volume) -> Result<Self, GpuError> {
        match *field {}
    }

    /// Whether paths of light pass through it.
    pub fn has_paths(&self) -> bool {
        match *self {}
    }

    /// Adds paths of light to a still, through the volume.
    ///
    /// # Errors
    /// Never.
    pub async fn trace_paths(
        &self,
        _: &GpuProgram,
        _: PathWork<'_>,
        _: &mut Still,
    ) -> Result<(), GpuError> {
        match *self {}
    }

    /// Returns the levels of detail, of which the device has a copy.
    pub fn levels(&self) -> Option<&Levels> {
        match *self {}
    }

    /// Returns the same levels, to change them.
    pub fn levels_mut(&mut self) -> Option<&mut Levels> {
        match *self {}
    }

    /// Uploads what changed in the levels.
    ///
    /// # Errors
    /// Never.
    pub fn follow_levels(&mut self, _: &Gpu) -> Result<(), GpuError> {
        match *self {}
    }

    /// Returns the layout of sparse bricks.
    pub fn brick_layout(&self) -> Option<BrickLayout> {
        match *self {}
    }

    /// Returns the bytes of the levels that light reads.
    pub fn light_memory_bytes(&self) -> u64 {
        match *self {}
    }

    /// Sets the levels from which light reads distances.
    ///
    /// # Errors
    /// Never.
    pub fn set_light(&self, _: &Gpu, _: Option<&Arc<Levels>>) -> Result<(), GpuError> {
        match *self {}
    }

    /// Builds a dense volume.
    ///
    /// # Errors
    /// Never.
    pub async fn dense(
        field: &GpuProgram,
        _: &Program,
        _: VoxelGrid,
        _: Encoding,
        _: bool,
        _: DenseFill,
    ) -> Result<(Self, StageTimings), GpuError> {
        match *field {}
    }

    /// Builds an octree.
    ///
    /// # Errors
    /// Never.
    pub async fn octree(
        field: &GpuProgram,
        _: &Program,
        _: OctreeLayout,
        _: BrickTest,
        _: BrickOrdering,
    ) -> Result<(Self, StageTimings), GpuError> {
        match *field {}
    }

    /// Builds sparse bricks.
    ///
    /// # Errors
    /// Never.
    pub async fn bricks(
        field: &GpuProgram,
        _: &Program,
        _: BrickLayout,
        _: Option<u64>,
    ) -> Result<(Self, StageTimings), GpuError> {
        match *field {}
    }

    /// Builds sparse bricks.
    ///
    /// # Errors
    /// Never.
    pub async fn bricks_with_control(
        field: &GpuProgram,
        _: &Program,
        _: BrickLayout,
        _: Option<u64>,
        _: &argil_math::Control,
    ) -> Result<(Self, StageTimings), GpuError> {
        match *field {}
    }

    never! {
        /// Renders.
        render(&GpuProgram, &[FrameUniform], ImageOutput<'_>) -> (RenderOutput, f64);
        /// Describes the volume.
        info(&Gpu) -> VolumeInfo;
        /// Downloads the volume.
        download(&Gpu) -> Volume;
        /// Extracts the surface.
        march(&GpuProgram, &SurfaceOptions) -> (GpuMesh, StageTimings);
        /// Waits for edits.
        flush(&Gpu) -> EditStats;
        /// Frees unused memory.
        shrink_to_fit(&GpuProgram) -> ();
        /// Submits edits.
        edit(&GpuProgram, &IncrementalProgram, &mut dyn PendingEdits, Option<u64>, (Option<Duration>, Option<&mut HostEncoder>)) -> ();
    }

    /// Returns the voxel grid.
    pub fn voxel_grid(&self) -> &VoxelGrid {
        match *self {}
    }

    /// Returns the format and band of samples.
    pub fn encoding(&self) -> &Encoding {
        match *self {}
    }

    /// Returns the state for edits in place.
    pub fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        match *self {}
    }

    /// Grows to a larger box with the same voxels.
    pub fn grow(&mut self, _: &dyn PendingEdits) {
        match *self {}
    }

    /// Whether an encoder with edits was dropped.
    pub fn has_lost_edits(&self) -> bool {
        match *self {}
    }

    /// Returns the bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }
}

impl GpuMesh {
    /// Uploads triangles.
    ///
    /// # Errors
    /// Never.
    pub fn upload(field: &GpuProgram, _: Triangles<'_>) -> Result<Self, GpuError> {
        match *field {}
    }

    /// Returns the numbers of triangles and vertices.
    pub fn counts(&self) -> [u64; 2] {
        match *self {}
    }

    /// Returns the bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }

    never! {
        /// Downloads the triangles.
        download(&Gpu) -> Mesh;
        /// Renders.
        render(&GpuProgram, &[FrameUniform], ImageOutput<'_>) -> (RenderOutput, f64);
    }
}
