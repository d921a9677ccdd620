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
        self.slack + self.hidden_slack + self.rounding(region)
    }

    /// Beyond which distance at a point there is no surface within a length of it, for points of the region.
    pub fn reach(&self, length: f32, region: Aabb) -> f32 {
        let hidden = if length < self.isolation {
            0.0
        } else {
            self.hidden_slack
        };
        1.000_01 * self.lipschitz * length + self.slack + hidden + self.rounding(region)
    }

    /// How far around points of a region there is no surface, given the distance there.
    pub fn clear_terms(&self, region: Aabb) -> ClearTerms {
        ClearTerms {
            slack: self.slack + self.rounding(region),
            hidden: self.hidden_slack,
            isolation: self.isolation,
            steepness: 1.000_01 * self.lipschitz,
        }
    }

    /// How far `f32` arithmetic can take a distance within the box from the real one.
    fn rounding(&self, region: Aabb) -> f32 {
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        // Operands about the region change nothing, so that edits of them do not change what is relied on elsewhere.
        let magnitude = if self.magnitude > 4.0 * farthest {
            self.magnitude
        } else {
            farthest
        };
        64.0 * f32::EPSILON * (farthest + 2.0 * magnitude)
    }
}

/// What tells how far around a point there is no surface. `clear_radius` in `bricks/build.wgsl` of argil-volume is the twin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearTerms {
    /// What a distance can be off by.
    pub slack: f32,
    /// What copies can add to that beyond the isolation.
    pub hidden: f32,
    /// A copy that a point does not look at is at least so far away.
    pub isolation: f32,
    /// The Lipschitz constant with room for rounding.
    pub steepness: f32,
}

impl ClearTerms {
    /// How far around a point of distance `d` there is no surface.
    #[inline]
    pub fn radius(&self, d: f32) -> f32 {
        let left = d.abs() - self.slack;
        let plain = left / self.steepness;
        if plain <= self.isolation {
            plain
        } else {
            self.isolation.max((left - self.hidden) / self.steepness)
        }
    }
}
