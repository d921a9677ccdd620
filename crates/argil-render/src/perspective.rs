//! A camera as a matrix, as renderers have it.

use crate::Camera;
use argil_abi::FrameUniform;
use glam::{DMat4, DVec3, DVec4};

/// A perspective view as the matrix from the world to clip space, where x and y go from -1 to 1 and y is up. It may be
/// rolled or off its axis, and depth may be reversed or infinite.
///
/// ```
/// use argil_render::Perspective;
/// use glam::Vec3;
/// use glam::camera::rh::{proj::directx, view::look_at_mat4};
/// let projection = directx::perspective_infinite_reverse(0.8, 1.5, 0.1);
/// let view = look_at_mat4(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, Vec3::Y);
/// let own = Perspective::from_matrix((projection * view).to_cols_array_2d()).expect("a perspective");
/// assert!(own.camera().eye.distance(Vec3::new(0.0, 1.0, 5.0)) < 1e-5);
/// // A view of parallel rays has no eye.
/// let parallel = directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
/// assert!(Perspective::from_matrix(parallel.to_cols_array_2d()).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    clip_from_world: [[f32; 4]; 4],
    eye: DVec3,
    /// From the middle of the image to its right side, to its top, and from the eye to the middle, at a distance of 1 from
    /// the eye's plane.
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl Perspective {
    /// Returns the view of a matrix, by columns. `None` if a number is not finite, the matrix has no inverse, or its rays are
    /// parallel.
    ///
    /// *Theory.* The eye is where clip space has x = y = w = 0. The plane of a distance from it has a constant w.
    pub fn from_matrix(clip_from_world: [[f32; 4]; 4]) -> Option<Self> {
        let matrix =
            DMat4::from_cols_array_2d(&clip_from_world.map(|column| column.map(f64::from)));
        let inverse = matrix.is_finite().then(|| matrix.inverse())?;
        let apex = inverse * DVec4::Z;
        let eye = apex.truncate() / apex.w;
        let distance = matrix.row(3).truncate().length();
        let toward = |clip: DVec4| {
            let place = inverse * clip;
            (place.truncate() - place.w * eye) * distance
        };
        let own = Self {
            clip_from_world,
            eye,
            right: toward(DVec4::X),
            up: toward(DVec4::Y),
            forward: toward(DVec4::W),
        };
        let is_sound = |v: DVec3| v.as_vec3().is_finite() && v.as_vec3().length() > 0.0;
        let are_sound = is_sound(own.right) && is_sound(own.up) && is_sound(own.forward);
        (eye.as_vec3().is_finite() && are_sound).then_some(own)
    }

    /// Returns the matrix.
    pub fn clip_from_world(&self) -> [[f32; 4]; 4] {
        self.clip_from_world
    }

    /// Returns the camera in the eye, without the view's roll and shift.
    pub fn camera(&self) -> Camera {
        let field_of_view = 2.0 * self.up.length().atan().to_degrees();
        Camera {
            eye: self.eye.as_vec3(),
            target: (self.eye + self.forward).as_vec3(),
            field_of_view_degrees: field_of_view.clamp(1.0, 170.0) as f32,
        }
    }

    /// Replaces the camera of a frame.
    pub fn write(&self, frame: &mut FrameUniform) {
        let sides = [
            self.right.length() / f64::from(frame.width),
            self.up.length() / f64::from(frame.height),
        ];
        let pixel_width = 2.0 * sides[0].max(sides[1]) as f32;
        frame.close_slope *= pixel_width / frame.pixel_width;
        frame.pixel_width = pixel_width;
        frame.eye = self.eye.as_vec3().to_array();
        frame.right = self.right.as_vec3().to_array();
        frame.up = self.up.as_vec3().to_array();
        frame.forward = self.forward.as_vec3().to_array();
    }
}
