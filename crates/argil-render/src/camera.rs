use argil_abi::FrameUniform;
use argil_math::{Aabb, Ray};
use glam::Vec3;

/// A pinhole camera.
///
/// ```
/// use argil_math::Aabb;
/// use argil_render::Camera;
/// let camera = Camera::orbit(Aabb::new([-1.0; 3].into(), [1.0; 3].into()), [0.0, 0.0, 2.0], 35.0);
/// assert!(camera.eye.z > 3.0 && camera.eye.y.abs() < 1e-5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the camera.
    pub eye: Vec3,
    /// The point in the middle of the image.
    pub target: Vec3,
    /// Vertical field of view in degrees.
    pub field_of_view_degrees: f32,
}

impl Camera {
    /// Creates a camera on an orbit around a box. The orbit is azimuth about y from +z toward +x and elevation, in
    /// degrees, and the distance in multiples of the radius of the box's bounding sphere.
    pub fn orbit(
        around: Aabb,
        [azimuth, elevation, distance]: [f32; 3],
        field_of_view_degrees: f32,
    ) -> Self {
        let (around, radius) = finite(around);
        let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
        let direction = Vec3::new(
            elevation.cos() * azimuth.sin(),
            elevation.sin(),
            elevation.cos() * azimuth.cos(),
        );
        let target = around.center();
        // A camera in its target has no direction, so it looks along the orbit's.
        let eye = target + direction * (distance * radius).max(1e-4 * radius);
        Self {
            eye,
            target,
            field_of_view_degrees,
        }
    }

    /// Returns the camera rotated about the vertical axis through its target.
    pub fn orbited(self, degrees: f32) -> Self {
        let turn = glam::Quat::from_rotation_y(degrees.to_radians());
        Self {
            eye: self.target + turn * (self.eye - self.target),
            ..self
        }
    }

    /// Returns the unit axes to the right, up and forward.
    pub(crate) fn axes(&self) -> [Vec3; 3] {
        let forward = (self.target - self.eye)
            .try_normalize()
            .unwrap_or(Vec3::NEG_Z);
        // Straight up or down there is no horizon: keep x to the right.
        let right = forward
            .cross(Vec3::Y)
            .try_normalize()
            .filter(|_| forward.y.abs() < 0.999_999)
            .unwrap_or(Vec3::X);
        [right, right.cross(forward), forward]
    }
}

/// Returns a box that can be viewed, and its radius: the box itself if it is finite, else one of size 2 around the
/// origin.
pub(crate) fn finite(b: Aabb) -> (Aabb, f32) {
    let b = if b.is_finite() {
        b
    } else {
        Aabb::centered(Vec3::ONE)
    };
    (b, b.half_diagonal().max(1e-4))
}

/// Returns the primary ray of a pixel, at the frame's offset within it. `camera.wgsl` is the twin.
#[inline]
pub(crate) fn primary_ray(frame: &FrameUniform, x: u32, y: u32) -> Ray {
    let u = (x as f32 + frame.jitter_x) / frame.width as f32 * 2.0 - 1.0;
    let v = 1.0 - (y as f32 + frame.jitter_y) / frame.height as f32 * 2.0;
    let axis = |k: usize| frame.forward[k] + frame.right[k] * u + frame.up[k] * v;
    let (dx, dy, dz) = (axis(0), axis(1), axis(2));
    let length = (dx * dx + dy * dy + dz * dz).sqrt();
    let [ex, ey, ez] = frame.eye;
    Ray {
        origin: Vec3::new(ex, ey, ez),
        direction: Vec3::new(dx / length, dy / length, dz / length),
    }
}

/// Returns the box that contains the solid.
pub(crate) fn bounds_of(frame: &FrameUniform) -> Aabb {
    let [ax, ay, az] = frame.box_min;
    let [bx, by, bz] = frame.box_max;
    Aabb::new(Vec3::new(ax, ay, az), Vec3::new(bx, by, bz))
}

/// Returns the normal of the box's side where a ray enters, if the ray ends right there: the box clips a solid.
pub(crate) fn clip_normal(frame: &FrameUniform, ray: Ray, t: f32) -> Option<Vec3> {
    let bounds = bounds_of(frame);
    let (near, _) = ray.span(bounds)?;
    if near <= 0.0 || t > near {
        return None;
    }
    let p = ray.at(near);
    let from_side = (p - bounds.min).abs().min((p - bounds.max).abs());
    let axis = from_side.min_position();
    let mut normal = Vec3::ZERO;
    normal[axis] = if ray.direction[axis] < 0.0 { 1.0 } else { -1.0 };
    Some(normal)
}

/// Returns the direction through a position in the image, in pixels.
pub(crate) fn through(frame: &FrameUniform, x: f32, y: f32) -> Vec3 {
    let u = x / frame.width as f32 * 2.0 - 1.0;
    let v = 1.0 - y / frame.height as f32 * 2.0;
    let axis = |k: usize| frame.forward[k] + frame.right[k] * u + frame.up[k] * v;
    Vec3::new(axis(0), axis(1), axis(2)).normalize()
}

/// Returns how far the rays of a block of pixels are from its middle one at length 1, at most, and a little more.
pub(crate) fn slope_of(frame: &FrameUniform, side: u32) -> f32 {
    0.708 * side as f32 * frame.pixel_width
}
