//! A camera as a matrix, as renderers have it.

use crate::Camera;
use argil_abi::{FrameUniform, MODE_HEAT};
use argil_math::Aabb;
use glam::{DMat4, DVec2, DVec3, DVec4};

/// How far parallel rays begin before the middle of what they see, in radii: so far that the width of a pixel, which is stored
/// as a slope, hardly changes within it.
const PARALLEL_RADII: f64 = 8.0;
/// The reciprocal of a distance at which no eye is: rays are parallel.
const NO_EYE: f64 = 1e-9;

/// A view as the matrix from the world to clip space, where x and y go from -1 to 1 and y is up. It may be rolled or off its
/// axis, depth may be reversed or infinite, and rays may be parallel.
///
/// ```
/// use argil_render::Projection;
/// use glam::Vec3;
/// use glam::camera::rh::{proj::directx, view::look_at_mat4};
/// let view = look_at_mat4(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, Vec3::Y);
/// let perspective = directx::perspective_infinite_reverse(0.8, 1.5, 0.1);
/// let own = Projection::from_matrix((perspective * view).to_cols_array_2d(), true).expect("a view");
/// assert!(own.camera().eye.distance(Vec3::new(0.0, 1.0, 5.0)) < 1e-5);
/// let parallel = directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
/// let own = Projection::from_matrix((parallel * view).to_cols_array_2d(), false).expect("a view");
/// assert!(own.is_parallel());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    clip_from_world: [[f32; 4]; 4],
    /// Where all rays begin, or the middle one if they are parallel.
    eye: DVec3,
    /// From the middle of the image to its right side and to its top: at a distance of 1 from the eye's plane, or everywhere if
    /// rays are parallel.
    right: DVec3,
    up: DVec3,
    /// From the eye's plane to the middle of the image at a distance of 1.
    forward: DVec3,
    is_parallel: bool,
}

impl Projection {
    /// Returns the view of a matrix, by columns. With `is_reversed`, what is nearer has a greater depth; only parallel rays
    /// need that, to know where they go. `None` if a number is not finite, or the matrix has no inverse.
    ///
    /// *Theory.* The eye is where clip space has x = y = w = 0. The plane of a distance from it has a constant w. Without an eye,
    /// w is the same everywhere, and rays go where depth increases.
    pub fn from_matrix(clip_from_world: [[f32; 4]; 4], is_reversed: bool) -> Option<Self> {
        let matrix =
            DMat4::from_cols_array_2d(&clip_from_world.map(|column| column.map(f64::from)));
        let inverse = matrix.is_finite().then(|| matrix.inverse())?;
        let apex = inverse * DVec4::Z;
        let view = match apex.w.abs() > NO_EYE * apex.truncate().length() {
            true => {
                let growth = matrix.row(3).truncate().length();
                let eye = apex.truncate() / apex.w;
                let toward = |clip: DVec4| {
                    let place = inverse * clip;
                    (place.truncate() - place.w * eye) * growth
                };
                Self {
                    clip_from_world,
                    eye,
                    right: toward(DVec4::X),
                    up: toward(DVec4::Y),
                    forward: toward(DVec4::W),
                    is_parallel: false,
                }
            }
            false => {
                // The same w, by which the clip space of its matrix is to be multiplied.
                let w = matrix.w_axis.w;
                let toward = |clip: DVec4| (inverse * clip).truncate() * w;
                let deeper = toward(DVec4::Z).normalize();
                Self {
                    clip_from_world,
                    eye: toward(DVec4::W),
                    right: toward(DVec4::X),
                    up: toward(DVec4::Y),
                    forward: if is_reversed { -deeper } else { deeper },
                    is_parallel: true,
                }
            }
        };
        let is_sound = |v: DVec3| v.as_vec3().is_finite() && v.as_vec3().length() > 0.0;
        let are_sound = is_sound(view.right) && is_sound(view.up) && is_sound(view.forward);
        (view.eye.as_vec3().is_finite() && are_sound).then_some(view)
    }

    /// Returns the matrix.
    pub fn clip_from_world(&self) -> [[f32; 4]; 4] {
        self.clip_from_world
    }

    /// Whether all rays have the same direction.
    pub fn is_parallel(&self) -> bool {
        self.is_parallel
    }

    /// Returns the camera in the eye, without the view's roll and shift. Of parallel rays, one in the middle of the image.
    pub fn camera(&self) -> Camera {
        let field_of_view = 2.0 * self.up.length().atan().to_degrees();
        Camera {
            eye: self.eye.as_vec3(),
            target: (self.eye + self.forward).as_vec3(),
            field_of_view_degrees: field_of_view.clamp(1.0, 170.0) as f32,
        }
    }

    /// Returns the normal of the plane of what is nearest, and its distance from a point. `None` if it is nowhere.
    ///
    /// *Theory.* Depth is from 0 to 1 in what a view sees: 0 ≤ z and z ≤ w. Forward, one of the two increases from less than 0.
    fn near_plane(&self, from: DVec3) -> Option<[f32; 4]> {
        let columns = self.clip_from_world.map(|column| column.map(f64::from));
        let matrix = DMat4::from_cols_array_2d(&columns);
        let [z, w] = [matrix.row(2), matrix.row(3)];
        let forward = self.forward.normalize();
        let slope = |plane: DVec4| plane.truncate().dot(forward);
        let plane = if slope(z) > slope(w - z) { z } else { w - z };
        let scale = plane.truncate().length();
        let distance = -(plane.truncate().dot(from) + plane.w) / scale;
        let plane = (plane.truncate() / scale).extend(distance).as_vec4();
        plane.is_finite().then(|| plane.to_array())
    }

    /// Replaces the camera of a frame. What is nearer than the near plane is cut away.
    pub fn write(&self, frame: &mut FrameUniform) {
        let sides = DVec2::new(self.right.length(), self.up.length())
            / DVec2::new(frame.width.into(), frame.height.into());
        let mut pixel_width = 2.0 * sides.max_element();
        let mut eye = self.eye;
        if self.is_parallel {
            let [low, high] =
                [frame.box_min, frame.box_max].map(|end| DVec3::from(end.map(f64::from)));
            let seen = Aabb::new(low.as_vec3(), high.as_vec3());
            // An infinite solid has no middle.
            let (middle, radius) = match seen.is_finite() {
                true => (0.5 * (low + high), 0.5 * low.distance(high)),
                false => (eye, f64::from(frame.radius)),
            };
            let before = PARALLEL_RADII * radius.max(f64::from(frame.radius)).max(1e-4);
            eye += self.forward * ((middle - eye).dot(self.forward) - before);
            // At the near end of what is seen, and a little more behind.
            let near = before - radius;
            pixel_width /= near;
            frame.depth_near = near as f32;
            if frame.mode != MODE_HEAT {
                frame.depth_far = (before + radius) as f32;
            }
        }
        let pixel_width = pixel_width as f32;
        frame.close_slope *= pixel_width / frame.pixel_width;
        frame.pixel_width = pixel_width;
        frame.eye = eye.as_vec3().to_array();
        frame.near_plane = self.near_plane(eye).unwrap_or_default();
        frame.forward = self.forward.as_vec3().to_array();
        let sides = [self.right, self.up].map(|side| side.as_vec3().to_array());
        let (at_eye, at_one) = match self.is_parallel {
            true => (sides, [[0.0; 3]; 2]),
            false => ([[0.0; 3]; 2], sides),
        };
        [frame.eye_right, frame.eye_up] = at_eye;
        [frame.right, frame.up] = at_one;
    }
}
