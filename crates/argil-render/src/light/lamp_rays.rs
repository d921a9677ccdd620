//! Rays from places in fog to lights, which march together. `lamp_share` of `lamp_rays.wgsl` is the twin.
//!
//! *Theory.* A ray's share is the smallest ratio of distance to way, times the distance of the lamp over its radius (after Quilez,
//! "Soft shadows in raymarched SDFs", 2010).

use super::lamps::LampLight;
use super::light_source::LightSource;
use crate::camera::bounds_of;
use crate::ray_batch::Points;
use argil_abi::{self as abi, FrameUniform};
use argil_math::Ray;
use glam::Vec3;

/// At this share, a ray ends as shadowed.
const DARK: f32 = 0.005;

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
                    let open = if d < far {
                        (ray.sharpness * d / ray.t.max(frame.epsilon)).clamp(0.0, 1.0)
                    } else {
                        1.0
                    };
                    ray.share = ray.share.min(open);
                    ray.t += (d * frame.inv_lipschitz).max(ray.min_step);
                    if open <= DARK {
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
