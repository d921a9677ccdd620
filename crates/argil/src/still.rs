//! Path-traced stills of worlds.

use crate::device::{Device, PathRequest};
use crate::probe::Probe;
use crate::query::Query;
use crate::still_error::StillError;
use crate::{MeshFileError, RenderError, World};
use argil_render::{
    Camera, PathHit, PathLens, PathLights, PathMaterial, PathScene, PathView, RenderSettings,
    Still, StillOptions, ViewLight, frame_uniforms,
};
use glam::Vec3;
use std::path::Path;

/// The most paths of a pixel, and surfaces of a path.
const MOST_SAMPLES: u32 = 1 << 20;
const MOST_BOUNCES: u32 = 1024;

impl World {
    /// Makes a still, as a future: see [`World::still`].
    ///
    /// # Errors
    /// If a setting is out of range, paths cannot pass through the representation, or the device fails.
    pub async fn still_async(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        options: &StillOptions,
    ) -> Result<Still, StillError> {
        let mut still = Still::new(settings.size);
        self.refine_still_async(&mut still, camera, settings, options)
            .await?;
        Ok(still)
    }

    /// Adds paths to a still, as a future: see [`World::refine_still`].
    ///
    /// # Errors
    /// If a setting is out of range, the still has another size, paths cannot pass through the representation, or the device
    /// fails.
    pub async fn refine_still_async(
        &self,
        still: &mut Still,
        camera: &Camera,
        settings: &RenderSettings,
        options: &StillOptions,
    ) -> Result<(), StillError> {
        // A still has samples of its own.
        let settings = RenderSettings {
            samples: 1,
            light: ViewLight::of_view(&self.scene.view),
            ..*settings
        };
        crate::rendering::check(camera, &settings)?;
        if still.size() != settings.size {
            return Err(StillError::Size);
        }
        check(options)?;
        if !self.device.has_paths() {
            return Err(StillError::Representation(self.representation.name()));
        }
        let grid = self.device.voxel_grid();
        let frames = frame_uniforms(
            &self.grounded(&settings),
            camera,
            self.program(),
            grid.as_ref(),
            self.view_bounds(),
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
            fog: view.fog.filter(|fog| fog.density > 0.0),
            lens,
        };
        let query = self.query_volume().unwrap_or_else(|| self.query());
        let epsilon = match &grid {
            Some(grid) => Query::epsilon_of_voxel(grid.voxel_size),
            None => query.epsilon,
        };
        let request = PathRequest {
            scene: &query,
            program: self.program(),
            epsilon,
            lift: ray_lift(epsilon),
            frame: &frames[0],
            view: &view,
            options,
            control: &self.engine.control,
        };
        self.device.trace_paths(request, still).await
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
}

/// Checks that options are in range.
fn check(options: &StillOptions) -> Result<(), RenderError> {
    let fault = |name, value: u32, expected| {
        let value = f64::from(value);
        Err(RenderError::Setting {
            name,
            value,
            expected,
        })
    };
    if !(1..=MOST_SAMPLES).contains(&options.samples) {
        return fault("samples", options.samples, "from 1 to 1048576");
    }
    if !(1..=MOST_BOUNCES).contains(&options.max_bounces) {
        return fault("max_bounces", options.max_bounces, "from 1 to 1024");
    }
    Ok(())
}

/// Returns how far above a surface rays begin that leave it.
fn ray_lift(epsilon: f32) -> f32 {
    4.0 * epsilon
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
        ray_lift(self.epsilon)
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
            let [material] = probe.appearances([at(t)]);
            material[8] * (1.0 - material[7]) <= 0.0
        };
        if is_opaque(probe, 0.0) {
            return None;
        }
        let mut clear = 0.0;
        let mut opaque = None;
        for index in 1..INNER_PLACES {
            let t = end * index as f32 / INNER_PLACES as f32;
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
    let [appearance, right, up] = probe.appearances([point, point + step * x, point + step * y]);
    let slope = ((right[11] - appearance[11]) * x + (up[11] - appearance[11]) * y) / step;
    (
        appearance,
        (normal - slope).try_normalize().unwrap_or(normal),
    )
}
