//! Lamps: lights besides the sun. `lamps.wgsl` is the twin.
//!
//! *Theory.* A surface receives the light of a sphere's middle, and of all of a rectangle. Its shadow is as soft as the lamp looks wide from there: a ray's
//! share is the smallest ratio of distance to way, times the distance of the lamp over its radius (after Quilez, "Soft shadows in
//! raymarched SDFs", 2010).

use super::frame_fog::passed;
use super::light_source::LightSource;
use super::lobes::{mix, reflected_from};
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::{self as abi, FrameUniform, GpuMaterial};
use argil_math::Ray;
use glam::Vec3;

/// Reciprocals of the tangents of the widest and the narrowest penumbra's half angle.
const SHARPNESS: [f32; 2] = [3.0, 200.0];
/// At this share, a ray ends as shadowed.
const DARK: f32 = 0.005;

/// A lamp, as seen from a point.
pub(super) struct LampLight {
    pub direction: Vec3,
    pub distance: f32,
    /// What a surface receives that faces it.
    pub light: Vec3,
    /// Of its shadow.
    pub sharpness: f32,
}

/// Returns what a lamp brings to a point, from its four rows.
pub(super) fn lamp_at(rows: &[[f32; 4]], p: Vec3) -> LampLight {
    let xyz = |row: usize| Vec3::from_slice(&rows[row]);
    let soft = |sharpness: f32| sharpness.clamp(SHARPNESS[0], SHARPNESS[1]);
    let kind = rows[0][3] as u32;
    if kind == abi::LIGHT_SUN {
        let rim = rows[2][0];
        let sine = (1.0 - rim * rim).max(1e-12).sqrt();
        return LampLight {
            direction: xyz(0),
            distance: f32::MAX,
            light: xyz(1),
            sharpness: soft(rim / sine),
        };
    }
    let to = xyz(0) - p;
    let square = to.length_squared().max(1e-12);
    let distance = square.sqrt();
    let direction = to / distance;
    if kind == abi::LIGHT_SPHERE {
        let radius = rows[1][3];
        let share = cone_share(rows, -direction);
        return LampLight {
            direction,
            distance,
            light: xyz(1) * (share / square.max(radius * radius)),
            sharpness: soft(distance / radius.max(1e-6)),
        };
    }
    let flow = rectangle_flow(rows, to);
    let size = flow.length();
    LampLight {
        direction: if size > 0.0 { flow / size } else { direction },
        distance,
        light: xyz(1) * size,
        sharpness: soft(distance / (0.5 * (rows[2][3] + rows[3][3])).max(1e-6)),
    }
}

/// Returns the direction from which a rectangle shines on average, times what a surface receives that faces it, for a radiance of 1: a sum
/// over its sides (Lambert 1760). `to` leads to its center.
fn rectangle_flow(rows: &[[f32; 4]], to: Vec3) -> Vec3 {
    let [width, height] = [2, 3].map(|row: usize| Vec3::from_slice(&rows[row]) * rows[row][3]);
    if to.dot(width.cross(height)) >= 0.0 {
        return Vec3::ZERO;
    }
    let corners = [
        to - width - height,
        to - width + height,
        to + width + height,
        to + width - height,
    ]
    .map(Vec3::normalize_or_zero);
    let mut sum = Vec3::ZERO;
    for nth in 0..4 {
        let (a, b) = (corners[nth], corners[(nth + 1) % 4]);
        let across = a.cross(b);
        let sine = across.length();
        // Narrow sides are as long as their angle.
        let ratio = if sine > 1e-4 {
            sine.atan2(a.dot(b)) / sine
        } else {
            1.0
        };
        sum += 0.5 * ratio * across;
    }
    sum
}

/// Returns where a lamp's shadow begins that is seen from a surface: above it, but not beyond the lamp.
fn shadow_start(p: Vec3, n: Vec3, lift: f32, lamp: &LampLight) -> Vec3 {
    p + n * lift.min(0.05 * lamp.distance)
}

