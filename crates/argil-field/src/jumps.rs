//! What is known about pieces whose distances can jump, or are steep.

use argil_math::Aabb;
use glam::Vec3;

/// A piece whose distances can jump, or change by more than the length along which they change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JumpRegion {
    /// Outside this box, its jumps and its slope change no sign.
    pub aabb: Aabb,
    pub slack: f32,
    pub hidden: f32,
    pub isolation: f32,
    /// The Lipschitz constant in the box.
    pub lipschitz: f32,
}

impl JumpRegion {
    /// Returns all of it as bits, to compare it with others.
    pub(crate) fn bits(&self) -> [u32; 10] {
        let Self { aabb, .. } = self;
        let [a, b, c] = aabb.min.to_array();
        let [d, e, f] = aabb.max.to_array();
        let [slack, hidden, isolation] = [self.slack, self.hidden, self.isolation];
        [a, b, c, d, e, f, slack, hidden, isolation, self.lipschitz].map(f32::to_bits)
    }

    /// Returns the box from such bits.
    pub(crate) fn box_of(bits: &[u32; 10]) -> Aabb {
        let coordinates = bits.map(f32::from_bits);
        Aabb::new(
            Vec3::from_slice(&coordinates[..3]),
            Vec3::from_slice(&coordinates[3..6]),
        )
    }
}

/// What jumps and slopes can do in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearJumps {
    /// The distance of the nearest operand that can jump: 0 if one touches the box, and [`f32::MAX`] if all are too
    /// far away to matter.
    pub gap: f32,
    /// The largest jump of the distance.
    pub slack: f32,
    /// The additional jump where no surface is within `isolation`.
    pub hidden: f32,
    /// A copy that a point does not evaluate is at least this far away.
    pub isolation: f32,
    /// A bound on how fast the distance changes per unit of length.
    pub lipschitz: f32,
}

impl NearJumps {
    /// No jumps, and the slope of a Euclidean distance.
    pub const NONE: Self = Self {
        gap: f32::MAX,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::MAX,
        lipschitz: 1.0,
    };
}
