//! Pieces whose distances can jump, and where that matters.
//!
//! *Theory.* The field of repeated solids jumps where the nearest copies change. A jump of one
//! [piece](crate::pieces) changes the scene's sign only near that piece. Outside its box its distance is positive,
//! and at least the distance to the box divided by its underestimate. A smooth joint of radius k keeps the sign if
//! that is at least k. So places outside the grown boxes of all such pieces need not account for their jumps.

use crate::Program;
use crate::jumps::{JumpRegion, NearJumps};
use crate::pieces::{MAX_OPEN_GROUPS, PieceInfo, PieceWalk, ROOT, chain};
use crate::regularity::Regularity;
use argil_math::Aabb;
use argil_scene::{BlendProfile, Operator, OperatorKind, max_blend_propagation};
use glam::Vec3;

impl Program {
    /// Returns what jumping and steep operands can do in a box, for those less than `far` away.
    pub fn jumps_near(&self, region: Aabb, far: f32) -> NearJumps {
        let mut near = NearJumps::NONE;
        for region_near in &self.loose {
            let gap = (region_near.aabb.min - region.max).max(region.min - region_near.aabb.max);
            // NaN, from infinite solids, counts as 0.
            let gap = gap.max(Vec3::ZERO).length();
            let gap = if gap.is_nan() { 0.0 } else { gap };
            if gap >= far {
                continue;
            }
            near.lipschitz = near.lipschitz.max(region_near.lipschitz);
            if region_near.slack + region_near.hidden > 0.0 {
                near = NearJumps {
                    gap: near.gap.min(gap),
                    slack: near.slack.max(region_near.slack),
                    hidden: near.hidden.max(region_near.hidden),
                    isolation: near.isolation.min(region_near.isolation),
                    ..near
                };
            }
        }
        near
    }
}

/// Steep pieces that have a box each. Among more of them, all of space is as steep as the steepest.
const MAX_STEEP: usize = 64;

/// Whether an operator joins by a chamfer.
fn is_chamfer(operator: &Operator) -> bool {
    operator.profile == BlendProfile::Chamfer && operator.blend > 0.0
}

/// The joints after a piece, up to the end of the list.
#[derive(Clone, Copy, Default)]
struct Later {
    /// How far values can fall through the joints outside the group.
    outside: f32,
    blends: f32,
    blend: f32,
    chamfered: bool,
    morphed: bool,
}

