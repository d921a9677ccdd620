//! The viewport's camera, which orbits a point or flies.

use argil::glam::{Quat, Vec2, Vec3};
use argil::math::Aabb;
use argil::render::Camera;

/// A view along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ViewSide {
    /// From +z.
    Front,
    /// From +x.
    Right,
    /// From +y.
    Top,
}

/// The camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewportCamera {
    /// The point that it orbits.
    pub target: Vec3,
    /// Degrees about y, from +z toward +x.
    pub azimuth: f32,
    /// Degrees above the horizon.
    pub elevation: f32,
    /// Distance to the target.
    pub distance: f32,
    /// Whether the projection is orthographic: a field of view of one degree from far away.
    pub is_ortho: bool,
    /// Field of view of the perspective projection, in degrees.
    pub field_of_view_degrees: f32,
}

/// A field of view this narrow makes parallel lines parallel to within half a pixel in a hundred.
const ORTHO_DEGREES: f32 = 1.0;

impl Default for ViewportCamera {
    fn default() -> Self {
        Self {
            target: Vec3::ZERO,
            azimuth: 30.0,
            elevation: 20.0,
            distance: 4.0,
            is_ortho: false,
            field_of_view_degrees: 35.0,
        }
    }
}

impl ViewportCamera {
    /// Converts from the engine's camera.
    pub(crate) fn of(camera: &Camera) -> Self {
        let away = camera.eye - camera.target;
        let distance = away.length().max(1e-6);
        Self {
            target: camera.target,
            azimuth: away.x.atan2(away.z).to_degrees(),
            elevation: (away.y / distance).clamp(-1.0, 1.0).asin().to_degrees(),
            distance,
            is_ortho: false,
            field_of_view_degrees: camera.field_of_view_degrees,
        }
    }

    /// Returns the direction from the target to the camera.
    pub(crate) fn backward(&self) -> Vec3 {
        let (a, e) = (self.azimuth.to_radians(), self.elevation.to_radians());
        Vec3::new(e.cos() * a.sin(), e.sin(), e.cos() * a.cos())
    }

    /// Returns the right and up directions of the image.
    pub(crate) fn axes(&self) -> [Vec3; 2] {
        let turn = Quat::from_rotation_y(self.azimuth.to_radians())
            * Quat::from_rotation_x(-self.elevation.to_radians());
        [turn * Vec3::X, turn * Vec3::Y]
    }

    /// Returns the field of view in degrees.
    pub(crate) fn lens_degrees(&self) -> f32 {
        if self.is_ortho {
            ORTHO_DEGREES
        } else {
            self.field_of_view_degrees
        }
    }

    /// Returns the actual distance, at which the target appears equally large in both projections.
    fn away(&self) -> f32 {
        let half = |degrees: f32| (0.5 * degrees.to_radians()).tan();
        self.distance * half(self.field_of_view_degrees) / half(self.lens_degrees())
    }

    /// Converts to the engine's camera.
    pub(crate) fn camera(&self) -> Camera {
        Camera {
            eye: self.target + self.backward() * self.away(),
            target: self.target,
            field_of_view_degrees: self.lens_degrees(),
        }
    }

    /// Orbits by degrees.
    pub(crate) fn orbit(&mut self, by: Vec2) {
        self.azimuth = (self.azimuth + by.x).rem_euclid(360.0);
        self.elevation = (self.elevation + by.y).clamp(-89.9, 89.9);
    }

    /// Returns half the visible height at the target.
    pub(crate) fn half_height(&self) -> f32 {
        self.distance * (0.5 * self.field_of_view_degrees.to_radians()).tan()
    }

    /// Pans by fractions of the image height.
    pub(crate) fn pan(&mut self, by: Vec2) {
        let [right, up] = self.axes();
        let height = 2.0 * self.half_height();
        self.target += height * (up * by.y - right * by.x);
    }

    /// Zooms in, or out with a factor above 1.
    pub(crate) fn zoom(&mut self, by: f32) {
        self.distance = (self.distance * by).clamp(1e-3, 1e5);
    }

    /// Turns without moving.
    pub(crate) fn look(&mut self, by: Vec2) {
        let stands = self.camera().eye;
        self.orbit(by);
        self.target = stands - self.backward() * self.away();
    }

    /// Moves right, up and forward.
    pub(crate) fn fly(&mut self, by: Vec3) {
        let [right, up] = self.axes();
        self.target += right * by.x + up * by.y - self.backward() * by.z;
    }

    /// Frames a box.
    pub(crate) fn frame(&mut self, what: Aabb) {
        if !what.is_finite() {
            return;
        }
        let radius = what.half_diagonal().max(1e-3);
        self.target = what.center();
        self.distance = radius / (0.5 * self.field_of_view_degrees.to_radians()).sin();
    }

