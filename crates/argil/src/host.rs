//! Worlds in the frames of programs that have their own renderer.

use crate::device::{Device, GpuStorage};
use crate::edit_session::EditPace;
use crate::{BuildError, EditReport, RenderError, World};
use argil_abi::FrameUniform;
use argil_gpu::{GpuError, GpuProgram, GpuVolume, ShaderVolume, wgpu};
use argil_gpu::{HostFrame, HostSight, HostTargets};
use argil_render::{Camera, Projection, RenderSettings, frame_uniforms};
use argil_scene::Scene;

impl World {
    /// Prepares to draw frames into the targets of a host. Each view needs its own, and keeps its buffers from frame to frame.
    ///
    /// ```no_run
    /// use argil::gpu::{HostTargets, wgpu};
    /// use argil::prelude::*;
    /// # fn draw(world: &World, device: &wgpu::Device, queue: &wgpu::Queue,
    /// #         clip_from_world: [[f32; 4]; 4], mut begin: impl FnMut(&mut wgpu::CommandEncoder) -> wgpu::RenderPass<'static>)
    /// # -> Result<(), Box<dyn std::error::Error>> {
    /// let targets = HostTargets::new(wgpu::TextureFormat::Rgba8UnormSrgb);
    /// let mut frame = world.host_frame(&targets)?;
    /// let settings = RenderSettings { size: [1280, 720], ..RenderSettings::default() };
    /// // In each frame:
    /// let mut encoder = device.create_command_encoder(&Default::default());
    /// world.encode_frame(&mut frame, clip_from_world, &settings, &mut encoder)?;
    /// let mut pass = begin(&mut encoder);
    /// frame.composite(&mut pass);
    /// drop(pass);
    /// queue.submit([encoder.finish()]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the world is on the CPU, or the device refuses a target.
    pub fn host_frame(&self, targets: &HostTargets) -> Result<HostFrame, RenderError> {
        let device = self.device.on_gpu().ok_or(RenderError::NotOnGpu)?;
        Ok(HostFrame::new(device.program.gpu(), targets)?)
    }

