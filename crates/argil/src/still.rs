//! Path-traced stills of worlds.

use crate::probe::Probe;
use crate::query::Query;
use crate::{MeshFileError, RenderError, Representation, World};
use argil_render::{
    Camera, EnvironmentNotLoaded, PathHit, PathLens, PathLights, PathMaterial, PathScene, PathView,
    RenderSettings, Still, StillOptions, continue_paths, frame_uniforms,
};
use glam::Vec3;
use std::path::Path;

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
    /// A still that is to be refined has another size than the settings.
    #[error("the still has another size than the settings")]
    Size,
    /// The image of the environment is not loaded.
    #[error(transparent)]
    Environment(#[from] EnvironmentNotLoaded),
    /// The world is on a GPU.
    #[error("paths are followed on the CPU, and the world is on a GPU: build it with a CPU engine")]
    Gpu,
}

impl World {
    /// Makes a still by path tracing: the field's or the volume's surfaces, lit by the view's lights, its environment, and materials
    /// that emit light, directly and by way of each other, through its fog and its lens. Work that is canceled returns what is
    /// there.
    ///
    /// Of the settings, the size and the ground count, and the sun's direction, if the view has no lights.
    ///
    /// Textures are those of the field at each point, also where a volume stores coarser colors.
    ///
    /// # Errors
    /// If a setting is out of range, or paths cannot pass through the representation.
    ///
    /// ```
    /// use argil::prelude::*;
    /// use argil::render::{Development, StillOptions, developed};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(0.5))?;
    /// let world = Engine::cpu().build(&scene)?.bricks(64)?;
    /// let settings = world.render_settings([32, 18], RenderMode::Shaded);
    /// let options = StillOptions { samples: 4, ..StillOptions::default() };
    /// let still = world.still(&world.camera(), &settings, &options)?;
    /// assert_eq!(developed(&still.radiance(), &Development::default()).len(), 3 * 32 * 18);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn still(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        options: &StillOptions,
    ) -> Result<Still, StillError> {
        let mut still = Still::new(settings.size);
        self.refine_still(&mut still, camera, settings, options)?;
        Ok(still)
    }

    /// Adds paths to a still, with the same arguments as before: see [`World::still`]. Of the options, `samples` is how many are added.
    ///
    /// # Errors
    /// If a setting is out of range, the still has another size, or paths cannot pass through the representation.
    pub fn refine_still(
        &self,
        still: &mut Still,
        camera: &Camera,
        settings: &RenderSettings,
        options: &StillOptions,
    ) -> Result<(), StillError> {
        // A still has samples of its own.
        let settings = RenderSettings {
            samples: 1,
            ..*settings
        };
        crate::rendering::check(camera, &settings)?;
        if still.size() != settings.size {
            return Err(StillError::Size);
        }
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
        let view = &self.scene.view;
        let lens = view.lens.map(|lens| PathLens {
            radius: lens.aperture_radius,
            focus: lens
                .focus_distance
                .unwrap_or_else(|| camera.eye.distance(camera.target)),
        });
        let view = PathView {
            lights: PathLights::of_view(view, &frames[0])?,
            fog: view.fog,
            lens,
        };
        let control = &self.engine.control;
        continue_paths(&scene, &view, &frames[0], options, control, still);
        Ok(())
    }

    /// Loads the image of the view's environment, if that is not loaded: only stills need it. `folder` is the folder of the scene's
    /// file. If `allow_external` is false, its path may not leave it.
    ///
    /// # Errors
    /// If the file lies outside the folder, or cannot be read.
    pub fn load_environment(
        &mut self,
        folder: &Path,
        allow_external: bool,
    ) -> Result<(), MeshFileError> {
        crate::load_images(&mut self.scene, folder, allow_external)
    }

    /// Returns what paths pass through.
    fn paths(&self) -> Result<Query<'_>, StillError> {
        if self.representation == Representation::Field {
            return Ok(self.query());
        }
        let name = self.representation.name();
        if self.levels().is_some() {
            // Their pages are there only where rays of an image needed them.
            return Err(StillError::Representation(name));
        }
        self.query_volume().ok_or(StillError::Representation(name))
    }
}

