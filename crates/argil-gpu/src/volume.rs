//! A volume on the device: what all representations have there, and the trait that each implements in its own file.

use crate::resources::uniform_for;
use crate::table::Table;
use crate::texels::TexelFormat;
use crate::way::{Bound, Way};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuField};
use argil_abi::{BrickVolume, DenseVolume, Frame};
use argil_field::LiveProgram;
use argil_march::Picture;
use argil_volume::{BrickEdit, Edits, Encoding, Lattice, Volume, VolumeInfo};
use std::any::Any;
use web_time::Duration;

/// What a representation is on the device, besides its texture.
pub(crate) trait Kind: Any + Send + Sync {
    /// How its pictures are marched.
    fn way(&self) -> &'static Way;

    /// What that reads besides the texture and the words.
    fn bind(&self, _bound: &mut Vec<Bound>) {}

    /// Bytes of textures and tables.
    fn memory_bytes(&self, body: &Body) -> u64;

    /// What it is: more than its lattice, encoding and bytes, after a wait for edits.
    fn info<'a>(&'a self, info: VolumeInfo, _gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move { Ok(info) })
    }

    /// Brings it back.
    fn read<'a>(&'a self, body: &'a Body, gpu: &'a Gpu) -> Work<'a, Volume>;

    /// What following edits takes, of one that is changed in place.
    fn edits(&self) -> Option<Box<dyn Edits>> {
        None
    }

    /// Lies over the box that its edits have grown to. Nothing is sampled.
    fn grow(&mut self, _body: &mut Body, _gpu: &Gpu, _edits: &dyn Edits) -> Result<(), GpuError> {
        Ok(())
    }

    /// Submits what its edits have left to be done.
    fn edit<'a>(&'a mut self, _body: &'a mut Body, _edit: Editing<'a>) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// Waits for edits; what they did since the last time.
    fn settle<'a>(&'a mut self, _gpu: &'a Gpu) -> Work<'a, BrickEdit> {
        Box::pin(async { Ok(BrickEdit::default()) })
    }

    /// Waits for edits, and gives back the room that they have left.
    fn trim<'a>(&'a mut self, _body: &'a mut Body, _field: &'a GpuField) -> Work<'a, ()> {
        Box::pin(async { Ok(()) })
    }

    /// The uniform that its shaders read, as bytes.
    fn uniform(&self) -> &[u8];

    /// How its surface is cut into triangles, if it is.
    fn cut(&self) -> Option<Cut<'_>> {
        None
    }
}

/// What edits have left to be done, and how much of it now.
pub(crate) struct Editing<'a> {
    pub field: &'a GpuField,
    /// What the field [follows](GpuField::follow).
    pub live: &'a LiveProgram,
    pub edits: &'a mut dyn Edits,
    /// Bytes that there may be.
    pub budget: Option<u64>,
    /// About as much as the device does in that time.
    pub within: Option<Duration>,
}

/// How triangles are found.
pub(crate) enum Cut<'a> {
    /// Texel by texel of the lattice.
    Dense(&'a DenseVolume),
    /// Brick by brick, by a table of cells.
    Bricks(&'a Table, &'a BrickVolume),
}

/// What every volume has on the device.
pub(crate) struct Body {
    pub lattice: Lattice,
    pub encoding: Encoding,
    pub texture: wgpu::Texture,
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    uniform: wgpu::Buffer,
}

impl Body {
    /// Another texture in place of the old.
    pub fn set_texture(&mut self, texture: wgpu::Texture) {
        self.view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.texture = texture;
    }

    /// Bytes of a texel.
    pub fn texel_bytes(&self) -> u64 {
        TexelFormat::of(self.texture.format()).bytes() as u64
    }

    /// Bytes of a texture as large as the lattice, with its levels.
    pub fn texture_bytes(&self) -> u64 {
        (0..self.texture.mip_level_count())
            .map(|level| self.lattice.texel_count(level) * self.texel_bytes())
            .sum()
    }
}

/// A volume on a device.
pub struct GpuVolume {
    body: Body,
    kind: Box<dyn Kind>,
}

impl GpuVolume {
    pub(crate) fn new(
        field: &GpuField,
        (lattice, encoding): (Lattice, Encoding),
        texture: wgpu::Texture,
        kind: impl Kind,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        // Compiled now, if it was not yet, and not when the first picture is wanted.
        field.picture(kind.way())?;
        let (view, sampler, uniform) = gpu.checked(|| {
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
            body: Body {
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

    /// Draws as [`GpuField::render`] does, primary rays and normals through the volume.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn render(
        &self,
        field: &GpuField,
        frames: &[Frame],
        with_hits: bool,
    ) -> Result<(Picture, f64), GpuError> {
        let uniform = &self.body.uniform;
        let gpu = field.gpu();
        gpu.queue.write_buffer(uniform, 0, self.kind.uniform());
        let mut bound = vec![
            Bound::buffer(argil_abi::BIND_VOLUME, uniform),
            Bound::View(argil_abi::BIND_STORED, self.body.view.clone()),
            Bound::Sampler(argil_abi::BIND_LINEAR, self.body.sampler.clone()),
        ];
        self.kind.bind(&mut bound);
        let passes = field.picture(self.kind.way())?;
        passes.draw(field, bound, None, frames, with_hits).await
    }

    /// Where the voxels lie.
    pub fn lattice(&self) -> &Lattice {
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
    pub fn edits(&self) -> Option<Box<dyn Edits>> {
        self.kind.edits()
    }

    /// Lies over the box that its edits have [grown to](Edits::grow_to). Nothing is sampled.
    ///
    /// # Errors
    /// If the device has no room for the tables.
    pub fn grow(&mut self, gpu: &Gpu, edits: &dyn Edits) -> Result<(), GpuError> {
        self.kind.grow(&mut self.body, gpu, edits)
    }

    /// Submits what its edits have left to be done, without waiting for it: all of it, or about as much as the device does in some
    /// time. `live` is what `field` [follows](GpuField::follow).
    ///
    /// # Errors
    /// If it would take more than `budget` bytes; what was taken out of the work last is then not done.
    pub async fn edit(
        &mut self,
        field: &GpuField,
        live: &LiveProgram,
        edits: &mut dyn Edits,
        budget: Option<u64>,
        within: Option<Duration>,
    ) -> Result<(), GpuError> {
        let editing = Editing {
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
    pub async fn settle(&mut self, gpu: &Gpu) -> Result<BrickEdit, GpuError> {
        self.kind.settle(gpu).await
    }

    /// Waits for edits, and gives back the room that they have left.
    ///
    /// # Errors
    /// If the device does not do it.
    pub async fn trim(&mut self, field: &GpuField) -> Result<(), GpuError> {
        self.kind.trim(&mut self.body, field).await
    }

    pub(crate) fn body(&self) -> &Body {
        &self.body
    }

    pub(crate) fn cut(&self) -> Option<Cut<'_>> {
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
            pub async fn upload(field: &GpuField, volume: &Volume) -> Result<Self, GpuError> {
                match volume { $(Volume::$name(own) => Upload::upload(own, field).await,)* }
            }
        }
    };
}

argil_volume::all_volumes!(volumes);

/// A representation that can be brought to a device.
pub(crate) trait Upload {
    /// Brings it over.
    fn upload<'a>(&'a self, field: &'a GpuField) -> Work<'a, GpuVolume>;
}