    /// Encodes edits, as a future: see [`World::encode_edits`].
    ///
    /// # Errors
    /// If the world is on the CPU, the scene cannot be compiled, the result exceeds the memory budget, or the device fails.
    pub async fn encode_edits_async(
        &mut self,
        scene: &Scene,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<EditReport, BuildError> {
        if !self.engine.is_gpu() {
            return Err(BuildError::NotOnGpu);
        }
        let pace = EditPace {
            encoder: Some(encoder),
            ..EditPace::default()
        };
        self.follow(scene, pace).await
    }

    /// Encodes a frame of the world, which [`HostFrame::composite`] draws later in the same submission. `clip_from_world` is
    /// the host's projection times its view, by columns: any perspective or parallel rays, with reversed or infinite depth too.
    ///
    /// Nothing is submitted, waited for or read back. Once a frame of that size and mode was encoded, nothing is created, either,
    /// unless an edit needs memory, or is the first that moves a brush where there is a target for motion.
    /// Submit a [`HostFrame`] before it is encoded again.
    /// Where rays hit nothing, the host's picture stays. The settings' ground hides what is below. What is nearer than the near
    /// plane is cut away: a ray that begins in a solid shows where it leaves it.
    /// Levels show the pages that they have, and ask for no others.
    ///
    /// # Errors
    /// If the world is on the CPU or of triangles, a setting is out of range, the matrix is no projection, or the device fails.
    pub fn encode_frame(
        &self,
        frame: &mut HostFrame,
        clip_from_world: [[f32; 4]; 4],
        settings: &RenderSettings,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), RenderError> {
        let device = self.device.on_gpu().ok_or(RenderError::NotOnGpu)?;
        let view = Projection::from_matrix(clip_from_world, frame.is_reversed());
        let view = view.ok_or(RenderError::NoProjection)?;
        let camera = view.camera();
        let mut frames = self.frames(&camera, settings)?;
        for frame in &mut frames {
            view.write(frame);
        }
        let state = self.edits.state();
        let before = frame.shown().filter(|&before| before != state);
        let motion = before.and_then(|before| self.edits.motion_since(before));
        let sight = HostSight {
            frames: &frames,
            clip_from_world: view.clip_from_world(),
            motion: motion.as_ref(),
            state,
        };
        if device.has_lost_edits() {
            return Err(GpuError::NotSubmitted.into());
        }
        if matches!(device.storage, GpuStorage::Mesh { .. }) {
            return Err(RenderError::Triangles);
        }
        let light = self.light_for(settings.mode);
        device.prepare(settings, || self.program(), light.as_ref())?;
        let program = &device.program;
        match &device.storage {
            GpuStorage::Volume(volume) => frame.encode_volume(program, volume, sight, encoder)?,
            _ => frame.encode_field(program, sight, encoder)?,
        }
        Ok(())
    }

    /// Binds a world of bricks or of levels for a host's shaders: they ask for distances, gradients, materials and rays. Edits
    /// change what they read once [`World::update_shader_volume`] has followed them.
    ///
    /// In levels, the finest page that is there answers. Shaders of a host ask for no pages. Where no image asked for a fine page,
    /// a coarser one answers. [`World::refine`] bakes what a view needs, and [`World::render`] with [`World::fill_pages`] does, too.
    /// Positions are computed relative to the center of [`World::view_bounds`], in single precision.
    ///
    /// ```no_run
    /// use argil::gpu::wgpu;
    /// use argil::prelude::*;
    /// # fn pipeline(world: &World, device: &wgpu::Device) -> Result<(), Box<dyn std::error::Error>> {
    /// let volume = world.shader_volume()?;
    /// let source = volume.wgsl(1) + "
    /// @fragment
    /// fn glow(@location(0) place: vec3<f32>) -> @location(0) vec4<f32> {
    ///     return vec4(exp(-8.0 * max(argil_distance(place), 0.0)));
    /// }";
    /// let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
    ///     label: None,
    ///     source: wgpu::ShaderSource::Wgsl(source.into()),
    /// });
    /// // A pipeline whose layout has `volume.layout()` as group 1, and in a pass:
    /// // pass.set_bind_group(1, volume.bind_group(), &[]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// If the world is on the CPU, or neither of bricks nor of levels, or the device fails.
    pub fn shader_volume(&self) -> Result<ShaderVolume, RenderError> {
        let (field, volume, frame) = self.volume_of_shaders()?;
        Ok(ShaderVolume::new(field, volume, &frame)?)
    }

    /// Follows edits of the world, and the pages of levels that came or went. Returns whether there is another bind group, because
    /// memory grew. Call it before each submission whose shaders read the volume, if the world has changed since.
    ///
    /// # Errors
    /// As for [`World::shader_volume`], and if the world has another representation than the one that was bound.
    pub fn update_shader_volume(
        &self,
        volume_of_shaders: &mut ShaderVolume,
    ) -> Result<bool, RenderError> {
        let (field, volume, frame) = self.volume_of_shaders()?;
        Ok(volume_of_shaders.follow(field, volume, &frame)?)
    }

    /// Returns what shaders read, with the accuracy of a frame.
    fn volume_of_shaders(&self) -> Result<(&GpuProgram, &GpuVolume, FrameUniform), RenderError> {
        let device = self.device.on_gpu().ok_or(RenderError::NotOnGpu)?;
        let GpuStorage::Volume(volume) = &device.storage else {
            let name = self.representation.name();
            return Err(GpuError::NoShaderVolume { name }.into());
        };
        let grid = self.device.voxel_grid();
        let around = self.view_bounds();
        let camera = Camera::orbit(around, [30.0, 20.0, 2.5], 45.0);
        let settings = RenderSettings {
            size: [1, 1],
            ..RenderSettings::default()
        };
        let frames = frame_uniforms(&settings, &camera, self.tables(), grid.as_ref(), around);
        let frame = FrameUniform {
            // Rays come from anywhere.
            eye: camera.target.to_array(),
            ..frames.into_iter().next().unwrap_or_default()
        };
        Ok((&device.program, volume, frame))
    }
}
