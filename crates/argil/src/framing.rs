//! How worlds are seen at first: the box of the surface, and a camera that shows all of it.
//!
//! What is known of a solid without a search is a box that contains it, which may be much larger. Pictures are framed by the surface
//! itself.

use crate::representation::{clip_box, sampled_box, union_over_time};
use argil_field::{Program, SurfaceReach};
use argil_math::Aabb;
use argil_render::Camera;
use argil_scene::{CameraPose, Scene, View};
use glam::Vec3;

/// The share of the image's height that the surface fills, along the longer side of its outline.
const FILLED: f32 = 0.7;

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
        let mut reach = SurfaceReach::new(program, program.aabb());
        let at_time = |moved: &Scene| {
            let program = Program::lower(moved);
            program.map_or(Aabb::EMPTY, |own| surface_box(&own))
        };
        let surface = reach.aabb().union(union_over_time(scene, at_time));
        let bounds = match surface.is_finite() {
            true => surface,
            false if solid.is_finite() => solid,
            false => Aabb::centered(Vec3::ONE),
        };
        let camera = match scene.duration() {
            None => camera_around(&mut reach, bounds, scene.view.field_of_view_degrees),
            // What moves stays in its box.
            Some(_) => None,
        };
        Self { bounds, camera }
    }

    /// Returns the camera of a view.
    pub(crate) fn camera(&self, view: &View) -> Camera {
        let usual = View::default();
        let degrees = view.field_of_view_degrees;
        match (view.camera, self.camera) {
            (camera, Some(own))
                if camera == usual.camera
                    && view.bounds.is_none()
                    && own.field_of_view_degrees == degrees =>
            {
                own
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

/// Returns the box of a program's surface, or the solid's box if that is empty or infinite.
pub(crate) fn surface_box(program: &Program) -> Aabb {
    let surface = SurfaceReach::new(program, program.aabb()).aabb();
    match surface.is_empty() {
        true => program.aabb(),
        false => surface,
    }
}

/// Returns the height of the lowest point of a surface, or of a box if the surface has none.
pub(crate) fn lowest_point(program: &Program, bounds: Aabb) -> f32 {
    let down = SurfaceReach::new(program, program.aabb()).along(Vec3::NEG_Y);
    let told = program.aabb();
    let told = if told.is_finite() { told } else { bounds };
    down.map_or(told.min.y, |reach| -reach)
}

/// Returns a camera in the usual direction, in whose image the outline of the surface fills a part.
fn camera_around(reach: &mut SurfaceReach<'_>, bounds: Aabb, degrees: f32) -> Option<Camera> {
    let CameraPose::Orbit(orbit) = View::default().camera else {
        return None;
    };
    let usual = Camera::orbit(bounds, orbit, degrees);
    let forward = (usual.target - usual.eye).try_normalize()?;
    let right = forward.cross(Vec3::Y).try_normalize()?;
    let up = right.cross(forward);
    let mut span = |axis: Vec3| Some([-reach.along(-axis)?, reach.along(axis)?]);
    let spans = [span(right)?, span(up)?, span(forward)?];
    let [across, high, deep] = spans.map(|[low, high]| 0.5 * (high - low));
    let middles = spans.map(|[low, high]| 0.5 * (low + high));
    let half_height = (0.5 * degrees).to_radians().tan();
    // The outline is about as far away as the middle.
    let distance = across.max(high) / (FILLED * half_height);
    let distance = distance.max(1.1 * deep).max(1e-6);
    let target = right * middles[0] + up * middles[1] + forward * middles[2];
    Some(Camera {
        eye: target - distance * forward,
        target,
        field_of_view_degrees: degrees,
    })
}
