//! A volume on the device: what all kinds share, and the trait that each implements in its own file.

use crate::frame_extras::FrameExtras;
use crate::render::RenderPasses;
use crate::resources::uniform_for;
use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::trace_mode::{BoundResource, TraceMode};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuProgram, HostEncoder, ImageOutput};
use argil_abi::{BrickUniform, DenseUniform, FrameUniform};
use argil_field::IncrementalProgram;
use argil_render::RenderOutput;
use argil_volume::{
    BrickLayout, EditStats, Encoding, Levels, PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;
use web_time::Duration;

/// A kind of volume on the device, besides its texture.
pub(crate) trait VolumeTables: std::fmt::Debug + Any + Send + Sync {
    /// Returns how its images are traced.
    fn way(&self) -> &'static TraceMode;

    /// Adds its bindings besides the texture and the uniform.
    fn bind(&self, _bound: &mut Vec<BoundResource>) {}

    /// Returns the bytes of textures and tables.
    fn memory_bytes(&self, body: &VolumeStorage) -> u64;

    /// Describes the volume, after waiting for edits.
    fn info<'a>(&'a self, info: VolumeInfo, _gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move { Ok(info) })
    }

    /// Downloads the volume.
    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume>;

    /// Returns the state for edits in place, if this kind supports them.
    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        None
    }

    /// Grows to the box that the edits have grown to, with the next edit. Samples nothing.
    fn grow(&mut self, _body: &mut VolumeStorage, _edits: &dyn PendingEdits) {}

    /// Whether an encoder with edits was dropped.
    fn has_lost_edits(&self) -> bool {
        false
    }

    /// Submits remaining edits, or encodes them for a host.
    fn edit<'a>(
        &'a mut self,
        _body: &'a mut VolumeStorage,
        _edit: EditContext<'a>,
    ) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// Waits for edits. Returns what they did since the last call.
    fn wait_for_counters<'a>(&'a mut self, _gpu: &'a Gpu) -> Work<'a, EditStats> {
        Box::pin(async { Ok(EditStats::default()) })
    }

    /// Waits for edits, and frees unused memory.
    fn trim<'a>(
        &'a mut self,
        _body: &'a mut VolumeStorage,
        _field: &'a GpuProgram,
    ) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// Returns the uniform for shaders, as bytes, for a frame's camera.
    fn uniform(&self, frame: &FrameUniform) -> Cow<'_, [u8]>;

    /// Returns a table that the rays of an image mark. It is cleared before.
    fn marks(&self) -> Option<&StorageBuffer> {
        None
    }

    /// Notes what the rays of an image marked.
    fn note_marks(&self, _frame: &FrameUniform, _marks: &[u8]) {}

    /// Returns the levels of detail whose copy this is.
    fn levels(&self) -> Option<&Levels> {
        None
    }

    /// Returns the same levels, to change them.
    fn levels_mut(&mut self) -> Option<&mut Levels> {
        None
    }

    /// Uploads what changed in the levels.
    fn follow_levels(&mut self, _body: &mut VolumeStorage, _gpu: &Gpu) -> Result<(), GpuError> {
        Ok(())
    }

    /// Returns the layout of sparse bricks.
    fn brick_layout(&self) -> Option<BrickLayout> {
        None
    }

    /// Returns the bytes of the levels from which light reads distances.
    fn light_memory_bytes(&self) -> u64 {
        0
    }

    /// Uploads the levels from which light reads distances that are not stored.
    fn set_light(&self, _gpu: &Gpu, _levels: Option<&Arc<Levels>>) -> Result<(), GpuError> {
        Ok(())
    }

    /// Returns how to mesh it, if that is possible.
    fn cut(&self) -> Option<ClipUpdate<'_>> {
        None
    }
}

/// Remaining edits, and how much of them to submit.
pub(crate) struct EditContext<'a> {
    pub field: &'a GpuProgram,
    /// The program that the field [follows](GpuProgram::update_from).
    pub incremental: &'a IncrementalProgram,
    pub edits: &'a mut dyn PendingEdits,
    /// Maximum bytes.
    pub budget: Option<u64>,
    /// Submit about as much as the device does in this time.
    pub within: Option<Duration>,
    /// The encoder of a host, which submits the edits.
    pub encoder: Option<&'a mut wgpu::CommandEncoder>,
}

/// How to mesh a volume.
pub(crate) enum ClipUpdate<'a> {
    /// By samples of the grid.
    Dense(&'a DenseUniform),
    /// By bricks, with a table of cells.
    Bricks(&'a StorageBuffer, &'a BrickUniform),
}