impl Later {
    fn add(&mut self, operator: &Operator) {
        self.morphed |= operator.kind == OperatorKind::Morph;
        self.chamfered |= is_chamfer(operator);
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

    /// Returns the joints after the last operand of a group.
    fn inside(&self) -> Self {
        Self {
            outside: self.falls(),
            blends: 0.0,
            blend: 0.0,
            ..*self
        }
    }
}

/// Returns a box that contains the solid of pieces. Joints move it outward by the sum of their offsets, but on each
/// level of groups by no more than the largest blend radius.
fn solid_of(
    pieces: &[PieceInfo],
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
) -> Aabb {
    let mut solid = Aabb::EMPTY;
    let (mut bulges, mut blend, mut levels) = (0.0, 0.0f32, 1);
    let (mut overshoot, mut underestimate) = (0.0, 1.0f32);
    let mut last = ROOT;
    for piece in pieces {
        let mut count = |operator: Operator| {
            bulges += operator.max_outward_offset();
            blend = blend.max(operator.blend);
        };
        count(piece.operator);
        if piece.group != last {
            last = piece.group;
            let mut groups = [ROOT; MAX_OPEN_GROUPS];
            let groups = chain(piece.group, &parent_of, &mut groups);
            groups.iter().for_each(|&group| count(operator_of(group)));
            levels = levels.max(1 + groups.len());
        }
        overshoot += piece.overshoot;
        underestimate = underestimate.max(piece.extent.lipschitz_inverse);
        if matches!(
            piece.operator.kind,
            OperatorKind::Union | OperatorKind::Morph
        ) {
            solid = solid.union(piece.extent.aabb);
        }
    }
    let outward = f32::min(bulges, levels as f32 * blend);
    solid.grown(outward + 1.000_1 * underestimate * overshoot)
}

/// Returns the jumping and the steep pieces among those of a scene, given in its order. `all` is the regularity of the whole scene.
pub(crate) fn loose_of(
    pieces: &[PieceInfo],
    parent_of: impl Fn(u32) -> u32,
    operator_of: impl Fn(u32) -> Operator,
    all: Regularity,
) -> Vec<JumpRegion> {
    if all.slack + all.hidden == 0.0 && all.lipschitz <= 1.0 {
        return Vec::new();
    }
    let solid = solid_of(pieces, &parent_of, &operator_of);
    let mut loose = Vec::new();
    let mut walk = PieceWalk::default();
    let mut stack = vec![Later::default()];
    for piece in pieces.iter().rev() {
        walk.go_to(piece.group, &parent_of, |group, enters| {
            if !enters {
                stack.pop();
            } else if let Some(outer) = stack.last_mut() {
                outer.add(&operator_of(group));
                let inside = outer.inside();
                stack.push(inside);
            }
        });
        if piece.operator.kind == OperatorKind::Paint {
            // It changes no distance.
            continue;
        }
        if let Some(later) = stack.last_mut() {
            later.add(&piece.operator);
            loose.extend(region_of(piece, later, all, solid));
        }
    }
    if loose.iter().filter(|jump| jump.lipschitz > 1.0).count() > MAX_STEEP {
        merge_steep(&mut loose, all.lipschitz);
    }
    loose
}

/// Returns where a piece's jumps and slope matter, if it has any. `later` are the joints from its own on.
fn region_of(piece: &PieceInfo, later: &Later, all: Regularity, solid: Aabb) -> Option<JumpRegion> {
    let Regularity { slack, hidden, .. } = piece.regularity;
    // Open groups are not joined by chamfers.
    let is_steep = is_chamfer(&piece.operator) || piece.regularity.lipschitz > 1.0;
    if slack + hidden == 0.0 && !is_steep {
        return None;
    }
    // Chamfers add slopes up.
    let lipschitz = match is_steep && (later.chamfered || later.morphed) {
        true => all.lipschitz,
        false => piece.regularity.lipschitz,
    };
    let underestimate = piece
        .regularity
        .underestimate
        .max(piece.extent.lipschitz_inverse);
    let falls = later.falls();
    // A morph mixes everything. Outside the whole solid's box, the distance is positive all the same.
    let reach = if later.morphed {
        Aabb::ALL
    } else {
        piece.extent.aabb.grown(1.000_1 * underestimate * falls)
    };
    let aabb = solid.intersection(reach);
    let plain = JumpRegion {
        aabb,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::MAX,
        lipschitz,
    };
    let region = if slack + hidden == 0.0 {
        plain
    } else if later.chamfered || later.morphed {
        // Jumps add up in joints.
        JumpRegion {
            slack: all.slack + all.hidden,
            ..plain
        }
    } else {
        let settled = Regularity {
            blends: falls,
            blend: falls,
            ..piece.regularity
        }
        .settled(piece.extent.lipschitz_inverse);
        JumpRegion {
            slack: settled.slack,
            hidden: settled.hidden,
            isolation: settled.isolation.min(f32::MAX),
            ..plain
        }
    };
    (!aabb.is_empty()).then_some(region)
}

/// Replaces the boxes of steep pieces by all of space, which does not depend on where each of them is.
fn merge_steep(loose: &mut Vec<JumpRegion>, lipschitz: f32) {
    loose.iter_mut().for_each(|jump| jump.lipschitz = 1.0);
    loose.retain(|jump| jump.slack + jump.hidden > 0.0);
    loose.push(JumpRegion {
        aabb: Aabb::ALL,
        slack: 0.0,
        hidden: 0.0,
        isolation: f32::MAX,
        lipschitz,
    });
}
