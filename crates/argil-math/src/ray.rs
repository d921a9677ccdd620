use crate::Aabb;
use glam::Vec3;

/// A half line: the points `origin + t * direction` for `t ≥ 0`. `direction` is a unit vector, so `t` is a length.
///
/// ```
/// use argil_math::{Aabb, Ray};
/// use glam::Vec3;
/// let ray = Ray { origin: Vec3::new(0.0, 0.0, 5.0), direction: Vec3::NEG_Z };
/// assert_eq!(ray.span(Aabb::centered(Vec3::ONE)), Some((4.0, 6.0)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start of the ray.
    pub origin: Vec3,
    /// Unit direction of the ray.
    pub direction: Vec3,
}

impl Ray {
    /// Returns the point at length `t`.
    pub fn at(self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }

    /// Returns the lengths at which the ray enters and leaves a box, cut to `t ≥ 0`, or `None` if it misses.
    ///
    /// Slab test (Kay and Kajiya 1986). A zero component of the direction is replaced by a tiny one, so that no `0
    /// × ∞` arises.
    pub fn span(self, b: Aabb) -> Option<(f32, f32)> {
        let tiny = |d: f32| if d.abs() < 1e-20 { 1e-20 } else { d };
        let inverse = Vec3::new(
            tiny(self.direction.x),
            tiny(self.direction.y),
            tiny(self.direction.z),
        )
        .recip();
        let a = (b.min - self.origin) * inverse;
        let c = (b.max - self.origin) * inverse;
        let near = a.min(c).max_element().max(0.0);
        let far = a.max(c).min_element();
        (near <= far).then_some((near, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_rays_along_an_axis_inside_and_beside() {
        let unit = Aabb::centered(Vec3::ONE);
        let ray = |o: [f32; 3], d: [f32; 3]| {
            Ray {
                origin: o.into(),
                direction: d.into(),
            }
            .span(unit)
        };
        assert_eq!(ray([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Some((2.0, 4.0)));
        assert_eq!(ray([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]), Some((0.0, 1.0)));
        assert_eq!(ray([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(ray([-3.0, 2.0, 0.0], [1.0, 0.0, 0.0]), None);
    }
}
