//! Flat patches of surfaces, which share cones to lamps.

use super::lamp_shape::LampShape;
use super::light_source::LightSource;
use super::shadow_rays::ShadowRay;
use crate::surfaces::Surfaces;
use argil_abi::FrameUniform;
use glam::Vec3;
use std::ops::Range;

/// How far surfaces that share a cone may be from their plane, relative to their radius.
const FLAT: f32 = 0.1;
/// Surfaces that share a cone.
const MIN_SHARED: usize = 4;

/// Surfaces that share cones.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Its surfaces, in a list of them.
    pub members: Range<usize>,
    pub center: Vec3,
    pub normal: Vec3,
    pub radius: f32,
    /// How far surfaces are from the plane.
    spread: f32,
    lift: f32,
    min_step: f32,
}

impl Patch {
    pub(super) fn is_flat(&self) -> bool {
        self.members.len() >= MIN_SHARED && self.spread <= FLAT * self.radius
    }

    /// Creates a cone to a part of a lamp.
    pub(super) fn ray(&self, lamp: &LampShape, target: Vec3, radius: f32) -> ShadowRay {
        let surface = (self.center, self.normal);
        let heights = [self.lift, self.spread];
        ShadowRay::new(
            lamp,
            surface,
            heights,
            target,
            [self.radius, radius],
            self.min_step,
        )
    }
}

/// Returns the patch of some surfaces of a list.
pub(super) fn patch_of(
    frame: &FrameUniform,
    surfaces: &Surfaces,
    source: &LightSource<'_, '_>,
    list: &[u32],
    members: Range<usize>,
) -> Option<Patch> {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (mut normal, mut length) = (Vec3::ZERO, f32::INFINITY);
    let indices = list
        .get(members.clone())
        .filter(|indices| !indices.is_empty())?;
    for &i in indices {
        let p = surfaces.point(i as usize);
        (low, high) = (low.min(p), high.max(p));
        normal += surfaces.normal(i as usize);
        length = length.min(surfaces.length[i as usize]);
    }
    let (center, radius) = (0.5 * (low + high), 0.500_1 * low.distance(high));
    let mean = normal / indices.len() as f32;
    let is_even = mean.length_squared() > 0.95;
    let normal = mean.normalize_or(Vec3::Y);
    let away = |&i: &u32| (surfaces.point(i as usize) - center).dot(normal).abs();
    let spread = indices.iter().map(away).fold(0.0, f32::max);
    Some(Patch {
        members,
        center,
        normal,
        radius,
        spread: if is_even { spread } else { f32::INFINITY },
        lift: source.lift(frame).at(length),
        min_step: source.min_step(frame).at(length),
    })
}
