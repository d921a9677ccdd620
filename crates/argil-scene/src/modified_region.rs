//! What a modifier does to a box, and to the steepness of a distance.

use crate::clamp::stretch_of_turn;
use crate::extent::{Extent, around_y};
use crate::modifier::NOISE_LIPSCHITZ;
use crate::shape_checks::endless;
use crate::{Curve, Modifier};
use argil_math::Aabb;
use glam::{Vec2, Vec3};

/// Returns the factor by which a modifier's distance must shrink to keep the Lipschitz constant of its content,
/// given the content's extent.
pub(crate) fn stretch(modifier: &Modifier, content: &Extent) -> f32 {
    match *modifier {
        // Each octave halves the amplitude and doubles the frequency, so it adds the same slope.
        Modifier::Displace {
            amplitude,
            frequency,
            octaves,
            ..
        } => 1.0 + amplitude * frequency * NOISE_LIPSCHITZ * octaves as f32,
        Modifier::Shift { by, ref along } => along.shift_stretch(by),
        Modifier::Wrap {
            from,
            to,
            radius,
            ref curve,
        } => {
            let [low, high] = curve.slopes();
            let turn = low.abs().max(high.abs()) * (to - from).abs();
            let nearest = WRAP_TRUSTED * wrap_core(radius, content.aabb);
            (turn / (std::f32::consts::TAU * nearest)).max(1.0)
        }
        _ => modifier
            .clamp(content)
            .map_or(1.0, |clamp| stretch_of_turn(modifier, &clamp)),
    }
}

/// The share of the radius of [`wrap_core`] down to which the distances around a wrapped solid are used.
pub const WRAP_TRUSTED: f32 = 0.75;

/// Returns the radius around the axis within which a wrapped solid is cut off, given the content's box: a little less
/// than where it begins, or a small part of the radius if it reaches the axis.
pub fn wrap_core(radius: f32, content: Aabb) -> f32 {
    let begin = radius + content.min.z;
    let margin = 0.05 * radius.min(content.size().z);
    (begin - margin).max(radius / 32.0)
}

/// Copies of a wrapped solid, side by side along its x axis, before it is wrapped. They continue it where the turn ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrapCopies {
    /// The distance between two copies: how far the turn moves along x. It is 0 if the turn ends where it begins.
    pub spacing: f32,
    /// Copies on each side of the solid that points evaluate.
    pub sides: u32,
    /// The distance of other copies along x from a point where the turn ends, if it is positive.
    pub gap: f32,
}

/// More copies than this on each side of a wrapped solid are not evaluated.
const MAX_WRAP_SIDES: u32 = 12;

/// Returns the copies of a wrapped solid that points evaluate, given the content's box.
pub fn wrap_copies([from, to]: [f32; 2], curve: &Curve, content: Aabb) -> WrapCopies {
    let [start, end] = [0.0, 1.0].map(|t| from + (to - from) * curve.value(t) as f32);
    let (low, high) = (start.min(end), start.max(end));
    let spacing = high - low;
    let reach = (low - content.min.x).max(content.max.x - high);
    // A little farther than the solid, so that the other copies are apart from points of the turn.
    let sides = (reach + 0.05 * spacing) / spacing;
    let sides = if sides.is_finite() {
        sides.ceil().clamp(1.0, MAX_WRAP_SIDES as f32)
    } else {
        1.0
    };
    WrapCopies {
        spacing,
        sides: sides as u32,
        gap: if spacing > 0.0 {
            sides * spacing - reach
        } else {
            f32::INFINITY
        },
    }
}

/// Returns a box around all points that a modifier maps into `region`, which is in the frame of `content`.
pub(crate) fn region_after(modifier: &Modifier, region: Aabb, content: &Extent) -> Aabb {
    if region.is_empty() {
        return region;
    }
    if let Some(content_from_outer) = modifier.affine() {
        return region.mapped(&content_from_outer.inverse());
    }
    let mut after = region;
    match *modifier {
        Modifier::Mirror { axes } => {
            for axis in (0..3).filter(|&a| axes[a]) {
                after.max[axis] = region.max[axis].max(0.0);
                after.min[axis] = -after.max[axis];
            }
        }
        Modifier::Repeat { spacing, count } => {
            for axis in 0..3 {
                let reach = match count {
                    Some(count) => 0.5 * count[axis].saturating_sub(1) as f32 * spacing[axis],
                    None if spacing[axis] > 0.0 => f32::INFINITY,
                    None => 0.0,
                };
                after.min[axis] -= reach;
                after.max[axis] += reach;
            }
        }
        Modifier::Instances { ref poses } => {
            let boxes = poses
                .iter()
                .map(|pose| region.mapped(&pose.own_from_outer().inverse()));
            after = boxes.fold(Aabb::EMPTY, Aabb::union);
        }
        Modifier::RadialRepeat { .. } => {
            let far = region.min.abs().max(region.max.abs());
            let r = Vec2::new(far.x, far.z).length();
            after = around_y(r, region);
        }
        Modifier::Elongate { by } => {
            after = Aabb::new(region.min - Vec3::from(by), region.max + Vec3::from(by));
        }
        Modifier::Shift { by, ref along } => {
            let at = |share: f32| {
                let moved = share * Vec3::from(by);
                Aabb::new(region.min + moved, region.max + moved)
            };
            let [low, high] = along.curve().range();
            after = at(low).union(at(high));
        }
        Modifier::Wrap { radius, .. } => {
            let r = (radius + region.max.z).max(0.0);
            after = around_y(r, region);
        }
        Modifier::Extrude { half_depth } => {
            (after.min.z, after.max.z) = (-half_depth, half_depth);
            after = endless(after);
        }
        Modifier::Revolve { offset } => {
            let r = (region.max.x + offset).max(0.0);
            after = around_y(r, region);
        }
        Modifier::Twist { .. } | Modifier::Bend { .. } => {
            let clamp_bounds =
                |of: &Extent| modifier.clamp(of).map_or(Aabb::ALL, |clamp| clamp.aabb);
            after = clamp_bounds(&Extent::within(region)).intersection(clamp_bounds(content));
        }
        _ => {}
    }
    after
}

impl Modifier {
    /// Returns the factor by which the distance must shrink: see the function `stretch`.
    pub fn stretch(&self, content: &Extent) -> f32 {
        stretch(self, content)
    }
}