    /// Looks along an axis; from the other side if it already does.
    pub(crate) fn along(&mut self, side: ViewSide) {
        let [azimuth, elevation] = match side {
            ViewSide::Front => [0.0, 0.0],
            ViewSide::Right => [90.0, 0.0],
            ViewSide::Top => [0.0, 89.9],
        };
        let is_there = self.is_ortho && self.azimuth == azimuth && self.elevation == elevation;
        (self.azimuth, self.elevation) = match (is_there, side) {
            (false, _) => (azimuth, elevation),
            (true, ViewSide::Top) => (azimuth, -elevation),
            (true, _) => (azimuth + 180.0, elevation),
        };
        self.is_ortho = true;
    }

    /// Projects a point to pixels from the upper left corner of an image. `None` behind the camera.
    pub(crate) fn project(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let camera = self.camera();
        let [right, up] = self.axes();
        let from = point - camera.eye;
        let depth = -from.dot(self.backward());
        if depth <= 1e-4 * self.distance {
            return None;
        }
        let scale = 0.5 * size.y / (0.5 * camera.field_of_view_degrees.to_radians()).tan() / depth;
        Some(0.5 * size + scale * Vec2::new(from.dot(right), -from.dot(up)))
    }

    /// Returns the origin and direction of the ray through a pixel.
    pub(crate) fn ray(&self, at: Vec2, size: Vec2) -> [Vec3; 2] {
        let camera = self.camera();
        let [right, up] = self.axes();
        let half = (0.5 * camera.field_of_view_degrees.to_radians()).tan();
        let place = (at - 0.5 * size) * (2.0 * half / size.y);
        let direction = right * place.x - up * place.y - self.backward();
        [camera.eye, direction.normalize()]
    }

    /// Returns the number of pixels that a length of 1 at a point covers.
    pub(crate) fn pixels_per_unit(&self, point: Vec3, size: Vec2) -> f32 {
        let camera = self.camera();
        let depth = -(point - camera.eye).dot(self.backward());
        let half = (0.5 * camera.field_of_view_degrees.to_radians()).tan();
        0.5 * size.y / (half * depth.max(1e-6))
    }
}

/// Intersects a ray with a plane through a point.
pub(crate) fn on_plane([origin, direction]: [Vec3; 2], point: Vec3, normal: Vec3) -> Option<Vec3> {
    let along = direction.dot(normal);
    let t = (point - origin).dot(normal) / along;
    (along.abs() > 1e-6 && t > 0.0 && t.is_finite()).then(|| origin + t * direction)
}

/// Returns the parameter of the point on a line that is nearest to a ray.
pub(crate) fn on_line([origin, direction]: [Vec3; 2], point: Vec3, axis: Vec3) -> Option<f32> {
    let cross = direction.cross(axis);
    let square = cross.length_squared();
    if square < 1e-8 {
        return None;
    }
    Some((point - origin).cross(direction).dot(cross) / square)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(640.0, 480.0);

    #[test]
    fn rays_go_through_what_is_projected() {
        for is_ortho in [false, true] {
            let eye = ViewportCamera {
                is_ortho,
                target: Vec3::new(0.2, -0.3, 0.1),
                ..ViewportCamera::default()
            };
            for point in [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.9, -0.7)] {
                let at = eye.project(point, SIZE).expect("in front");
                let [origin, direction] = eye.ray(at, SIZE);
                let off = (point - origin).reject_from(direction).length();
                assert!(off < 1e-3, "{off}");
            }
            let middle = eye.project(eye.target, SIZE).expect("in front");
            assert!((middle - 0.5 * SIZE).length() < 0.1);
        }
    }

    #[test]
    fn it_stands_where_the_engine_has_it() {
        let focus = Aabb::new(Vec3::splat(-1.0), Vec3::new(2.0, 1.0, 1.0));
        let camera = Camera::orbit(focus, [30.0, 20.0, 3.6], 35.0);
        let again = ViewportCamera::of(&camera).camera();
        assert!((again.eye - camera.eye).length() < 1e-4);
        let mut eye = ViewportCamera::of(&camera);
        eye.frame(focus);
        for corner in focus.corners() {
            let at = eye.project(corner, SIZE).expect("in front");
            assert!(at.cmpge(Vec2::ZERO).all() && at.cmple(SIZE).all(), "{at}");
        }
        let stands = eye.camera().eye;
        eye.look(Vec2::new(20.0, 5.0));
        assert!((eye.camera().eye - stands).length() < 1e-4);
    }

    #[test]
    fn the_nearest_of_a_line() {
        let ray = [Vec3::new(3.0, 1.0, 5.0), -Vec3::Z];
        let t = on_line(ray, Vec3::ZERO, Vec3::X).expect("not parallel");
        assert!((t - 3.0).abs() < 1e-5, "{t}");
        assert_eq!(on_line(ray, Vec3::ZERO, Vec3::Z), None);
        assert_eq!(
            on_plane(ray, Vec3::ZERO, Vec3::Z),
            Some(Vec3::new(3.0, 1.0, 0.0))
        );
    }
}
