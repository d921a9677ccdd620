//! Bounds of the distance over boxes.

use crate::Program;
use argil_math::{Aabb, Interval};

impl Program {
    /// An interval that holds the distance of every point of a finite box: the value at its centre, plus and minus the
    /// Lipschitz constant times half of the diagonal.
    ///
    /// Added to that are what copies can leave out (the field of repeated solids can jump where the nearest copies
    /// change, by as much as their own distance falls short of the Euclidean one) and the rounding of `f32`.
    pub fn bounds(&self, region: Aabb) -> Interval {
        let center = region.center();
        let value = self.distance(center);
        let radius = self.lipschitz * region.half_diagonal();
        Interval::around(value, radius * 1.000_01 + self.bounds_slack(region))
    }

    /// What [`Program::bounds`] adds to the Lipschitz constant's share, for any box within the region.
    pub fn bounds_slack(&self, region: Aabb) -> f32 {
        self.slack + self.rounding(region)
    }

    /// How far `f32` arithmetic can take a distance within the box from the real one.
    fn rounding(&self, region: Aabb) -> f32 {
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        let sizes = if self.aabb.is_finite() {
            self.aabb.size().max_element()
        } else {
            1.0
        };
        64.0 * f32::EPSILON * (farthest + sizes)
    }
}
