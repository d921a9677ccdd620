//! Pieces whose distances can jump, and where that matters.
//!
//! *Theory.* The field of repeated solids jumps where the nearest copies change. A jump of one [piece](crate::pieces) changes the
//! sign of the scene nowhere but near that piece: outside of its box its distance is positive, and at least the distance to the box
//! divided by its underestimate. A smooth joint of radius k leaves the sign alone where that is k or more. So what is said of
//! a place that is outside of the grown boxes of all loose pieces need not allow for their jumps.

use crate::Program;
use crate::jumps::{JumpRegion, NearJumps};
use crate::pieces::{PieceInfo, PieceWalk};
use crate::regularity::Regularity;
use argil_math::Aabb;
use argil_scene::{BlendProfile, Operator, OperatorKind, max_blend_propagation};
use glam::Vec3;

impl Program {
    /// What operands that jump can do in a box, of those that are less than `far` away.
    pub fn jumps_near(&self, region: Aabb, far: f32) -> NearJumps {
        let mut near = NearJumps::NONE;
        for own in &self.loose {
            let gap = (own.aabb.min - region.max).max(region.min - own.aabb.max);
            // NaN is taken for 0: of what is endless.
            let gap = gap.max(Vec3::ZERO).length();
            let gap = if gap.is_nan() { 0.0 } else { gap };
            if gap < far {
                near = NearJumps {
                    gap: near.gap.min(gap),
                    slack: near.slack.max(own.slack),
                    hidden: near.hidden.max(own.hidden),
                    isolation: near.isolation.min(own.isolation),
                };
            }
        }
        near
    }
}

/// The joints that come after a piece, up to the end of the list.
#[derive(Clone, Copy, Default)]
struct Later {
    /// By how much values can fall through the joints outside of the group.
    outside: f32,
    blends: f32,
    blend: f32,
    chamfered: bool,
    morphed: bool,
}

impl Later {
    fn add(&mut self, operator: &Operator) {
        self.morphed |= operator.kind == OperatorKind::Morph;
        self.chamfered |= operator.profile == BlendProfile::Chamfer && operator.blend > 0.0;
        self.blends += operator.blend;
        self.blend = self.blend.max(operator.blend);
    }

    fn falls(&self) -> f32 {
        let inside = if self.chamfered {
            max_blend_propagation(self.blend, true, 0.0)
        } else {
            self.blends
                .min(max_blend_propagation(self.blend, false, 0.0))
        };
        self.outside + inside
    }

    /// Of the last in a group.
    fn inside(&self) -> Self {
        Self {
            outside: self.falls(),
            blends: 0.0,
            blend: 0.0,
            ..*self
        }
    }
}

/// The loose ones of the visible pieces of a scene, which are told from the last to the first. `all` is how regular the whole is.
pub(crate) fn loose_of(
    last_first: impl Iterator<Item = PieceInfo>,
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
    all: Regularity,
) -> Vec<JumpRegion> {
    let mut loose = Vec::new();
    let mut walk = PieceWalk::default();
    let mut stack = vec![Later::default()];
    for own in last_first {
        walk.go_to(own.group, &parent_of, |group, enters| {
            if !enters {
                stack.pop();
            } else if let Some(outer) = stack.last_mut() {
                outer.add(&operator_of(group));
                let inside = outer.inside();
                stack.push(inside);
            }
        });
        if own.operator.kind == OperatorKind::Paint {
            // It changes no distance.
            continue;
        }
        let Some(later) = stack.last_mut() else {
            continue;
        };
        later.add(&own.operator);
        let Regularity { slack, hidden, .. } = own.regularity;
        if slack + hidden == 0.0 {
            continue;
        }
        let underestimate = own
            .regularity
            .underestimate
            .max(own.extent.lipschitz_inverse);
        let falls = later.falls();
        // What morphs is a mixture of all, wherever that is.
        let aabb = if later.morphed {
            Aabb::ALL
        } else {
            own.extent.aabb.grown(1.000_1 * underestimate * falls)
        };
        let settled = Regularity {
            blends: falls,
            blend: falls,
            ..own.regularity
        }
        .settled(own.extent.lipschitz_inverse);
        loose.push(if later.chamfered || later.morphed {
            // Jumps add up in joints.
            JumpRegion {
                aabb,
                slack: all.slack + all.hidden,
                hidden: 0.0,
                isolation: f32::MAX,
            }
        } else {
            JumpRegion {
                aabb,
                slack: settled.slack,
                hidden: settled.hidden,
                isolation: settled.isolation.min(f32::MAX),
            }
        });
    }
    loose
}
