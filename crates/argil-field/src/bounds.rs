//! Bounds of the distance over boxes.

use crate::space::{RADIAL_WORDS, REPEAT_WORDS};
use crate::{NearJumps, Program};
use argil_abi::{self as abi, Instruction};
use argil_math::{Aabb, Interval};

impl Program {
    /// An interval that holds the distance of every point of a finite box: the value at its center, plus and minus the
    /// Lipschitz constant times half of the diagonal.
    ///
    /// Added to that are what copies can leave out (the field of repeated solids can jump where the nearest copies
    /// change, by as much as their own distance falls short of the Euclidean one) and the rounding of `f32`.
    pub fn bounds(&self, region: Aabb) -> Interval {
        let center = region.center();
        let value = self.distance(center);
        let radius = self.lipschitz * region.half_diagonal();
        Interval::around(value, radius * 1.000_01 + self.bound_error(region))
    }

    /// What [`Program::bounds`] adds to the Lipschitz constant's share, for any box within the region.
    pub fn bound_error(&self, region: Aabb) -> f32 {
        self.slack + self.hidden_slack + self.rounding(region)
    }

    /// Beyond which distance at a point there is no surface within a length of it, for points of the region.
    pub fn distance_threshold(&self, length: f32, region: Aabb) -> f32 {
        let hidden = if length < self.isolation {
            0.0
        } else {
            self.hidden_slack
        };
        1.000_01 * self.lipschitz * length + self.slack + hidden + self.rounding(region)
    }

    /// How far around points of a region there is no surface, given the distance there.
    pub fn clearance_model(&self, region: Aabb) -> ClearanceModel {
        ClearanceModel {
            slack: self.slack + self.rounding(region),
            hidden: self.hidden_slack,
            isolation: self.isolation,
            steepness: 1.000_01 * self.lipschitz,
        }
    }

    /// What `f32` arithmetic can add to distances at points with coordinates as great as `farthest` that are near the surface, in
    /// a world where `base` is a usual length.
    pub fn rounding_at(&self, base: f32, farthest: f32) -> f32 {
        self.clearance_model_in(base).at(base, farthest).slack
    }

    /// [`Program::clearance_model`] for points near the origin and the surface where nothing jumps, in a world where `base` is a usual
    /// length: see [`ClearanceModel::at`] for other points, and [`ClearanceModel::with`] for places where something jumps.
    pub fn clearance_model_in(&self, base: f32) -> ClearanceModel {
        ClearanceModel {
            slack: self.rounding_about(base, base),
            hidden: 0.0,
            isolation: f32::MAX,
            steepness: 1.000_01 * self.lipschitz,
        }
    }

    /// What the distances that a list of instructions gives can jump by.
    pub fn jump_of(&self, instrs: &[Instruction]) -> f32 {
        if self.slack + self.hidden_slack == 0.0 {
            return 0.0;
        }
        let jumps = instrs.iter().map(|instr| match instr.op {
            abi::OP_REPEAT => self.params[instr.params as usize + REPEAT_WORDS - 1],
            abi::OP_RADIAL => self.params[instr.params as usize + RADIAL_WORDS - 1],
            _ => 0.0,
        });
        let jump = jumps.fold(0.0, f32::max);
        // Chamfered joints add jumps up.
        if jump > 0.0 && self.lipschitz > 1.0 {
            self.slack + self.hidden_slack
        } else {
            jump
        }
    }

    /// What a list's distances within the region can be off by: their jumps, and the rounding of `f32`.
    pub(crate) fn list_slack(&self, instrs: &[Instruction], region: Aabb) -> f32 {
        self.jump_of(instrs) + self.rounding(region)
    }

    /// How far `f32` arithmetic can take a distance within the box from the real one.
    pub fn rounding(&self, region: Aabb) -> f32 {
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        self.rounding_about(farthest, farthest)
    }

    fn rounding_about(&self, farthest: f32, base: f32) -> f32 {
        // Operands no larger than a few base lengths change nothing, so that edits of them do not change what is relied on
        // elsewhere.
        let magnitude = if self.magnitude > 4.0 * base {
            self.magnitude
        } else {
            base
        };
        64.0 * f32::EPSILON * (farthest + 2.0 * magnitude)
    }
}

/// What tells how far around a point there is no surface. `clear_radius` in `bricks/build.wgsl` of argil-volume is the twin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceModel {
    /// What a distance can be off by.
    pub slack: f32,
    /// What copies can add to that beyond the isolation.
    pub hidden: f32,
    /// A copy that a point does not look at is at least so far away.
    pub isolation: f32,
    /// The Lipschitz constant with room for rounding.
    pub steepness: f32,
}

/// What of a coordinate an affine map into an operand's own space can lose: the rounding of its products and sums.
const PLACE_ROUNDING: f32 = 4.0 * f32::EPSILON;

impl ClearanceModel {
    /// For points with coordinates as great as `farthest`, where those of [`Program::clearance_model_in`] a base length are
    /// known. Only mapping a point into the space of an operand near it loses more far from the origin: what comes after
    /// that is as near as anywhere.
    #[inline]
    pub fn at(self, base: f32, farthest: f32) -> Self {
        let beyond = if farthest > base {
            farthest - base
        } else {
            0.0
        };
        Self {
            slack: self.slack + PLACE_ROUNDING * beyond,
            ..self
        }
    }

    /// Where something jumps.
    #[inline]
    pub fn with(self, jumps: &NearJumps) -> Self {
        Self {
            slack: self.slack + jumps.slack,
            hidden: jumps.hidden,
            isolation: jumps.isolation,
            ..self
        }
    }

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
