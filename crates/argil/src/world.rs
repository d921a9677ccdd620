use crate::{BuildError, Drawn, Engine, Placement, RenderError, Scene};
use argil_field::Program;
use argil_gpu::GpuField;
use argil_march::{Camera, Settings, Show, frames};
use argil_math::{Aabb, Interval};
use glam::Vec3;
use std::time::Instant;

/// Longest side of a picture in pixels.
pub const MAX_SIDE: u32 = 16_384;

/// Most pixels of a picture: it takes 60 bytes a pixel while it is drawn.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A scene that an engine has built: its exact field, on the engine's device.
pub struct World {
    engine: Engine,
    program: Program,
    gpu: Option<GpuField>,
    specialized: bool,
    focus: Aabb,
    view: crate::View,
}

impl World {
    pub(crate) fn new(engine: Engine, scene: &Scene) -> Result<Self, BuildError> {
        let program = Program::lower(scene)?;
        let gpu = match &engine.gpu {
            Some(gpu) => Some(GpuField::new(gpu.clone(), &program, false)?),
            None => None,
        };
        let focus = focus(scene, &program);
        Ok(Self {
            engine,
            program,
            gpu,
            specialized: false,
            focus,
            view: scene.view.clone(),
        })
    }

    /// Take over a scene that was edited. On a GPU nothing is compiled for it, unless the world is specialised.
    pub fn apply(&mut self, scene: &Scene) -> Result<(), BuildError> {
        let program = Program::lower(scene)?;
        match &mut self.gpu {
            Some(gpu) if !self.specialized => gpu.update(&program)?,
            Some(gpu) => *gpu = GpuField::new(gpu.gpu().clone(), &program, true)?,
            None => {}
        }
        self.focus = focus(scene, &program);
        self.view = scene.view.clone();
        self.program = program;
        Ok(())
    }

    /// Compile shaders for this very scene, in place of the interpreter. The CPU always interprets.
    pub fn specialize(&mut self) -> Result<(), BuildError> {
        if let Some(gpu) = &mut self.gpu {
            *gpu = GpuField::new(gpu.gpu().clone(), &self.program, true)?;
            self.specialized = true;
        }
        Ok(())
    }

    /// The program that the scene was lowered to.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Bytes that the world holds: the program's tables, on the GPU too where there is one.
    pub fn memory_bytes(&self) -> u64 {
        self.program.memory_bytes() as u64 + self.gpu.as_ref().map_or(0, GpuField::memory_bytes)
    }

    /// The engine that built the world.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The box that the scene is looked at in.
    pub fn focus(&self) -> Aabb {
        self.focus
    }

    /// The signed distance at a point, negative inside.
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        self.program.distance(point.into())
    }

    /// The distance and its gradient at a point.
    pub fn gradient(&self, point: [f32; 3]) -> (f32, [f32; 3]) {
        let (d, g) = self.program.gradient(point.into());
        (d, g.to_array())
    }

    /// An interval that holds the distances of all points of a box.
    pub fn bounds(&self, min: [f32; 3], max: [f32; 3]) -> Interval {
        self.program.bounds(Aabb::new(min.into(), max.into()))
    }

    /// The scene's own camera.
    pub fn camera(&self) -> Camera {
        self.camera_at(self.view.camera)
    }

    /// A camera with the scene's field of view.
    pub fn camera_at(&self, placement: Placement) -> Camera {
        let field_of_view_degrees = self.view.field_of_view_degrees;
        match placement {
            Placement::Orbit(orbit) => Camera::orbit(self.focus, orbit, field_of_view_degrees),
            Placement::Look { eye, target } => Camera {
                eye: eye.into(),
                target: target.into(),
                field_of_view_degrees,
            },
        }
    }

    /// How the scene wants to be drawn, for a size; four samples a pixel when shaded.
    pub fn settings(&self, size: [u32; 2], show: Show) -> Settings {
        Settings {
            size,
            show,
            samples: if show == Show::Shaded { 4 } else { 1 },
            ground: self.view.ground && show == Show::Shaded,
            sun_degrees: self.view.sun_degrees,
            ..Settings::default()
        }
    }

    /// A shaded picture.
    pub fn render(&self, camera: &Camera, size: [u32; 2]) -> Result<Drawn, RenderError> {
        self.draw(camera, &self.settings(size, Show::Shaded))
    }

    /// A picture by settings.
    pub fn draw(&self, camera: &Camera, settings: &Settings) -> Result<Drawn, RenderError> {
        check(camera, settings)?;
        let frames = frames(settings, camera, &self.program, self.focus);
        if let Some(gpu) = &self.gpu {
            let (picture, duration_ms) = gpu.render(&frames)?;
            return Ok(Drawn::new(picture, duration_ms));
        }
        let start = Instant::now();
        let picture = argil_march::render(&self.program, &frames);
        Ok(Drawn::new(picture, start.elapsed().as_secs_f64() * 1e3))
    }
}

/// The cameras of an orbit: the first as given, the others turned about the vertical by equal angles.
pub struct Orbit;

impl Orbit {
    /// `count` cameras around `camera`'s target.
    pub fn around(camera: Camera, count: u32) -> impl Iterator<Item = Camera> {
        (0..count).map(move |i| camera.turned(360.0 * i as f32 / count as f32))
    }
}

/// The view's frame, else the solid's box where it is finite, else what is finite of it.
fn focus(scene: &Scene, program: &Program) -> Aabb {
    match scene.view.frame {
        Some([min, max]) => Aabb::new(min.into(), max.into()),
        None if program.aabb().is_finite() => program.aabb(),
        None => Aabb::centered(Vec3::ONE),
    }
}

fn check(camera: &Camera, settings: &Settings) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
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
