//! A volume on the device: what all representations have there, and the trait that each implements in its own file.

use crate::resources::uniform_for;
use crate::storage_buffer::StorageBuffer;
use crate::texel_format::TexelFormat;
use crate::trace_mode::{BoundResource, TraceMode};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuProgram};
use argil_abi::{BrickVolume, DenseVolume, FrameUniform};
use argil_field::IncrementalProgram;
use argil_render::RenderOutput;
use argil_volume::{EditStats, Encoding, PendingEdits, Volume, VolumeInfo, VoxelGrid};
use std::any::Any;
use web_time::Duration;

/// What a representation is on the device, besides its texture.
pub(crate) trait VolumeTables: std::fmt::Debug + Any + Send + Sync {
    /// How its pictures are marched.
    fn way(&self) -> &'static TraceMode;

    /// What that reads besides the texture and the words.
    fn bind(&self, _bound: &mut Vec<BoundResource>) {}

    /// Bytes of textures and tables.
    fn memory_bytes(&self, body: &VolumeStorage) -> u64;

    /// What it is: more than its lattice, encoding and bytes, after a wait for edits.
    fn info<'a>(&'a self, info: VolumeInfo, _gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move { Ok(info) })
    }

    /// Brings it back.
    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume>;

    /// What following edits takes, of one that is changed in place.
    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        None
    }

    /// Lies over the box that its edits have grown to. Nothing is sampled.
    fn grow(
        &mut self,
        _body: &mut VolumeStorage,
        _gpu: &Gpu,
        _edits: &dyn PendingEdits,
    ) -> Result<(), GpuError> {
        Ok(())
    }

    /// Submits what its edits have left to be done.
    fn edit<'a>(
        &'a mut self,
        _body: &'a mut VolumeStorage,
        _edit: EditContext<'a>,
    ) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// Waits for edits; what they did since the last time.
    fn settle<'a>(&'a mut self, _gpu: &'a Gpu) -> Work<'a, EditStats> {
        Box::pin(async { Ok(EditStats::default()) })
    }

    /// Waits for edits, and gives back the room that they have left.
    fn trim<'a>(
        &'a mut self,
        _body: &'a mut VolumeStorage,
        _field: &'a GpuProgram,
    ) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// The uniform that its shaders read, as bytes.
    fn uniform(&self) -> &[u8];

    /// How its surface is cut into triangles, if it is.
    fn cut(&self) -> Option<ClipUpdate<'_>> {
        None
    }
}

/// What edits have left to be done, and how much of it now.
pub(crate) struct EditContext<'a> {
    pub field: &'a GpuProgram,
    /// What the field [follows](GpuProgram::update).
    pub live: &'a IncrementalProgram,
    pub edits: &'a mut dyn PendingEdits,
    /// Bytes that there may be.
    pub budget: Option<u64>,
    /// About as much as the device does in that time.
    pub within: Option<Duration>,
}

/// How triangles are found.
pub(crate) enum ClipUpdate<'a> {
    /// Texel by texel of the lattice.
    Dense(&'a DenseVolume),
    /// Brick by brick, by a table of cells.
    Bricks(&'a StorageBuffer, &'a BrickVolume),
}

/// What every volume has on the device.
#[derive(Debug)]
pub(crate) struct VolumeStorage {
    pub lattice: VoxelGrid,
    pub encoding: Encoding,
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    uniform: wgpu::Buffer,
}

impl VolumeStorage {
    /// Another texture in place of the old.
    pub(crate) fn set_texture(&mut self, texture: wgpu::Texture) {
        self.view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.texture = texture;
    }

    /// Bytes of a texel.
    pub(crate) fn texel_bytes(&self) -> u64 {
        TexelFormat::of(self.texture.format()).bytes() as u64
    }

    /// Bytes of a texture as large as the lattice, with its levels.
    pub(crate) fn texture_bytes(&self) -> u64 {
        (0..self.texture.mip_level_count())
            .map(|level| self.lattice.texel_count(level) * self.texel_bytes())
            .sum()
    }
}

/// A volume on a device.
#[derive(Debug)]
pub struct GpuVolume {
    body: VolumeStorage,
    kind: Box<dyn VolumeTables>,
}

