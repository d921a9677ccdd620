//! Path-traced stills of worlds.

use crate::cast::RayHit;
use crate::probe::Probe;
use crate::query::Query;
use crate::{RenderError, Representation, World};
use argil_abi::GpuMaterial;
use argil_render::{
    Camera, PathHit, PathLights, PathScene, RenderSettings, Still, StillOptions, frame_uniforms,
    trace_paths,
};
use glam::Vec3;

/// The most paths of a pixel, and surfaces of a path.
const MOST_SAMPLES: u32 = 1 << 20;
const MOST_BOUNCES: u32 = 1024;

/// The reason why a still cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum StillError {
    /// A setting is out of range.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The representation has nothing that paths pass through.
    #[error("paths pass through the field, bricks and dense volumes, and not through {0}")]
    Representation(&'static str),
    /// The world is on a GPU.
    #[error("paths are followed on the CPU, and the world is on a GPU: build it with a CPU engine")]
    Gpu,
}

impl World {
    /// Makes a still by path tracing: the field's or the volume's surfaces, lit by the sky, the sun, and materials that emit light,
    /// directly and by way of each other. Work that is canceled returns what is there.
    ///
    /// Of the settings, the size and the ground count, and the sun's direction.
    ///
    /// # Errors
    /// If a setting is out of range, or paths cannot pass through the representation.
    ///
    /// ```
    /// use argil::prelude::*;
    /// use argil::render::{StillOptions, developed};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let world = Engine::cpu().build(&scene)?.bricks(64)?;
    /// let settings = world.render_settings([32, 18], RenderMode::Shaded);
    /// let options = StillOptions { samples: 4, ..StillOptions::default() };
    /// let still = world.still(&world.camera(), &settings, &options)?;
    /// assert_eq!(developed(&still.radiance()).len(), 3 * 32 * 18);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn still(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        options: &StillOptions,
    ) -> Result<Still, StillError> {
        // A still has samples of its own.
        let settings = RenderSettings {
            samples: 1,
            ..*settings
        };
        crate::rendering::check(camera, &settings)?;
        let fault = |name, value: u32, expected| {
            let value = f64::from(value);
            RenderError::Setting {
                name,
                value,
                expected,
            }
        };
        if !(1..=MOST_SAMPLES).contains(&options.samples) {
            return Err(fault("samples", options.samples, "from 1 to 1048576").into());
        }
        if !(1..=MOST_BOUNCES).contains(&options.max_bounces) {
            return Err(fault("max_bounces", options.max_bounces, "from 1 to 1024").into());
        }
        if self.engine.gpu_kind().is_some() {
            return Err(StillError::Gpu);
        }
        let scene = self.paths()?;
        let grid = self.storage.voxel_grid();
        let frames = frame_uniforms(
            &settings,
            camera,
            self.program(),
            grid.as_ref(),
            self.view_bounds,
        );
        let lights = PathLights::of_frame(&frames[0]);
        let control = &self.engine.control;
        Ok(trace_paths(&scene, &lights, &frames[0], options, control))
    }

    /// Returns what paths pass through.
    fn paths(&self) -> Result<Query<'_>, StillError> {
        if self.representation == Representation::Field {
            return Ok(self.query());
        }
        let name = self.representation.name();
        self.query_volume().ok_or(StillError::Representation(name))
    }
}

impl PathScene for Query<'_> {
    fn nearest(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<PathHit> {
        let mut probe = Probe::new(self.world, self.epsilon);
        let ray = (origin, direction);
        let (t, by_field) = self.march(&mut probe, ray, 0.0, max_distance)?;
        let at = (origin + t * direction, t);
        let RayHit {
            distance,
            point,
            normal,
            material,
        } = self.hit(&mut probe, at, by_field);
        let [r, g, b] = material.base_color;
        let [er, eg, eb] = material.emission;
        Some(PathHit {
            distance,
            point: point.into(),
            normal: normal.into(),
            material: GpuMaterial {
                base_roughness: [r, g, b, material.roughness],
                emission_metallic: [er, eg, eb, material.metallic],
            },
        })
    }

    fn is_blocked(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> bool {
        let mut probe = Probe::new(self.world, self.epsilon);
        let ray = (origin, direction);
        self.march(&mut probe, ray, 0.0, max_distance).is_some()
    }

    fn lift(&self) -> f32 {
        4.0 * self.epsilon
    }
}
