//! Where twists and bends hold points.

use crate::Modifier;
use crate::extent::{Extent, around_y};
use argil_math::Aabb;
use glam::{DVec3, Vec3};

impl Modifier {
    /// Returns the part of space to which a twist or bend clamps points: around the deformed solid, with a margin. `None`
    /// for other modifiers.
    pub fn clamp(&self, content: &Extent) -> Option<Clamp> {
        let region = content.aabb;
        let clamp = match self {
            Self::Twist { .. } => Clamp {
                aabb: around_y(content.radius, region),
                radius: content.radius,
            },
            Self::Bend { .. } => {
                let far = region.min.abs().max(region.max.abs());
                let r = far.truncate().length();
                Clamp {
                    aabb: Aabb::new(
                        Vec3::new(-r, -r, region.min.z),
                        Vec3::new(r, r, region.max.z),
                    ),
                    radius: f32::INFINITY,
                }
            }
            _ => return None,
        };
        // Without a margin, the distance would be 0 on faces that the solid touches.
        let margin = 0.05 * clamp.aabb.half_diagonal();
        Some(Clamp {
            aabb: clamp.aabb.grown(margin),
            radius: clamp.radius + margin,
        })
    }
}

/// A part of space: the points of a box up to a distance from the y axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamp {
    /// The box.
    pub aabb: Aabb,
    /// The largest distance from the y axis. Infinite for a bend.
    pub radius: f32,
}

impl Clamp {
    /// Returns the nearest point in the part. The box must be around the cylinder, or the radius infinite.
    pub fn nearest(&self, point: DVec3) -> DVec3 {
        let within = point.clamp(self.aabb.min.as_dvec3(), self.aabb.max.as_dvec3());
        let r = point.x.hypot(point.z);
        if r > f64::from(self.radius) {
            let by = f64::from(self.radius) / r;
            DVec3::new(by * point.x, within.y, by * point.z)
        } else {
            within
        }
    }
}

/// Returns how much a twist or bend of what is in `clamp` can stretch space: the largest singular value of its
/// Jacobian.
///
/// A twist shears a point at radius r by a = rate · r, and the largest singular value of a shear is (a + √(a² + 4))
/// / 2. A bend's Jacobian is a rotation plus one column of length rate · r.
pub(crate) fn stretch_of_turn(modifier: &Modifier, clamp: &Clamp) -> f32 {
    match *modifier {
        Modifier::Twist { degrees_per_unit } => {
            let a = degrees_per_unit.to_radians().abs() * clamp.radius;
            0.5 * (a + (a * a + 4.0).sqrt())
        }
        Modifier::Bend { degrees_per_unit } => {
            let far = clamp.aabb.min.abs().max(clamp.aabb.max.abs());
            1.0 + degrees_per_unit.to_radians().abs() * far.truncate().length()
        }
        _ => 1.0,
    }
}
