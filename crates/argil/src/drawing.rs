//! Pictures of a world.

use crate::limits::{MAX_PIXELS, MAX_SIDE};
use crate::representation::{Drawable, Kept, Triangulated, triangles};
use crate::{Drawn, Placement, RenderError, Via, World};
use argil_abi::{HIT_INSIDE, HIT_OUTSIDE, Hit};
use argil_march::{Camera, Picture, Settings, Show, Through, frames};
use web_time::Instant;

/// Most steps of a ray, unless it is asked for otherwise: through the field, and through a volume, where a step is short.
const FIELD_STEPS: u32 = 256;
const VOLUME_STEPS: u32 = 4096;

impl World {
    /// The scene's own camera.
    pub fn camera(&self) -> Camera {
        self.camera_at(self.scene.view.camera)
    }

    /// A camera with the scene's field of view.
    pub fn camera_at(&self, placement: Placement) -> Camera {
        let field_of_view_degrees = self.scene.view.field_of_view_degrees;
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
            ground: self.scene.view.ground && show == Show::Shaded,
            sun_degrees: self.scene.view.sun_degrees,
            max_steps: match self.via {
                Via::Field => FIELD_STEPS,
                _ => VOLUME_STEPS,
            },
            ..Settings::default()
        }
    }

    /// [`World::draw`] as a future; see [`Build::via_async`](crate::Build::via_async).
    ///
    /// # Errors
    /// As there.
    pub async fn draw_async(
        &self,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Drawn, RenderError> {
        let (picture, duration_ms) = self.picture(camera, settings, false).await?;
        Ok(Drawn::new(picture, duration_ms))
    }

    /// [`World::draw_async`] and [`World::lengths`] in one.
    ///
    /// # Errors
    /// As there.
    pub async fn draw_with_lengths_async(
        &self,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(Drawn, Vec<f32>), RenderError> {
        let (picture, duration_ms) = self.picture(camera, settings, true).await?;
        let length = |hit: &Hit| match hit.kind {
            HIT_OUTSIDE | HIT_INSIDE => hit.normal_t[3],
            _ => f32::INFINITY,
        };
        let lengths = picture.hits.iter().map(length).collect();
        Ok((Drawn::new(picture, duration_ms), lengths))
    }

    async fn picture(
        &self,
        camera: &Camera,
        settings: &Settings,
        with_hits: bool,
    ) -> Result<(Picture, f64), RenderError> {
        check(camera, settings)?;
        if !self.via.shows(settings.show) {
            return Err(RenderError::NoBricks);
        }
        let lattice = self.kept.lattice();
        let frames = frames(
            settings,
            camera,
            self.program(),
            lattice.as_ref(),
            self.focus,
        );
        if let Some(field) = &self.gpu {
            field.complete(|| self.program());
            let (picture, duration_ms) = match &self.kept {
                Kept::Gpu(volume) => volume.render(field, &frames, with_hits).await?,
                Kept::Mesh(Drawable {
                    mesh: Triangulated::Gpu(mesh),
                    ..
                }) => mesh.render(field, &frames, with_hits).await?,
                _ => field.render(&frames, with_hits).await?,
            };
            return Ok((picture, duration_ms));
        }
        let drawn;
        let through: &dyn Through = match &self.kept {
            Kept::Cpu(volume) => volume,
            Kept::Mesh(Drawable {
                mesh: Triangulated::Cpu(mesh),
                ..
            }) => {
                drawn = triangles(mesh);
                &drawn
            }
            _ => &argil_march::Field,
        };
        let start = Instant::now();
        let control = &self.engine.control;
        let picture =
            argil_march::render_controlled(self.program(), through, &frames, with_hits, control);
        let picture = picture.ok_or(RenderError::Cancelled)?;
        Ok((picture, start.elapsed().as_secs_f64() * 1e3))
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
