//! A grid of parts over unbounded space, in which operands are entered by their boxes.

use argil_math::Aabb;
use argil_scene::{Extent, Operator, blend_influence_radius};
use glam::{IVec3, Vec3};

/// Maximum parts of a level for one operand. A larger one goes to a level whose parts are four times as long.
const MAX_PARTS: f32 = 512.0;
/// Levels of parts. Larger operands are everywhere.
pub(crate) const LEVELS: u32 = 12;

/// A grid of cubic parts over unbounded space, each with a program of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartGrid {
    /// The minimum corner of part 0.
    pub corner: Vec3,
    /// The edge of a part.
    pub edge: f32,
    /// The distance below which a part's program gives the scene's distances.
    pub far: f32,
    /// The typical size of the world: see [`Program::clearance_model_in`](crate::Program::clearance_model_in).
    pub base: f32,
}

/// A part of a level.
pub(crate) type Part = (u32, IVec3);

impl PartGrid {
    /// Returns the part that contains a point.
    pub fn part_of(&self, point: Vec3) -> IVec3 {
        ((point - self.corner) / self.edge).floor().as_ivec3()
    }

    /// Returns the box in which a piece can matter, unless it matters everywhere. `joints` are the operators of the
    /// groups that contain it, outermost first, and its own. Values can fall by `falls[0]` through joints of the
    /// root, and by `falls[1]` through those of each group.
    pub(crate) fn reached_by<'a>(
        &self,
        joints: impl Iterator<Item = &'a Operator>,
        extent: &Extent,
        falls: [f32; 2],
    ) -> Aabb {
        let mut interest = self.far;
        for (joint, depth) in joints.zip(0..) {
            interest += falls[usize::min(depth, 1)];
            interest += blend_influence_radius(joint, interest);
        }
        extent
            .aabb
            .grown(1.000_1 * extent.lipschitz_inverse * interest)
    }

    /// Returns the level on which a box is in few parts, with its first and last part. Returns `None` if there is
    /// none.
    pub(crate) fn level_of(&self, held: Aabb) -> Option<(u32, IVec3, IVec3)> {
        let mut edge = self.edge;
        for level in 0..LEVELS {
            let first = ((held.min - self.corner) / edge).floor();
            let last = ((held.max - self.corner) / edge).floor();
            let count = last - first + 1.0;
            if count.element_product() <= MAX_PARTS {
                let is_near = first.abs().max(last.abs()).max_element() < 1e9;
                return is_near.then(|| (level, first.as_ivec3(), last.as_ivec3()));
            }
            edge *= 4.0;
        }
        None
    }
}

/// Iterates over all parts of a level from one to another.
pub(crate) fn parts_between(
    (level, first, last): (u32, IVec3, IVec3),
) -> impl Iterator<Item = Part> {
    (first.z..=last.z).flat_map(move |z| {
        (first.y..=last.y)
            .flat_map(move |y| (first.x..=last.x).map(move |x| (level, IVec3::new(x, y, z))))
    })
}
