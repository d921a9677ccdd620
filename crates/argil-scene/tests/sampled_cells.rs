//! Distances of many cells in one call.

use argil_math::Aabb;
use argil_scene::{DistanceSampler, SampledGrid};
use glam::{Vec2, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A torus around z, with two radii along its way, so that cells of all kinds are needed.
struct Torus {
    cells_at_once: usize,
    calls: AtomicUsize,
}

impl DistanceSampler for Torus {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        assert!(!points.is_empty(), "a call for nothing");
        self.calls.fetch_add(1, Ordering::Relaxed);
        for (p, d) in points.iter().zip(out) {
            let around = Vec2::new(p.x.hypot(p.y) - 0.6, p.z).length();
            *d = around - if p.x > 0.0 { 0.2 } else { 0.1 };
        }
    }

    fn cells_at_once(&self) -> usize {
        self.cells_at_once
    }
}

/// The samples are the same, however many cells are asked for at once, and the calls are fewer.
#[test]
fn many_cells_at_once_have_the_samples_of_single_ones() {
    let sample = |cells_at_once| {
        let torus = Torus {
            cells_at_once,
            calls: AtomicUsize::new(0),
        };
        let solid = Aabb::new(Vec3::splat(-0.8), Vec3::splat(0.8));
        let grid = SampledGrid::sample_around(solid, 1.6 / 48.0, &torus);
        (grid, torus.calls.into_inner())
    };
    let (single, calls) = sample(1);
    assert!(single.has_inside() && calls > 1000, "{calls} calls");
    assert!(sample(0).0 == single, "no cells at once differ");
    for cells_at_once in [7, 256, usize::MAX] {
        let (many, fewer) = sample(cells_at_once);
        assert!(many == single, "{cells_at_once} cells at once differ");
        assert!(fewer < calls / 2, "{fewer} calls, {calls} for single cells");
    }
}
