//! A grid of parts over space, without bounds: where operands are entered by their boxes.

use argil_math::Aabb;
use argil_scene::{Extent, Operator, blend_influence_radius};
use glam::{IVec3, Vec3};

/// Most parts of a level that an operand is entered in; a larger one goes to a level whose parts are four times as long.
const MAX_PARTS: f32 = 512.0;
/// Levels of parts. What is larger still is everywhere.
pub(crate) const LEVELS: u32 = 12;

/// Where lists are asked for: a grid of cubic parts, without bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartGrid {
    /// The least corner of part 0.
    pub corner: Vec3,
    /// The edge of a part.
    pub edge: f32,
    /// The distance below which lists give the scene's.
    pub far: f32,
    /// The usual length of the world, see [`Program::clearance_model_in`](crate::Program::clearance_model_in).
    pub base: f32,
}

/// A part of a level.
pub(crate) type Part = (u32, IVec3);

impl PartGrid {
    /// The part that a point is in.
    pub fn part_of(&self, point: Vec3) -> IVec3 {
        ((point - self.corner) / self.edge).floor().as_ivec3()
    }

    /// The box in which a piece can matter where it is not everywhere that others do. `joints` are the operators of the groups that
    /// it is in, the outermost first, and its own. Values can fall by the first of `falls` through joints of the root, and by the
    /// second through those of each group.
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

    /// The level at which a box is in few parts, with the first and the last of them; nothing where there is none.
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

/// All parts of a level from one to another.
pub(crate) fn parts_between(
    (level, first, last): (u32, IVec3, IVec3),
) -> impl Iterator<Item = Part> {
    (first.z..=last.z).flat_map(move |z| {
        (first.y..=last.y)
            .flat_map(move |y| (first.x..=last.x).map(move |x| (level, IVec3::new(x, y, z))))
    })
}
