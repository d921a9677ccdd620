//! What is known of pieces whose distances can jump.

use argil_math::Aabb;
use glam::Vec3;

/// A piece whose distances can jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JumpRegion {
    /// Outside of this box its jumps change no sign.
    pub aabb: Aabb,
    pub slack: f32,
    pub hidden: f32,
    pub isolation: f32,
}

impl JumpRegion {
    /// All of it, to be told from others.
    pub(crate) fn bits(&self) -> [u32; 9] {
        let Self { aabb, .. } = self;
        let [a, b, c] = aabb.min.to_array();
        let [d, e, f] = aabb.max.to_array();
        [a, b, c, d, e, f, self.slack, self.hidden, self.isolation].map(f32::to_bits)
    }

    /// The box of the one that has such bits.
    pub(crate) fn box_of(bits: &[u32; 9]) -> Aabb {
        let own = bits.map(f32::from_bits);
        Aabb::new(Vec3::from_slice(&own[..3]), Vec3::from_slice(&own[3..6]))
    }
}

/// What jumps can do in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearJumps {
    /// How far away the nearest of the operands is that can jump: 0 if one touches the box, and [`f32::MAX`] if all are too far
    /// away to matter.
    pub gap: f32,
    /// By how much the distance can jump.
    pub slack: f32,
    /// By how much more it can jump where the surface is not within `isolation`.
    pub hidden: f32,
    /// A copy that a point does not look at is at least so far away.
    pub isolation: f32,
}

impl NearJumps {
    /// There are none.
    pub const NONE: Self = Self {
        gap: f32::MAX,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::MAX,
    };
}
