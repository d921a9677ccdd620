//! Rays through a dense volume; `dense.wgsl` is the twin.
//!
//! *Theory.* Without mips every step is at most the band. With them a ray reads the level on which the distance is
//! within the band: it climbs where a sample saturates and goes down again where the next finer level could tell as
//! much. Levels above the finest never overstate the distance, so steps by them need no test; the surface is met on
//! the finest alone.

use crate::volume::{Marched, Walk};
use argil_abi::{Frame, HIT_NONE, Hit};
use argil_math::Ray;
use argil_volume::{Dense, Sampler, Texel};
use glam::Vec3;

/// A sample of at least this share of the band is saturated.
const SATURATED: f32 = 0.99;
/// Below this share of the band, the level beneath, of half the band, tells the distance more closely.
const NEAR: f32 = 0.28;

pub(crate) struct DenseRays<'a, T> {
    levels: Vec<Sampler<'a, T>>,
    /// The length of 1.0 on the finest level.
    range: f32,
}

impl<'a, T: Texel> DenseRays<'a, T> {
    /// `None` if the texels are not of this type.
    pub fn new(dense: &'a Dense) -> Option<Self> {
        let levels = dense.samplers();
        (levels.len() == dense.levels().len()).then(|| Self {
            levels,
            range: dense.encoding().range_length(dense.lattice(), 0),
        })
    }
}

impl<T: Texel> Marched for DenseRays<'_, T> {
    #[inline]
    fn march(&self, frame: &Frame, ray: Ray, near: f32, far: f32) -> Hit {
        let top = self.levels.len() - 1;
        let mut walk = Walk::from(near);
        let mut level = 0;
        let mut kind = HIT_NONE;
        let mut steps = 0;
        while steps < frame.max_steps {
            steps += 1;
            let d = self.levels[level].distance(ray.at(walk.t));
            let range = self.range * (1u32 << level) as f32;
            if level == 0 {
                let (gap, reached) = walk.step(frame, d, steps == frame.max_steps);
                if reached {
                    kind = walk.kind();
                    break;
                }
                if gap >= SATURATED * range {
                    // How far the surface is when a ray begins is not known at all.
                    level = if steps == 1 { top } else { top.min(1) };
                }
            } else {
                let gap = if d > 0.0 { d } else { 0.0 };
                walk.t += gap * frame.eye_step[3];
                if gap >= SATURATED * range {
                    level = top.min(level + 1);
                } else {
                    let mut range = range;
                    while level > 0 && gap < NEAR * range {
                        level -= 1;
                        range *= 0.5;
                    }
                }
            }
            if walk.t > far {
                break;
            }
        }
        Hit {
            normal_t: if kind == HIT_NONE {
                [0.0; 4]
            } else {
                [0.0, 0.0, 0.0, walk.t]
            },
            kind,
            steps,
            ..Hit::default()
        }
    }

    #[inline]
    fn distance(&self, point: Vec3) -> f32 {
        self.levels[0].distance(point)
    }
}
