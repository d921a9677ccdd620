//! Finds modifiers that make copies, all in one place.
//!
//! *Practice.* Boxes tell for almost all modifiers that copies lie apart. For the others, the content is lowered by
//! itself, and its distances are compared with those of its copies.

use crate::Program;
use argil_math::Aabb;
use argil_scene::{Extent, Extents, Modifier, NodeId, Pose, Scene};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::TAU;
use std::fmt;

/// A modifier that makes copies, all in one place.
#[derive(Clone, Debug, PartialEq)]
pub struct CoincidingCopies {
    /// The node with the modifier.
    pub node: NodeId,
    /// The node's name, which may be empty.
    pub name: String,
    /// The modifier's path in the scene's file.
    pub path: String,
    /// The reason why the copies coincide.
    pub reason: &'static str,
}

impl fmt::Display for CoincidingCopies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.path)?;
        if !self.name.is_empty() {
            write!(f, " (\"{}\")", self.name)?;
        }
        write!(f, ": all copies are in one place: {}", self.reason)
    }
}

/// Copies that lie apart by less than this share of the content's size coincide.
const TOLERANCE: f64 = 1e-4;
/// Points at which a copy's distances are compared, maximum copies that are compared, and maximum modifiers.
const POINTS: usize = 64;
const MAX_COPIES: usize = 16;
const MAX_COMPARED: usize = 256;
/// Maximum modifiers that are returned.
const MAX_FOUND: usize = 8;

const APART: &str = "they are less than a ten-thousandth of its size apart: increase \"spacing\"";
const NO_SPACING: &str = "its \"spacing\" is 0: increase it";
const ROUND: &str = "the solid is the same after a rotation about the y axis: move it away from there first, with a \"translate\" before this";
const SAME_POSES: &str = "its poses are the same: move them apart";

impl CoincidingCopies {
    /// Returns the visible modifiers of a scene whose copies all coincide, up to eight.
    ///
    /// ```
    /// use argil_field::CoincidingCopies;
    /// use argil_scene::{Brush, Modifier, Scene, Shape};
    /// let mut scene = Scene::new();
    /// let ring = Modifier::RadialRepeat { count: 6 };
    /// scene.push(Brush::new(Shape::sphere(0.2)).with_modifier(ring))?;
    /// let found = CoincidingCopies::of(&scene);
    /// assert_eq!(found[0].path, "brushes[0].modifiers[0]");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(scene: &Scene) -> Vec<Self> {
        let mut extents = Extents::of(scene);
        let mut found = Vec::new();
        let mut compared = 0;
        for node in scene.iter() {
            let entry = scene.node(node).at_current_time();
            if !entry.visible || !entry.modifiers.iter().any(makes_copies) {
                continue;
            }
            let stages = extents.modifier_stages(node);
            for (index, (modifier, content)) in entry.modifiers.iter().zip(&stages).enumerate() {
                let Some((copies, reason)) = near_copies(modifier, content) else {
                    continue;
                };
                compared += 1;
                if found.len() == MAX_FOUND || compared > MAX_COMPARED {
                    return found;
                }
                let solid = || Program::lower_stages(scene, node, index).ok();
                if copies.is_empty()
                    || solid().is_some_and(|solid| are_equal(&solid, content.aabb, &copies))
                {
                    found.push(Self {
                        node,
                        name: entry.name.clone(),
                        path: format!("{}.modifiers[{index}]", scene.path(node)),
                        reason,
                    });
                }
            }
        }
        found
    }
}

fn makes_copies(modifier: &Modifier) -> bool {
    matches!(
        modifier,
        Modifier::Repeat { .. } | Modifier::RadialRepeat { .. } | Modifier::Instances { .. }
    )
}

/// Returns the maps from the first copy to some others, if their boxes may coincide. There are none if nothing has to be
/// compared.
fn near_copies(modifier: &Modifier, content: &Extent) -> Option<(Vec<DAffine3>, &'static str)> {
    let bounds = content.aabb;
    if bounds.is_empty() {
        return None;
    }
    match *modifier {
        Modifier::Repeat {
            spacing,
            count: None,
        } if spacing == [0.0; 3] => Some((Vec::new(), NO_SPACING)),
        Modifier::Repeat { spacing, count } => {
            let steps = |axis: usize| match count {
                Some(count) => f64::from(count[axis] - 1),
                None => f64::from(u8::from(spacing[axis] > 0.0)),
            };
            let whole = DVec3::from([0, 1, 2].map(|axis| steps(axis) * f64::from(spacing[axis])));
            let is_near = |axis: usize| {
                let size = f64::from(bounds.size()[axis]);
                whole[axis] <= TOLERANCE * size || size == f64::INFINITY
            };
            let is_repeated = whole != DVec3::ZERO;
            (is_repeated && (0..3).all(is_near))
                .then(|| (vec![DAffine3::from_translation(whole)], APART))
        }
        Modifier::RadialRepeat { count } => {
            let has_axis = [0, 2]
                .iter()
                .all(|&axis| bounds.min[axis] <= 0.0 && bounds.max[axis] >= 0.0);
            let step = DAffine3::from_rotation_y(TAU / f64::from(count));
            (count > 1 && has_axis).then(|| (vec![step], ROUND))
        }
        Modifier::Instances { ref poses } => {
            let first = poses.first()?;
            let size = f64::from(bounds.size().max_element() * first.scale);
            let is_near = |pose: &Pose| {
                let away = Vec3::from(pose.position).distance(Vec3::from(first.position));
                f64::from(away) <= TOLERANCE * size
                    && f64::from((pose.scale - first.scale).abs())
                        <= TOLERANCE * f64::from(first.scale)
            };
            if poses.len() < 2 || !poses.iter().all(is_near) {
                return None;
            }
            let own_from_first = first.own_from_outer();
            let map = |pose: &Pose| own_from_first * pose.own_from_outer().inverse();
            // Equal poses need no comparison, and others are alike.
            let mut turned: Vec<&Pose> =
                poses[1..].iter().filter(|other| *other != first).collect();
            turned.dedup();
            turned.truncate(MAX_COPIES);
            Some((turned.into_iter().map(map).collect(), SAME_POSES))
        }
        _ => None,
    }
}

/// Whether a solid's distances are the same after each of some maps, at points in its box.
fn are_equal(solid: &Program, bounds: Aabb, copies: &[DAffine3]) -> bool {
    let sides = bounds.size().to_array().into_iter();
    let size = sides.filter(|side| side.is_finite()).fold(0.0, f32::max);
    let size = if size > 0.0 { size } else { 1.0 };
    let [low, high] = [bounds.min, bounds.max]
        .map(|corner| corner.clamp(Vec3::splat(-1e3 * size), Vec3::splat(1e3 * size)));
    // Points along all axes, without a pattern (Roberts 2018).
    let point = |i: usize| {
        let t = (i as f32 + 1.0) * Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
        low + t.fract() * (high - low)
    };
    let is_equal = |at: Vec3, map: &DAffine3| {
        let moved = map.transform_point3(at.as_dvec3()).as_vec3();
        let difference = solid.distance(at) - solid.distance(moved);
        f64::from(difference.abs()) <= 2.0 * TOLERANCE * f64::from(size)
    };
    copies
        .iter()
        .all(|map| (0..POINTS).all(|i| is_equal(point(i), map)))
}
