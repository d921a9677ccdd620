//! What is known of a solid without evaluating it.

use crate::symmetry::Symmetry;
use argil_math::Aabb;
use glam::Vec3;

/// Facts about a distance that are known without evaluating it, in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// A box that contains the solid.
    pub aabb: Aabb,
    /// A factor u ≥ 1. At any point, the distance is at least the distance to the box divided by u.
    pub lipschitz_inverse: f32,
    /// The largest amount by which the distance outside underestimates the Euclidean distance. Infinite if it is
    /// unknown.
    pub max_underestimate: f32,
    /// A radius around the y axis within which the solid is.
    pub radius: f32,
    /// The mirror symmetry of the distance.
    pub(crate) symmetry: Symmetry,
}

/// Returns the radius around the y axis of a box.
pub(crate) fn radius_of(aabb: Aabb) -> f32 {
    if aabb.is_empty() {
        return 0.0;
    }
    let far = aabb.min.abs().max(aabb.max.abs());
    far.x.hypot(far.z)
}

impl Extent {
    /// The extent of an empty solid.
    pub const EMPTY: Self = Self {
        aabb: Aabb::EMPTY,
        lipschitz_inverse: 1.0,
        max_underestimate: 0.0,
        radius: 0.0,
        symmetry: Symmetry::NONE,
    };

    /// Returns the extent of an unknown solid with an exact distance in a box.
    pub(crate) fn within(aabb: Aabb) -> Self {
        Self {
            aabb,
            radius: radius_of(aabb),
            ..Self::EMPTY
        }
    }
}

/// Returns the box of all points as high as a region that are no farther from the y axis than a radius.
pub(crate) fn around_y(radius: f32, region: Aabb) -> Aabb {
    Aabb::new(
        Vec3::new(-radius, region.min.y, -radius),
        Vec3::new(radius, region.max.y, radius),
    )
}
