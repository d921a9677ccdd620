//! Bounds of distances over boxes.

use crate::domain_ops::{RADIAL_WORDS, REPEAT_WORDS};
use crate::{NearJumps, Program};
use argil_abi::{self as abi, Instruction};
use argil_math::{Aabb, Interval};

impl Program {
    /// Returns an interval that contains the distance of every point in a finite box: the value at the center, plus
    /// and minus the Lipschitz constant times half of the diagonal.
    ///
    /// It also accounts for the rounding of `f32`, and for the jumps of repeated solids, which are at most the
    /// amount by which their distance underestimates the Euclidean one.
    ///
    /// ```
    /// use argil_field::Program;
    /// use argil_math::Aabb;
    /// use argil_scene::{Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.push(Shape::sphere(1.0))?;
    /// let program = Program::lower(&scene)?;
    /// let far = program.bounds(Aabb::new([2.0; 3].into(), [3.0; 3].into()));
    /// assert!(far.is_positive());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "interval arithmetic")]
    pub fn bounds(&self, region: Aabb) -> Interval {
        let center = region.center();
        let value = self.distance(center);
        let radius = self.lipschitz * region.half_diagonal();
        Interval::around(value, radius * 1.000_01 + self.bound_error(region))
    }

    /// Returns what [`Program::bounds`] adds to the Lipschitz constant's share, for any box in the region.
    pub fn bound_error(&self, region: Aabb) -> f32 {
        self.slack + self.hidden_slack + self.rounding(region)
    }

    /// Returns a distance. If the distance at a point of the region is larger, no surface lies within `length` of
    /// the point.
    pub fn distance_threshold(&self, length: f32, region: Aabb) -> f32 {
        let hidden = if length < self.isolation {
            0.0
        } else {
            self.hidden_slack
        };
        1.000_01 * self.lipschitz * length + self.slack + hidden + self.rounding(region)
    }

    /// Returns the model of how far around a point of the region no surface lies, given its distance.
    pub fn clearance_model(&self, region: Aabb) -> ClearanceModel {
        ClearanceModel {
            slack: self.slack + self.rounding(region),
            hidden: self.hidden_slack,
            isolation: self.isolation,
            steepness: 1.000_01 * self.lipschitz,
        }
    }

    /// Returns what `f32` arithmetic can add to distances near the surface, for coordinates up to `max_coordinate`, in a
    /// world of typical size `typical_size`.
    pub fn rounding_at(&self, typical_size: f32, max_coordinate: f32) -> f32 {
        self.clearance_model_in(typical_size)
            .at(typical_size, max_coordinate)
            .slack
    }

    /// Returns the [`Program::clearance_model`] for points near the origin and the surface, where nothing jumps, in
    /// a world of typical size `typical_size`. See [`ClearanceModel::at`] for other points, and [`ClearanceModel::with`]
    /// for jumps.
    pub fn clearance_model_in(&self, typical_size: f32) -> ClearanceModel {
        ClearanceModel {
            slack: self.rounding_about(typical_size, typical_size),
            hidden: 0.0,
            isolation: f32::MAX,
            steepness: 1.000_01 * self.lipschitz,
        }
    }

    /// Returns the largest jump of distances from a list of instructions.
    pub fn jump_of(&self, instructions: &[Instruction]) -> f32 {
        if self.slack + self.hidden_slack == 0.0 {
            return 0.0;
        }
        let jumps = instructions.iter().map(|instr| match instr.op {
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

    /// Returns the error of a list's distances: jumps, and the rounding of `f32` for coordinates up to `max_coordinate`.
    pub(crate) fn list_slack(&self, instructions: &[Instruction], max_coordinate: f32) -> f32 {
        self.jump_of(instructions) + self.rounding_about(max_coordinate, max_coordinate)
    }

    /// Returns the error that `f32` arithmetic can add to a distance in the box.
    pub fn rounding(&self, region: Aabb) -> f32 {
        let max_coordinate = region.min.abs().max(region.max.abs()).max_element();
        self.rounding_about(max_coordinate, max_coordinate)
    }

    fn rounding_about(&self, max_coordinate: f32, typical_size: f32) -> f32 {
        // Operands no larger than a few base lengths change nothing, so editing them does not affect other
        // places.
        let magnitude = if self.magnitude > 4.0 * typical_size {
            self.magnitude
        } else {
            typical_size
        };
        64.0 * f32::EPSILON * (max_coordinate + 2.0 * magnitude)
    }
}

/// A lower bound of the distance from a point to the surface. `plain_radius` in `bricks/build.wgsl` of argil-volume is the twin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceModel {
    /// The error of a distance.
    pub slack: f32,
    /// The additional error at points from which no surface is within `isolation`.
    pub hidden: f32,
    /// A copy that a point does not evaluate is at least this far away.
    pub isolation: f32,
    /// The Lipschitz constant, with room for rounding.
    pub steepness: f32,
}

/// The relative error of a coordinate after an affine map into an operand's space: the rounding of its products and
/// sums.
const PLACE_ROUNDING: f32 = 4.0 * f32::EPSILON;

impl ClearanceModel {
    /// Returns the model for coordinates up to `max_coordinate`, from [`Program::clearance_model_in`]. Far from the
    /// origin, only the map into a nearby operand's space is less precise.
    #[inline]
    pub fn at(self, typical_size: f32, max_coordinate: f32) -> Self {
        let beyond = if max_coordinate > typical_size {
            max_coordinate - typical_size
        } else {
            0.0
        };
        Self {
            slack: self.slack + PLACE_ROUNDING * beyond,
            ..self
        }
    }

    /// Returns the model where something jumps.
    #[inline]
    pub fn with(self, jumps: &NearJumps) -> Self {
        Self {
            slack: self.slack + jumps.slack,
            hidden: jumps.hidden,
            isolation: jumps.isolation,
            ..self
        }
    }

    /// Returns the radius around a point of distance `d` without a surface.
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
