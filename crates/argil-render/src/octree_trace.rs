//! Primary rays through a volume, one at a time. `resolve_hits.wgsl` is the twin of the shared part.

use crate::camera::{bounds_of, primary_ray};
use crate::tile::Tile;
use crate::trace::{intersect_ground, set_clip_normal};
use argil_abi::{self as abi, FrameUniform, Hit};
use argil_math::Ray;
use glam::Vec3;

/// A volume that rays can march through.
pub(crate) trait TraceVolume: Sync {
    /// Marches a ray from `near` to `far`. Returns what it hits, without a normal unless the hit is a brick's side.
    fn march(&self, frame: &FrameUniform, ray: Ray, near: f32, far: f32) -> Hit;

    /// Returns the stored distance at a point.
    fn distance(&self, point: Vec3) -> f32;
}

/// One step of a ray near the surface. `walk_step` in `volume.wgsl` is the twin.
pub(crate) struct SurfaceStep {
    pub t: f32,
    /// 1 outside, −1 inside, 0 before the first sample.
    pub side: f32,
    /// Where the ray began.
    near: f32,
}

impl SurfaceStep {
    pub(crate) fn from(near: f32) -> Self {
        Self {
            t: near,
            side: 0.0,
            near,
        }
    }

    /// Advances by a stored distance. Returns the gap, and whether the surface is reached.
    #[inline(always)]
    pub(crate) fn step(&mut self, frame: &FrameUniform, d: f32, is_last: bool) -> (f32, bool) {
        let is_first = self.side == 0.0;
        if is_first {
            self.side = if d < 0.0 && self.near <= 0.0 {
                -1.0
            } else {
                1.0
            };
        }
        // A ray that enters the volume through a clipped solid hits there.
        let gap = if is_first && self.side > 0.0 && d < 0.0 {
            0.0
        } else {
            d * self.side
        };
        let reached = gap < frame.epsilon || (is_last && gap < frame.pixel_width * self.t);
        self.t += gap * frame.inv_lipschitz;
        (gap, reached)
    }

    pub(crate) fn kind(&self) -> u32 {
        if self.side < 0.0 {
            abi::HIT_INSIDE
        } else {
            abi::HIT_OUTSIDE
        }
    }
}

/// Traces the primary ray of each pixel of a tile through a volume into `out`, row by row.
pub(crate) fn trace_volume(
    frame: &FrameUniform,
    tile: Tile,
    volume: &impl TraceVolume,
    out: &mut [Hit],
) {
    let bounds = bounds_of(frame);
    for (i, hit) in out.iter_mut().enumerate().take(tile.area()) {
        let (x, y) = tile.pixel(i);
        let ray = primary_ray(frame, x, y);
        *hit = match ray.span(bounds) {
            Some((near, far)) => volume.march(frame, ray, near, far),
            None => Hit::default(),
        };
        if hit.kind != abi::HIT_NONE && hit.id == 0 {
            let [x, y, z] = normal(frame, ray, hit, volume).to_array();
            hit.normal_t = [x, y, z, hit.normal_t[3]];
            set_clip_normal(frame, ray, hit);
        }
    }
    intersect_ground(frame, tile, out);
}

/// Returns the normal by central differences, toward the ray's side. If all six are equal, it is toward the viewer.
fn normal(frame: &FrameUniform, ray: Ray, hit: &Hit, volume: &impl TraceVolume) -> Vec3 {
    let p = ray.at(hit.normal_t[3]);
    let bias = frame.normal_bias;
    let side = if hit.kind == abi::HIT_INSIDE {
        -1.0
    } else {
        1.0
    };
    let difference =
        |axis: Vec3| (volume.distance(p + axis * bias) - volume.distance(p - axis * bias)) * side;
    let (x, y, z) = (
        difference(Vec3::X),
        difference(Vec3::Y),
        difference(Vec3::Z),
    );
    let length = (x * x + y * y + z * z).sqrt();
    if length > 0.0 {
        let scale = 1.0 / length;
        Vec3::new(x * scale, y * scale, z * scale)
    } else {
        -ray.direction
    }
}