impl PathScene for Query<'_> {
    fn nearest(&self, origin: Vec3, direction: Vec3, max_distance: f32) -> Option<PathHit> {
        let mut probe = Probe::new(self.world, self.epsilon);
        let ray = (origin, direction);
        let (t, by_field) = self.march(&mut probe, ray, 0.0, max_distance)?;
        let program = self.tables();
        let has_glass = program.has_glass();
        if has_glass && let Some(hit) = self.inside(&mut probe, ray, t) {
            return Some(hit);
        }
        let (point, normal) = self.surface(&mut probe, origin + t * direction, by_field);
        let is_plain = !has_glass && !program.has_textures();
        let stored = is_plain.then(|| self.stored_material(point, normal, by_field));
        if let Some(material) = stored.flatten() {
            return Some(PathHit {
                distance: t,
                point,
                normal,
                shading_normal: normal,
                material: material.into(),
            });
        }
        let (appearance, shading_normal) = match program.bump_step() {
            None => (probe.appearances([point])[0], normal),
            Some(step) => bumped(&mut probe, point, normal, step),
        };
        Some(PathHit {
            distance: t,
            point,
            normal,
            shading_normal,
            material: PathMaterial::from_properties(appearance),
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

/// Places inside of glass that are looked at, for something opaque.
const INNER_PLACES: usize = 16;
/// Times that the place of something opaque is halved.
const HALVINGS: usize = 16;

impl Query<'_> {
    /// Returns where a ray that begins inside of glass meets something opaque, before it leaves the solid. Both are one solid, so that
    /// there is no surface: they meet where the distances of both are equal, whose gradients differ there.
    fn inside(
        &self,
        probe: &mut Probe<'_>,
        (origin, direction): (Vec3, Vec3),
        end: f32,
    ) -> Option<PathHit> {
        let at = |t: f32| origin + t * direction;
        if self.sample(probe, at(0.0)).0 >= 0.0 {
            return None;
        }
        let is_opaque = |probe: &mut Probe<'_>, t: f32| {
            let [own] = probe.appearances([at(t)]);
            own[8] * (1.0 - own[7]) <= 0.0
        };
        if is_opaque(probe, 0.0) {
            return None;
        }
        let mut clear = 0.0;
        let mut opaque = None;
        for nth in 1..INNER_PLACES {
            let t = end * nth as f32 / INNER_PLACES as f32;
            if is_opaque(probe, t) {
                opaque = Some(t);
                break;
            }
            clear = t;
        }
        let mut opaque = opaque?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (clear + opaque);
            if is_opaque(probe, middle) {
                opaque = middle;
            } else {
                clear = middle;
            }
        }
        let apart = 4.0 * self.epsilon;
        let before = probe.gradient(at((clear - apart).max(0.0))).1;
        let after = probe.gradient(at(opaque + apart)).1;
        let normal = (after - before).try_normalize().unwrap_or(-direction);
        let normal = if normal.dot(direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let [appearance] = probe.appearances([at(opaque)]);
        Some(PathHit {
            distance: clear,
            point: at(clear),
            normal,
            shading_normal: normal,
            material: PathMaterial::from_properties(appearance),
        })
    }
}

/// Returns the properties of a surface's material, and the normal that its heights turn (Blinn, "Simulation of wrinkled surfaces",
/// 1978).
fn bumped(probe: &mut Probe<'_>, point: Vec3, normal: Vec3, step: f32) -> ([f32; 12], Vec3) {
    let Some((x, y)) = normal
        .try_normalize()
        .map(|normal| normal.any_orthonormal_pair())
    else {
        return (probe.appearances([point])[0], normal);
    };
    let [own, right, up] = probe.appearances([point, point + step * x, point + step * y]);
    let slope = ((right[11] - own[11]) * x + (up[11] - own[11]) * y) / step;
    (own, (normal - slope).try_normalize().unwrap_or(normal))
}