impl GpuVolume {
    pub(crate) fn new(
        field: &GpuProgram,
        (lattice, encoding): (VoxelGrid, Encoding),
        texture: wgpu::Texture,
        kind: impl VolumeTables,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        // Compiled now, if it was not yet, and not when the first picture is wanted.
        field.picture(kind.way())?;
        let (view, sampler, uniform) = gpu.with_error_scope(|| {
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("stored distances"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            });
            let bytes = kind.uniform().len() as u64;
            (view, sampler, uniform_for(gpu, "volume", bytes))
        })?;
        Ok(Self {
            body: VolumeStorage {
                lattice,
                encoding,
                texture,
                view,
                sampler,
                uniform,
            },
            kind: Box::new(kind),
        })
    }

    /// Draws as [`GpuProgram::render`] does, primary rays and normals through the volume.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn render(
        &self,
        field: &GpuProgram,
        frames: &[FrameUniform],
        with_hits: bool,
    ) -> Result<(RenderOutput, f64), GpuError> {
        let uniform = &self.body.uniform;
        let gpu = field.gpu();
        gpu.queue.write_buffer(uniform, 0, self.kind.uniform());
        let mut bound = vec![
            BoundResource::buffer(argil_abi::BIND_VOLUME, uniform),
            BoundResource::View(argil_abi::BIND_STORED, self.body.view.clone()),
            BoundResource::Sampler(argil_abi::BIND_LINEAR, self.body.sampler.clone()),
        ];
        self.kind.bind(&mut bound);
        let passes = field.picture(self.kind.way())?;
        passes.draw(field, bound, None, frames, with_hits).await
    }

    /// Where the voxels lie.
    pub fn lattice(&self) -> &VoxelGrid {
        &self.body.lattice
    }

    /// What texels mean.
    pub fn encoding(&self) -> &Encoding {
        &self.body.encoding
    }

    /// What it is, after a wait for edits.
    ///
    /// # Errors
    /// If the device does not tell.
    pub async fn info(&self, gpu: &Gpu) -> Result<VolumeInfo, GpuError> {
        let body = &self.body;
        let mut info = VolumeInfo::new(body.lattice, body.encoding, self.memory_bytes());
        info.levels = body.texture.mip_level_count();
        self.kind.info(info, gpu).await
    }

    /// Bytes on the device: textures and tables.
    pub fn memory_bytes(&self) -> u64 {
        self.kind.memory_bytes(&self.body)
    }

    /// Brings the volume back.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn read(&self, gpu: &Gpu) -> Result<Volume, GpuError> {
        self.kind.read(&self.body, gpu).await
    }

    /// What following edits takes, of one that is changed in place.
    pub fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        self.kind.edits()
    }

    /// Lies over the box that its edits have [grown to](PendingEdits::grow_to). Nothing is sampled.
    ///
    /// # Errors
    /// If the device has no room for the tables.
    pub fn grow(&mut self, gpu: &Gpu, edits: &dyn PendingEdits) -> Result<(), GpuError> {
        self.kind.grow(&mut self.body, gpu, edits)
    }

    /// Submits what its edits have left to be done, without waiting for it: all of it, or about as much as the device does in some
    /// time. `live` is what `field` [follows](GpuProgram::update).
    ///
    /// # Errors
    /// If it would take more than `budget` bytes; what was taken out of the work last is then not done.
    pub async fn edit(
        &mut self,
        field: &GpuProgram,
        live: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        budget: Option<u64>,
        within: Option<Duration>,
    ) -> Result<(), GpuError> {
        let editing = EditContext {
            field,
            live,
            edits,
            budget,
            within,
        };
        self.kind.edit(&mut self.body, editing).await
    }

    /// Waits for edits; what they did since the last time.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn settle(&mut self, gpu: &Gpu) -> Result<EditStats, GpuError> {
        self.kind.settle(gpu).await
    }

    /// Waits for edits, and gives back the room that they have left.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn trim(&mut self, field: &GpuProgram) -> Result<(), GpuError> {
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
            /// Brings a volume over. `field` is what it was made from: it gives the light.
            ///
            /// # Errors
            /// If the device has no room for it.
            pub async fn upload(field: &GpuProgram, volume: &Volume) -> Result<Self, GpuError> {
                match volume { $(Volume::$name(own) => Upload::upload(own, field).await,)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);

/// A representation that can be brought to a device.
pub(crate) trait Upload {
    /// Brings it over.
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume>;
}
