//! In place of a device, where none is compiled in: types without values, so that nothing here can ever be called.

use crate::{DenseFill, DeviceInfo, GpuError, MarchOptions, Order, StagesMs};
use argil_abi::FrameUniform;
use argil_field::{LiveProgram, Program};
use argil_mesh::Mesh;
use argil_render::{Picture, Triangles};
use argil_volume::{
    BrickEdit, BrickLayout, Edits, Encoding, Keep, Lattice, Layout, Volume, VolumeInfo,
};
use std::sync::Arc;
use std::time::Duration;

/// The graphics devices of this machine: none that this program could use.
pub async fn devices() -> Vec<DeviceInfo> {
    Vec::new()
}

/// A device.
pub enum Gpu {}

/// A field on a device.
pub enum GpuProgram {}

/// A volume on a device.
pub enum GpuVolume {}

/// Triangles on a device.
pub enum GpuMesh {}

impl Gpu {
    /// Open the best device.
    ///
    /// # Errors
    /// Always: this program was compiled without any.
    pub async fn open() -> Result<Self, GpuError> {
        Err(GpuError::LeftOut)
    }

    /// What it is.
    pub fn info(&self) -> &DeviceInfo {
        match *self {}
    }

    /// Pixels of the largest picture.
    pub fn max_pixels(&self) -> u64 {
        match *self {}
    }
}

impl GpuProgram {
    /// Bring a program to a device.
    ///
    /// # Errors
    /// Never: there is no device to be brought to.
    pub fn new(gpu: Arc<Gpu>, _: &Program, _: bool) -> Result<Self, GpuError> {
        match *gpu {}
    }

    /// Compile the passes of pictures.
    ///
    /// # Errors
    /// Never.
    pub fn prepare(&self) -> Result<(), GpuError> {
        match *self {}
    }

    /// Take over another program.
    ///
    /// # Errors
    /// Never.
    pub fn update(&mut self, _: &Program) -> Result<(), GpuError> {
        match *self {}
    }

    /// Follow a live program.
    ///
    /// # Errors
    /// Never.
    pub fn update_from(&mut self, _: &LiveProgram) -> Result<(), GpuError> {
        match *self {}
    }

    /// Bring over the instructions.
    pub fn upload_instructions<'a>(&self, _: impl FnOnce() -> &'a Program) {
        match *self {}
    }

    /// Whether its shaders are for one program alone.
    pub fn is_specialized(&self) -> bool {
        match *self {}
    }

    /// Draw.
    ///
    /// # Errors
    /// Never.
    pub async fn render(&self, _: &[FrameUniform], _: bool) -> Result<(Picture, f64), GpuError> {
        match *self {}
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        match *self {}
    }

    /// Bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }
}

/// Functions that make a volume of a field, which there is not; and methods of a value that there is not.
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
    /// Bring a volume over.
    ///
    /// # Errors
    /// Never.
    pub async fn upload(field: &GpuProgram, _: &Volume) -> Result<Self, GpuError> {
        match *field {}
    }

    /// A dense volume.
    ///
    /// # Errors
    /// Never.
    pub async fn dense(
        field: &GpuProgram,
        _: &Program,
        _: Lattice,
        _: Encoding,
        _: bool,
        _: DenseFill,
    ) -> Result<(Self, StagesMs), GpuError> {
        match *field {}
    }

    /// An octree.
    ///
    /// # Errors
    /// Never.
    pub async fn octree(
        field: &GpuProgram,
        _: &Program,
        _: Layout,
        _: Keep,
        _: Order,
    ) -> Result<(Self, StagesMs), GpuError> {
        match *field {}
    }

    /// Sparse bricks.
    ///
    /// # Errors
    /// Never.
    pub async fn bricks(
        field: &GpuProgram,
        _: &Program,
        _: BrickLayout,
        _: Option<u64>,
    ) -> Result<(Self, StagesMs), GpuError> {
        match *field {}
    }

    /// Sparse bricks.
    ///
    /// # Errors
    /// Never.
    pub async fn bricks_controlled(
        field: &GpuProgram,
        _: &Program,
        _: BrickLayout,
        _: Option<u64>,
        _: &argil_math::Control,
    ) -> Result<(Self, StagesMs), GpuError> {
        match *field {}
    }

    never! {
        /// Draw.
        render(&GpuProgram, &[FrameUniform], bool) -> (Picture, f64);
        /// What it is.
        info(&Gpu) -> VolumeInfo;
        /// Bring the volume back.
        read(&Gpu) -> Volume;
        /// Its surface.
        march(&GpuProgram, &MarchOptions) -> (GpuMesh, StagesMs);
        /// Wait for edits.
        settle(&Gpu) -> BrickEdit;
        /// Give back room.
        trim(&GpuProgram) -> ();
        /// Submit edits.
        edit(&GpuProgram, &LiveProgram, &mut dyn Edits, Option<u64>, Option<Duration>) -> ();
    }

    /// Where the voxels lie.
    pub fn lattice(&self) -> &Lattice {
        match *self {}
    }

    /// What texels mean.
    pub fn encoding(&self) -> &Encoding {
        match *self {}
    }

    /// What following edits takes.
    pub fn edits(&self) -> Option<Box<dyn Edits>> {
        match *self {}
    }

    /// The same voxels over a larger box.
    ///
    /// # Errors
    /// Never.
    pub fn grow(&mut self, _: &Gpu, _: &dyn Edits) -> Result<(), GpuError> {
        match *self {}
    }

    /// Bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }
}

impl GpuMesh {
    /// Bring triangles over.
    ///
    /// # Errors
    /// Never.
    pub fn upload(field: &GpuProgram, _: Triangles<'_>) -> Result<Self, GpuError> {
        match *field {}
    }

    /// Corners and triangles.
    pub fn counts(&self) -> [u64; 2] {
        match *self {}
    }

    /// Bytes on the device.
    pub fn memory_bytes(&self) -> u64 {
        match *self {}
    }

    never! {
        /// Bring triangles back.
        read(&Gpu) -> Mesh;
        /// Draw.
        render(&GpuProgram, &[FrameUniform], bool) -> (Picture, f64);
    }
}
