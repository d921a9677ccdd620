//! Renders images of worlds.

use crate::limits::{MAX_IMAGE_PIXELS, MAX_IMAGE_SIDE};
use crate::representation::{MeshStorage, Storage, StoredTriangles, triangles};
use crate::{RenderError, RenderReport, RenderedImage, Representation, World};
use argil_abi::{HIT_INSIDE, HIT_OUTSIDE, Hit};
use argil_gpu::{GpuProgram, GpuVolume, ImageOutput, ImageTextures};
use argil_math::Aabb;
use argil_render::{
    Camera, LitBricks, LiveImage, NormalSource, RenderMode, RenderOutput, RenderSettings,
    RenderSource, ViewLight, frame_uniforms,
};
use argil_scene::CameraPose;
use argil_volume::{Levels, Volume};
use std::sync::Arc;
use web_time::Instant;

/// Default maximum of steps per ray: through the field, and through a volume, whose steps are shorter.
const FIELD_STEPS: u32 = 256;
const VOLUME_STEPS: u32 = 4096;

impl World {
    /// Returns the scene's camera.
    pub fn camera(&self) -> Camera {
        self.camera_at(self.scene.view.camera)
    }

    /// Returns a camera in another pose, with the scene's field of view.
    pub fn camera_at(&self, pose: CameraPose) -> Camera {
        let field_of_view_degrees = self.scene.view.field_of_view_degrees;
        match pose {
            CameraPose::Orbit(orbit) => {
                Camera::orbit(self.view_bounds, orbit, field_of_view_degrees)
            }
            CameraPose::LookAt { eye, target } => Camera {
                eye: eye.into(),
                target: target.into(),
                field_of_view_degrees,
            },
        }
    }

    /// Returns settings that suit the scene, for a size in pixels and a mode. Shaded images get four samples per
    /// pixel.
    pub fn render_settings(&self, size: [u32; 2], mode: RenderMode) -> RenderSettings {
        RenderSettings {
            size,
            mode,
            samples: if mode == RenderMode::Shaded { 4 } else { 1 },
            ground: self.scene.view.ground && mode == RenderMode::Shaded,
            sun_degrees: ViewLight::sun_degrees(&self.scene.view),
            light: ViewLight::of_view(&self.scene.view),
            max_steps: match self.representation {
                Representation::Field => FIELD_STEPS,
                _ => VOLUME_STEPS,
            },
            ..RenderSettings::default()
        }
    }

