//! How worlds are seen at first: the box of the surface, and a camera that shows all of it.
//!
//! What is known of a solid without a search is a box that contains it, which may be much larger. Pictures are framed by the surface
//! itself.

use crate::representation::{clip_box, sampled_box};
use argil_field::{Program, SurfaceReach};
use argil_math::Aabb;
use argil_render::Camera;
use argil_scene::{CameraPose, Scene, View};
use glam::Vec3;

/// The share of the image's height that the surface fills, across or upright.
const FILLED: f32 = 0.7;
/// Scenes of more brushes are framed by the box that is known without a search.
const MANY_BRUSHES: usize = 20_000;

/// How a world is seen at first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Framing {
    /// The box that is viewed.
    pub bounds: Aabb,
    /// The camera of a view that says neither where the camera is nor what is viewed.
    camera: Option<Camera>,
}

impl Framing {
    /// Frames a scene: by its view's bounds, by its surface, or, if that is infinite, by the box that clips it.
    pub(crate) fn of(scene: &Scene, program: &Program) -> Self {
        let solid = sampled_box(scene, program);
        if let Some(bounds) = clip_box(scene, solid) {
            let camera = None;
            return Self { bounds, camera };
        }
        let usual = if solid.is_finite() {
            solid
        } else {
            Aabb::centered(Vec3::ONE)
        };
        // What moves stays in the box of all times.
        if scene.duration().is_some() || program.brush_count() > MANY_BRUSHES {
            let (bounds, camera) = (usual, None);
            return Self { bounds, camera };
        }
        let mut reach = SurfaceReach::new(program, program.aabb());
        let surface = reach.aabb();
        let bounds = if surface.is_finite() { surface } else { usual };
        let camera = camera_around(&mut reach, bounds, scene.view.field_of_view_degrees);
        Self { bounds, camera }
    }

    /// Returns the camera of a view.
    pub(crate) fn camera(&self, view: &View) -> Camera {
        let usual = View::default();
        let degrees = view.field_of_view_degrees;
        match (view.camera, self.camera) {
            (camera, Some(fitted))
                if camera == usual.camera
                    && view.bounds.is_none()
                    && fitted.field_of_view_degrees == degrees =>
            {
                fitted
            }
            (camera, _) => self.camera_at(camera, degrees),
        }
    }

    /// Returns a camera in a pose.
    pub(crate) fn camera_at(&self, pose: CameraPose, field_of_view_degrees: f32) -> Camera {
        match pose {
            CameraPose::Orbit(orbit) => Camera::orbit(self.bounds, orbit, field_of_view_degrees),
            CameraPose::LookAt { eye, target } => Camera {
                eye: eye.into(),
                target: target.into(),
                field_of_view_degrees,
            },
        }
    }
}

/// Returns the height of the lowest point of a surface, or of a box if the surface has none.
pub(crate) fn lowest_point(program: &Program, bounds: Aabb) -> f32 {
    let known = program.aabb();
    let search = || SurfaceReach::new(program, known).along(Vec3::NEG_Y);
    let down = (program.brush_count() <= MANY_BRUSHES)
        .then(search)
        .flatten();
    let bounds = if known.is_finite() { known } else { bounds };
    down.map_or(bounds.min.y, |reach| -reach)
}

/// Returns a camera in the usual direction, in whose image the surface fills a part of the height, across or upright.
fn camera_around(reach: &mut SurfaceReach<'_>, bounds: Aabb, degrees: f32) -> Option<Camera> {
    let CameraPose::Orbit(orbit) = View::default().camera else {
        return None;
    };
    let usual = Camera::orbit(bounds, orbit, degrees);
    let forward = (usual.target - usual.eye).try_normalize()?;
    let right = forward.cross(Vec3::Y).try_normalize()?;
    let up = right.cross(forward);
    let slope = FILLED * (0.5 * degrees).to_radians().tan();
    // The surface touches four planes through the eye, or two of them.
    let mut planes = |axis: Vec3| {
        let low = reach.along(-axis - slope * forward)?;
        let high = reach.along(axis - slope * forward)?;
        Some([0.5 * (high - low), -0.5 * (high + low) / slope])
    };
    let [across, back_of_width] = planes(right)?;
    let [high, back_of_height] = planes(up)?;
    let back = back_of_width.min(back_of_height);
    let deep = [reach.along(forward)?, -reach.along(-forward)?];
    let distance = 0.5 * (deep[0] + deep[1]) - back;
    let eye = across * right + high * up + back * forward;
    let target = eye + distance.max(1e-6) * forward;
    let is_finite = eye.is_finite() && target.is_finite();
    is_finite.then_some(Camera {
        eye,
        target,
        field_of_view_degrees: degrees,
    })
}
