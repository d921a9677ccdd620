//! Renders images of worlds.

use crate::device::{Device, LazyProgram, RenderRequest};
use crate::limits::{MAX_IMAGE_PIXELS, MAX_IMAGE_SIDE};
use crate::{RenderError, RenderedImage, Representation, World};
use argil_abi::{FrameUniform, HIT_INSIDE, HIT_OUTSIDE, Hit};
use argil_math::Aabb;
use argil_render::{
    Camera, LiveImage, RenderMode, RenderOutput, RenderSettings, ViewLight, frame_uniforms,
};
use argil_scene::CameraPose;
use argil_volume::Levels;
use std::sync::Arc;
use web_time::Instant;

/// Default maximum of steps per ray: through the field, and through a volume, whose steps are shorter.
const FIELD_STEPS: u32 = 256;
const VOLUME_STEPS: u32 = 4096;
/// Fewest steps that are red.
const LEAST_HEAT: u32 = 8;

impl World {
    /// Returns the scene's camera. A view that says neither where its camera is nor what it shows gets one that shows the whole
    /// surface.
    pub fn camera(&self) -> Camera {
        self.framing().camera(&self.scene.view)
    }

    /// Returns a camera in another pose, with the scene's field of view.
    pub fn camera_at(&self, pose: CameraPose) -> Camera {
        self.framing()
            .camera_at(pose, self.scene.view.field_of_view_degrees)
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
        let settings = self.with_heat(camera, settings).await?;
        let (picture, duration_ms) = self.picture(camera, &settings, false).await?;
        Ok(RenderedImage::new(picture, &settings, duration_ms))
    }

    /// Returns settings whose heat suits the image, by the steps of a smaller one.
    async fn with_heat(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<RenderSettings, RenderError> {
        let mut settings = *settings;
        if settings.mode != RenderMode::Heat || settings.heat_steps.is_some() {
            return Ok(settings);
        }
        let small = RenderSettings {
            size: settings.size.map(|side| side.div_ceil(4)),
            samples: 1,
            statistics: true,
            ..settings
        };
        let (picture, _) = self.picture(camera, &small, false).await?;
        settings.heat_steps = picture
            .statistics
            .map(|counted| (1.25 * counted.steps.p95) as u32)
            .map(|steps| steps.max(LEAST_HEAT));
        Ok(settings)
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
        let settings = self.with_heat(camera, settings).await?;
        let (picture, duration_ms) = self.picture(camera, &settings, true).await?;
        let length = |hit: &Hit| match hit.kind {
            HIT_OUTSIDE | HIT_INSIDE => hit.normal_t[3],
            _ => f32::INFINITY,
        };
        let lengths = picture.hits.iter().map(length).collect();
        Ok((RenderedImage::new(picture, &settings, duration_ms), lengths))
    }

    /// Renders an image into textures of the world's GPU, as a future: see [`World::render_into`].
    ///
    /// # Errors
    /// If the world is on the CPU, the textures have another size than the image, a setting is out of range, the mode needs bricks
    /// that the world does not have, or the device fails.
    #[cfg(feature = "gpu")]
    pub async fn render_into_async(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        textures: &argil_gpu::ImageTextures,
    ) -> Result<crate::RenderReport, RenderError> {
        let settings = &self.with_heat(camera, settings).await?;
        let frames = self.frames(camera, settings)?;
        let device = self.device.on_gpu().ok_or(RenderError::NotOnGpu)?;
        let program = || self.program();
        let request = self.render_request(settings, &frames, &program);
        let output = argil_gpu::ImageOutput::Textures(textures);
        let (picture, duration_ms) = device.render_to(&request, output).await?;
        Ok(crate::RenderReport {
            statistics: picture.statistics,
            duration_ms,
        })
    }

    /// Returns the levels from which light reads distances that sparse bricks do not store, if a mode shows light.
    pub(crate) fn light_for(&self, mode: RenderMode) -> Option<Arc<Levels>> {
        let layout = self.device.brick_layout()?;
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
        let device = self.device.on_cpu();
        let Some(device) = device.filter(|device| device.brick_layout().is_some()) else {
            let (picture, _) = self.picture(camera, settings, false).await?;
            return Ok(image.replace(picture));
        };
        let frames = self.frames(camera, settings)?;
        let light = self.light_for(settings.mode);
        // Blocks that edits have not rebuilt yet change the image later.
        let is_pending = self.edits.remaining_blocks() > 0;
        let grid = device.voxel_grid();
        let is_same = image.follows(([light.is_some(), is_pending], grid));
        let knows_all = is_same && !is_pending;
        let dirty = if knows_all { dirty_box } else { Aabb::ALL };
        Ok(device.with_source(light.as_deref(), |source| {
            image.draw(self.program(), source, &frames, dirty)
        }))
    }

    /// Checks a camera and settings, and returns what shaders know of each sample's frame.
    pub(crate) fn frames(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Vec<FrameUniform>, RenderError> {
        check(camera, settings)?;
        if !self.representation.supports_mode(settings.mode) {
            return Err(RenderError::NoBricks);
        }
        let grid = self.device.voxel_grid();
        Ok(frame_uniforms(
            &self.grounded(settings),
            camera,
            self.tables(),
            grid.as_ref(),
            self.view_bounds(),
        ))
    }

    /// Returns settings whose ground touches the scene, unless they say where it is.
    pub(crate) fn grounded(&self, settings: &RenderSettings) -> RenderSettings {
        let mut grounded = *settings;
        if grounded.ground && grounded.ground_height.is_none() {
            grounded.ground_height = Some(self.ground_height());
        }
        grounded
    }

    /// Returns what a device renders.
    fn render_request<'a>(
        &'a self,
        settings: &'a RenderSettings,
        frames: &'a [FrameUniform],
        program: LazyProgram<'a>,
    ) -> RenderRequest<'a> {
        let start = Instant::now();
        RenderRequest {
            program,
            #[cfg(feature = "gpu")]
            settings,
            frames,
            light: self.light_for(settings.mode),
            with_hits: false,
            control: &self.engine.control,
            start,
        }
    }

    async fn picture(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        with_hits: bool,
    ) -> Result<(RenderOutput, f64), RenderError> {
        let frames = self.frames(camera, settings)?;
        let program = || self.program();
        let request = RenderRequest {
            with_hits,
            ..self.render_request(settings, &frames, &program)
        };
        self.device.render(request).await
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
    if let Some(height) = settings.ground_height
        && !height.is_finite()
    {
        return fault("ground_height", height, "a finite number");
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