    /// Renders an image, as a future: see [`World::render`].
    ///
    /// # Errors
    /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
    pub async fn render_async(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<RenderedImage, RenderError> {
        let (picture, duration_ms) = self.picture(camera, settings, ImageOutput::Cpu).await?;
        Ok(RenderedImage::new(picture, duration_ms))
    }

    /// Renders an image and also returns the lengths of its rays, as a future: see [`World::render`] and
    /// [`World::ray_distances`].
    ///
    /// # Errors
    /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
    pub async fn render_with_distances_async(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<(RenderedImage, Vec<f32>), RenderError> {
        let output = ImageOutput::CpuWithHits;
        let (picture, duration_ms) = self.picture(camera, settings, output).await?;
        let length = |hit: &Hit| match hit.kind {
            HIT_OUTSIDE | HIT_INSIDE => hit.normal_t[3],
            _ => f32::INFINITY,
        };
        let lengths = picture.hits.iter().map(length).collect();
        Ok((RenderedImage::new(picture, duration_ms), lengths))
    }

    /// Renders an image into textures of the world's GPU, as a future: see [`World::render_into`].
    ///
    /// # Errors
    /// If the world is on the CPU, the textures have another size than the image, a setting is out of range, the mode needs bricks
    /// that the world does not have, or the device fails.
    pub async fn render_into_async(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        textures: &ImageTextures,
    ) -> Result<RenderReport, RenderError> {
        let output = ImageOutput::Textures(textures);
        let (picture, duration_ms) = self.picture(camera, settings, output).await?;
        Ok(RenderReport {
            statistics: picture.statistics,
            duration_ms,
        })
    }

    /// Returns the levels from which light reads distances that sparse bricks do not store, if a mode shows light.
    fn light_for(&self, mode: RenderMode) -> Option<Arc<Levels>> {
        let layout = self.storage.brick_layout()?;
        let is_lit = mode == RenderMode::Shaded;
        is_lit.then(|| {
            self.light
                .levels(self.program(), self.live_program(), &layout)
        })?
    }

    /// Draws an image again after edits, as a future: see [`World::redraw`].
    ///
    /// # Errors
    /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
    pub async fn redraw_async(
        &self,
        image: &mut LiveImage,
        camera: &Camera,
        settings: &RenderSettings,
        dirty_box: Aabb,
    ) -> Result<usize, RenderError> {
        let is_local = matches!(&self.storage, Storage::Cpu(Volume::Bricks(_)));
        if self.gpu.is_some() || !is_local {
            let (picture, _) = self.picture(camera, settings, ImageOutput::Cpu).await?;
            return Ok(image.replace(picture));
        }
        check(camera, settings)?;
        if !self.representation.supports_mode(settings.mode) {
            return Err(RenderError::NoBricks);
        }
        let grid = self.storage.voxel_grid();
        let around = self.view_bounds;
        let frames = frame_uniforms(settings, camera, self.program(), grid.as_ref(), around);
        let light = self.light_for(settings.mode);
        // Blocks that edits have not rebuilt yet change the image later.
        let is_pending = self.edits.remaining_blocks() > 0;
        let is_same = image.follows(([light.is_some(), is_pending], grid));
        let knows_all = is_same && !is_pending;
        let dirty = if knows_all { dirty_box } else { Aabb::ALL };
        Ok(self.with_source(light.as_deref(), |through| {
            image.draw(self.program(), through, &frames, dirty)
        }))
    }

    /// Calls a function with what rays on the CPU march through.
    fn with_source<T>(
        &self,
        light: Option<&Levels>,
        then: impl FnOnce(&dyn RenderSource) -> T,
    ) -> T {
        match &self.storage {
            Storage::Cpu(volume) => match (volume, light) {
                (Volume::Bricks(bricks), Some(light)) => then(&LitBricks { bricks, light }),
                _ => then(volume),
            },
            Storage::Mesh(MeshStorage {
                mesh: StoredTriangles::Cpu(mesh),
                ..
            }) => then(&triangles(mesh)),
            _ => then(&argil_render::PrunedField),
        }
    }

    /// Gives a volume on the device the levels that light reads. What does not fit on the device is not read.
    pub(crate) fn set_light(
        &self,
        field: &GpuProgram,
        volume: &GpuVolume,
    ) -> Result<(), argil_gpu::GpuError> {
        let light = self.light_for(RenderMode::Shaded);
        if volume.set_light(field.gpu(), light.as_ref()).is_err() {
            volume.set_light(field.gpu(), None)?;
        }
        Ok(())
    }

    /// Uploads the instructions of the program, if a frame evaluates it: after edits, they are put together only then.
    pub(crate) fn upload_instructions(&self, field: &GpuProgram, settings: &RenderSettings) {
        let is_stored = matches!(self.storage, Storage::Gpu(_) | Storage::Mesh(_));
        let is_plain =
            settings.mode != RenderMode::Shaded && settings.normals != NormalSource::Field;
        if !(is_stored && is_plain) {
            field.upload_instructions(|| self.program());
        }
    }

    async fn picture(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        output: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), RenderError> {
        check(camera, settings)?;
        if !self.representation.supports_mode(settings.mode) {
            return Err(RenderError::NoBricks);
        }
        let voxel_grid = self.storage.voxel_grid();
        let frames = frame_uniforms(
            settings,
            camera,
            self.tables(),
            voxel_grid.as_ref(),
            self.view_bounds,
        );
        let start = Instant::now();
        if let Some(field) = &self.gpu {
            self.upload_instructions(field, settings);
            let (picture, duration_ms) = match &self.storage {
                Storage::Gpu(volume) if settings.mode != RenderMode::Shaded => {
                    volume.render(field, &frames, output).await?
                }
                Storage::Gpu(volume) => {
                    self.set_light(field, volume)?;
                    volume.render(field, &frames, output).await?
                }
                Storage::Mesh(MeshStorage {
                    mesh: StoredTriangles::Gpu(mesh),
                    ..
                }) => mesh.render(field, &frames, output).await?,
                _ => field.render(&frames, output).await?,
            };
            return Ok((picture, duration_ms));
        }
        let with_hits = match output {
            ImageOutput::Cpu => false,
            ImageOutput::CpuWithHits => true,
            ImageOutput::Textures(_) => return Err(RenderError::NotOnGpu),
        };
        let light = self.light_for(settings.mode);
        let control = &self.engine.control;
        let picture = self.with_source(light.as_deref(), |through| {
            argil_render::render_with_control(self.program(), through, &frames, with_hits, control)
        });
        let picture = picture.ok_or(RenderError::Cancelled)?;
        Ok((picture, start.elapsed().as_secs_f64() * 1e3))
    }
}

/// An orbit of cameras around a target.
///
/// ```
/// use argil::{Orbit, prelude::*};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(1.0))?;
/// let world = Engine::cpu().build(&scene)?.field();
/// let cameras: Vec<Camera> = Orbit::cameras(world.camera(), 4).collect();
/// assert_eq!(cameras[0], world.camera());
/// assert_eq!(cameras.len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Orbit;

impl Orbit {
    /// Returns `count` cameras: the given one, and others rotated about the vertical axis through its target by
    /// equal angles.
    pub fn cameras(camera: Camera, count: u32) -> impl Iterator<Item = Camera> {
        (0..count).map(move |i| camera.orbited(360.0 * i as f32 / count as f32))
    }
}

pub(crate) fn check(camera: &Camera, settings: &RenderSettings) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    if u64::from(width) * u64::from(height) > MAX_IMAGE_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    if !(1..=MAX_IMAGE_SIDE).contains(&width) || !(1..=MAX_IMAGE_SIDE).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    let fault = |name, value: f32, expected| {
        Err(RenderError::Setting {
            name,
            value: f64::from(value),
            expected,
        })
    };
    if !(1..=100_000).contains(&settings.max_steps) {
        return fault("max_steps", settings.max_steps as f32, "from 1 to 100000");
    }
    if !(1..=64).contains(&settings.samples) {
        return fault("samples", settings.samples as f32, "from 1 to 64");
    }
    for (name, value) in [
        ("epsilon", settings.epsilon),
        ("normal_bias", settings.normal_bias),
    ] {
        if let Some(v) = value
            && !(v.is_finite() && v > 0.0)
        {
            return fault(name, v, "a positive number");
        }
    }
    if !camera.eye.is_finite() || !camera.target.is_finite() {
        return fault("camera", f32::NAN, "at finite coordinates");
    }
    if !(1.0..=170.0).contains(&camera.field_of_view_degrees) {
        return fault(
            "field_of_view_degrees",
            camera.field_of_view_degrees,
            "from 1 to 170",
        );
    }
    Ok(())
}