/// What every volume has on the device.
#[derive(Debug)]
pub(crate) struct VolumeStorage {
    pub voxel_grid: VoxelGrid,
    pub encoding: Encoding,
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    uniform: wgpu::Buffer,
}

impl VolumeStorage {
    /// Replaces the texture.
    pub(crate) fn set_texture(&mut self, texture: wgpu::Texture) {
        self.view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.texture = texture;
    }

    /// Returns the bytes of a texel.
    pub(crate) fn texel_bytes(&self) -> u64 {
        TexelFormat::of(self.texture.format()).bytes() as u64
    }

    /// Returns the bytes of a texture with the grid's size, including levels.
    pub(crate) fn texture_bytes(&self) -> u64 {
        (0..self.texture.mip_level_count())
            .map(|level| self.voxel_grid.texel_count(level) * self.texel_bytes())
            .sum()
    }
}

/// A volume on a device.
///
/// [`GpuVolume::bricks`], [`GpuVolume::dense`] and [`GpuVolume::octree`] build one, and [`GpuVolume::upload`]
/// copies one from the CPU.
#[derive(Debug)]
pub struct GpuVolume {
    body: VolumeStorage,
    kind: Box<dyn VolumeTables>,
}

impl GpuVolume {
    pub(crate) fn new(
        field: &GpuProgram,
        (voxel_grid, encoding): (VoxelGrid, Encoding),
        texture: wgpu::Texture,
        kind: impl VolumeTables,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let (view, sampler, uniform) = gpu.with_error_scope(|| {
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("stored distances"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            });
            let bytes = kind.uniform(&FrameUniform::default()).len() as u64;
            (view, sampler, uniform_for(gpu, "volume", bytes))
        })?;
        Ok(Self {
            body: VolumeStorage {
                voxel_grid,
                encoding,
                texture,
                view,
                sampler,
                uniform,
            },
            kind: Box::new(kind),
        })
    }

    /// Renders as [`GpuProgram::render`] does, with primary rays and normals through the volume.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn render(
        &self,
        field: &GpuProgram,
        frames: &[FrameUniform],
        output: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), GpuError> {
        let Some(first) = frames.first() else {
            return Ok((RenderOutput::empty(), 0.0));
        };
        let (passes, bound) = self.picture(field, first, self.uniform())?;
        let mut extras = FrameExtras::of(output);
        extras.marks = self.kind.marks();
        let drawn = passes.draw(field, bound, extras, frames).await?;
        self.kind.note_marks(first, &drawn.marks);
        Ok((drawn.picture, drawn.duration_ms))
    }

    /// Returns the passes of a frame, and what they are bound to, with a uniform that is written.
    pub(crate) fn picture(
        &self,
        field: &GpuProgram,
        first: &FrameUniform,
        uniform: &wgpu::Buffer,
    ) -> Result<(Arc<RenderPasses>, Vec<BoundResource>), GpuError> {
        let passes = field.picture(self.way(), first)?;
        Ok((passes, self.bound(field.gpu(), first, uniform)))
    }

    /// Returns the uniform of all frames but a host's.
    pub(crate) fn uniform(&self) -> &wgpu::Buffer {
        &self.body.uniform
    }

    /// Writes the uniform, and returns what passes are bound to.
    pub(crate) fn bound(
        &self,
        gpu: &Gpu,
        frame: &FrameUniform,
        uniform: &wgpu::Buffer,
    ) -> Vec<BoundResource> {
        gpu.write_buffer(uniform, 0, &self.kind.uniform(frame));
        let mut bound = vec![
            BoundResource::buffer(argil_abi::BIND_VOLUME, uniform),
            BoundResource::View(argil_abi::BIND_STORED, self.body.view.clone()),
            BoundResource::Sampler(argil_abi::BIND_LINEAR, self.body.sampler.clone()),
        ];
        self.kind.bind(&mut bound);
        bound
    }

    /// Returns how its images are traced.
    pub(crate) fn way(&self) -> &'static TraceMode {
        self.kind.way()
    }

    /// Returns the levels of detail, of which the device has a copy, or `None` for another kind.
    pub fn levels(&self) -> Option<&Levels> {
        self.kind.levels()
    }

    /// Returns the same levels, to change them. [`GpuVolume::follow_levels`] uploads what changed.
    pub fn levels_mut(&mut self) -> Option<&mut Levels> {
        self.kind.levels_mut()
    }

    /// Uploads what changed in the levels.
    ///
    /// # Errors
    /// If they exceed the device's limits or memory.
    pub fn follow_levels(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        self.kind.follow_levels(&mut self.body, gpu)
    }

    /// Returns the layout of sparse bricks, or `None` for another kind.
    pub fn brick_layout(&self) -> Option<BrickLayout> {
        self.kind.brick_layout()
    }

    /// Returns the bytes of the levels that light reads, which [`GpuVolume::memory_bytes`] does not count.
    pub fn light_memory_bytes(&self) -> u64 {
        self.kind.light_memory_bytes()
    }

    /// Sets the levels from which light reads distances that bricks do not store: see
    /// [`LightLevels`](argil_volume::LightLevels). Other kinds ignore them.
    ///
    /// # Errors
    /// If they exceed the device's limits or memory.
    pub fn set_light(&self, gpu: &Gpu, levels: Option<&Arc<Levels>>) -> Result<(), GpuError> {
        self.kind.set_light(gpu, levels)
    }

    /// Returns the voxel grid.
    pub fn voxel_grid(&self) -> &VoxelGrid {
        &self.body.voxel_grid
    }

    /// Returns the format and band of samples.
    pub fn encoding(&self) -> &Encoding {
        &self.body.encoding
    }

    /// Describes the volume, after waiting for edits.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn info(&self, gpu: &Gpu) -> Result<VolumeInfo, GpuError> {
        let body = &self.body;
        let mut info = VolumeInfo::new(body.voxel_grid, body.encoding, self.memory_bytes());
        info.levels = body.texture.mip_level_count();
        self.kind.info(info, gpu).await
    }

    /// Returns the bytes of textures and tables on the device.
    pub fn memory_bytes(&self) -> u64 {
        self.kind.memory_bytes(&self.body)
    }

    /// Downloads the volume.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn download(&self, gpu: &Gpu) -> Result<Volume, GpuError> {
        self.kind.read(&self.body, gpu).await
    }

    /// Returns the state for edits in place, if this kind supports them.
    pub fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        self.kind.edits()
    }

    /// Grows to the box that its edits have [grown to](PendingEdits::grow_to), with the next edit. Samples nothing.
    pub fn grow(&mut self, edits: &dyn PendingEdits) {
        self.kind.grow(&mut self.body, edits);
    }

    /// Whether an encoder with edits was dropped before it was submitted. The volume must be built again.
    pub fn has_lost_edits(&self) -> bool {
        self.kind.has_lost_edits()
    }

    /// Submits remaining edits without waiting, all of them or about as much as the device does in a time. `incremental`
    /// is the program that `field` [follows](GpuProgram::update_from). With an encoder, its owner submits them.
    ///
    /// # Errors
    /// If the result would exceed `budget` bytes. The batch in progress is lost then.
    pub async fn edit(
        &mut self,
        field: &GpuProgram,
        incremental: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        budget: Option<u64>,
        (within, encoder): (Option<Duration>, Option<&mut HostEncoder>),
    ) -> Result<(), GpuError> {
        let editing = EditContext {
            field,
            incremental,
            edits,
            budget,
            within,
            encoder,
        };
        self.kind.edit(&mut self.body, editing).await
    }

    /// Waits for edits. Returns what they did since the last call.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn flush(&mut self, gpu: &Gpu) -> Result<EditStats, GpuError> {
        self.kind.wait_for_counters(gpu).await
    }

    /// Waits for edits, and frees unused memory.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn shrink_to_fit(&mut self, field: &GpuProgram) -> Result<(), GpuError> {
        self.kind.trim(&mut self.body, field).await
    }

    pub(crate) fn body(&self) -> &VolumeStorage {
        &self.body
    }

    pub(crate) fn cut(&self) -> Option<ClipUpdate<'_>> {
        self.kind.cut()
    }
}

macro_rules! volumes {
    ($($name:ident),*) => {
        impl GpuVolume {
            /// Uploads a volume. `field` is the program that it was made from, which provides light.
            ///
            /// # Errors
            /// If the volume exceeds the device's limits or memory.
            pub async fn upload(field: &GpuProgram, volume: &Volume) -> Result<Self, GpuError> {
                match volume { $(Volume::$name(stored) => Upload::upload(stored, field).await,)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);

/// A volume that can be uploaded.
pub(crate) trait Upload {
    /// Uploads it.
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume>;
}