/// Returns the share of a sphere's light that its cone lets through.
fn cone_share(rows: &[[f32; 4]], away: Vec3) -> f32 {
    let (side, full) = (rows[2][3], rows[3][0]);
    let cosine = away.dot(Vec3::from_slice(&rows[2]));
    if cosine >= full {
        return 1.0;
    }
    let t = ((cosine - side) / (full - side).max(1e-6)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A ray to a lamp.
#[derive(Clone, Copy, Debug)]
struct LampRay {
    id: u32,
    origin: Vec3,
    direction: Vec3,
    t: f32,
    end: f32,
    share: f32,
    sharpness: f32,
    min_step: f32,
}

/// Rays to lamps that march together.
#[derive(Debug, Default)]
pub(super) struct LampRays {
    rays: Vec<LampRay>,
    /// The share of each ray, by its id.
    pub shares: Vec<f32>,
}

impl LampRays {
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.shares.clear();
    }

    /// Adds a ray, whose id is the number of those before. What leaves the solids' box is lit.
    pub(super) fn push(
        &mut self,
        frame: &FrameUniform,
        origin: Vec3,
        lamp: &LampLight,
        min_step: f32,
    ) {
        let id = self.shares.len() as u32;
        self.shares.push(1.0);
        let ray = Ray {
            origin,
            direction: lamp.direction,
        };
        let Some((near, far)) = ray.span(bounds_of(frame)) else {
            return;
        };
        let end = far.min(lamp.distance);
        if near < end {
            self.rays.push(LampRay {
                id,
                origin,
                direction: lamp.direction,
                t: near,
                end,
                share: 1.0,
                sharpness: lamp.sharpness,
                min_step,
            });
        }
    }

    /// Leaves a place for a ray that is not needed.
    pub(super) fn skip(&mut self) {
        self.shares.push(0.0);
    }

    /// Marches all rays, and fills in their shares.
    pub(super) fn march(
        &mut self,
        frame: &FrameUniform,
        source: &mut LightSource<'_, '_>,
        points: &mut Points,
    ) {
        let (batch, far) = (source.batch(), source.far());
        for _ in 0..abi::LAMP_STEPS {
            if self.rays.is_empty() {
                break;
            }
            for rays in self.rays.chunks_mut(batch) {
                points.clear();
                for ray in rays.iter() {
                    points.push(ray.origin + ray.t * ray.direction);
                }
                source.measure(points);
                for (ray, &d) in rays.iter_mut().zip(&points.d) {
                    let own = if d < far {
                        (ray.sharpness * d / ray.t.max(frame.epsilon)).clamp(0.0, 1.0)
                    } else {
                        1.0
                    };
                    ray.share = ray.share.min(own);
                    ray.t += (d * frame.inv_lipschitz).max(ray.min_step);
                    if own <= DARK {
                        ray.end = -1.0;
                    }
                }
            }
            let shares = &mut self.shares;
            self.rays.retain(|ray| {
                shares[ray.id as usize] = smooth(ray.share);
                ray.t < ray.end
            });
        }
    }
}

fn smooth(share: f32) -> f32 {
    share * share * (3.0 - 2.0 * share)
}

/// Adds what surfaces reflect of all lamps.
pub(super) fn gather(
    frame: &FrameUniform,
    (surfaces, materials): (&Surfaces, &[GpuMaterial]),
    source: &mut LightSource<'_, '_>,
    points: &mut Points,
    rays: &mut LampRays,
    out: &mut Vec<Vec3>,
) {
    out.clear();
    out.resize(surfaces.len(), Vec3::ZERO);
    let (lift, step) = (source.lift(frame), source.min_step(frame));
    for rows in frame.lamps.chunks(4).take(frame.lamp_count as usize) {
        rays.clear();
        for i in 0..surfaces.len() {
            let (p, n, length) = (surfaces.point(i), surfaces.normal(i), surfaces.length[i]);
            let lamp = lamp_at(rows, p);
            let origin = shadow_start(p, n, lift.at(length), &lamp);
            if n.dot(lamp.direction) > 0.0 && lamp.light.max_element() > 0.0 {
                rays.push(frame, origin, &lamp, step.at(length));
            } else {
                rays.skip();
            }
        }
        rays.march(frame, source, points);
        for (i, &share) in rays
            .shares
            .iter()
            .enumerate()
            .filter(|(_, share)| **share > 0.0)
        {
            let n = surfaces.normal(i);
            let p = surfaces.point(i);
            let lamp = lamp_at(rows, p);
            let [r, g, b, roughness] = materials[i].base_roughness;
            let (base, metallic) = (Vec3::new(r, g, b), materials[i].emission_metallic[3]);
            let body = base * (1.0 - metallic);
            let mirror = mix(Vec3::splat(0.04), base, metallic);
            let view = -surfaces.ray(i);
            let reflected = reflected_from(n, view, lamp.direction, (body, mirror, roughness));
            let clear = passed(frame, p, lamp.direction, lamp.distance);
            out[i] += reflected * lamp.light * (share * clear);
        }
    }
}
