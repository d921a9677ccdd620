//! Where the sky's light comes from. `bent.wgsl` is the twin.
//!
//! *Theory.* Cones around the normal and five directions around that see the sky as far as distances along them allow. The mean of
//! their directions is the bent normal: from there most light comes (Landis, "Production-ready global illumination", 2002).
//!
//! *Practice.* Directions turn around the normal from pixel to pixel, so that gaps between them become noise.

use super::haze::noise;
use super::light_source::LightSource;
use super::sky::{TAPS, reach_at, tap_height};
use crate::ray_batch::Points;
use crate::surfaces::Surfaces;
use argil_abi::FrameUniform;
use glam::Vec3;
use std::f32::consts::TAU;

/// Directions besides the normal.
const AROUND: usize = 5;
/// The cosine of their angle to the normal, and its sine.
const COSINE: f32 = 0.5;
const SINE: f32 = 0.866_025_4;
/// Lengths along a direction, as shares of the reach.
const PLACES: [f32; 2] = [0.3, 1.0];
/// The sine of a cone's half angle.
const WIDTH: f32 = 0.5;

/// Returns a direction of a normal's cones, and how much it counts. `turn` is from 0 to 1.
fn cone(n: Vec3, index: usize, turn: f32) -> (Vec3, f32) {
    if index == AROUND {
        return (n, 1.0);
    }
    let (x, y) = n.any_orthonormal_pair();
    let (sine, cosine) = (TAU * (index as f32 + turn) / AROUND as f32).sin_cos();
    (COSINE * n + SINE * (cosine * x + sine * y), COSINE)
}

/// Computes bent normals, and the visible share of the sky.
pub(super) fn gather(
    frame: &FrameUniform,
    surfaces: &Surfaces,
    source: &mut LightSource<'_, '_>,
    points: &mut Points,
    (sky, bent): (&mut [f32], &mut [Vec<f32>; 3]),
) {
    let count = surfaces.len();
    bent.iter_mut().for_each(|lanes| lanes.clear());
    bent.iter_mut().for_each(|lanes| lanes.resize(count, 0.0));
    let mut sums = vec![(Vec3::ZERO, 0.0); count];
    let far = source.far();
    for index in 0..=AROUND {
        let mut seen = vec![1.0f32; count];
        for share in PLACES {
            points.clear();
            let height = |i: usize| {
                let reach = tap_height(reach_at(frame, surfaces.length[i]), TAPS - 1);
                (share * reach).max(1e-20)
            };
            for i in 0..count {
                let (direction, _) =
                    cone(surfaces.normal(i), index, noise(surfaces.image_place(i)));
                points.push(surfaces.point(i) + height(i) * direction);
            }
            source.measure(points);
            for (i, (seen, &d)) in seen.iter_mut().zip(&points.d).enumerate() {
                let mut d = if d < far { d } else { f32::INFINITY };
                if frame.has_ground != 0 {
                    let (direction, _) =
                        cone(surfaces.normal(i), index, noise(surfaces.image_place(i)));
                    let above = surfaces.point(i) + height(i) * direction;
                    d = d.min(above.y - frame.ground_y);
                }
                *seen = seen.min((d / (WIDTH * height(i))).clamp(0.0, 1.0));
            }
        }
        for (i, (sum, seen)) in sums.iter_mut().zip(seen).enumerate() {
            let (direction, weight) =
                cone(surfaces.normal(i), index, noise(surfaces.image_place(i)));
            sum.0 += weight * seen * direction;
            sum.1 += weight * seen;
        }
    }
    let whole = 1.0 + AROUND as f32 * COSINE;
    for (i, (sum, open)) in sums.into_iter().enumerate() {
        sky[i] = open / whole;
        let bent_normal = sum.try_normalize().unwrap_or(surfaces.normal(i));
        (bent[0][i], bent[1][i], bent[2][i]) = bent_normal.into();
    }
}
