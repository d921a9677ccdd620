//! Distances between surfaces.
//!
//! *Theory.* Points spread evenly over one surface are measured to the other, and the other way. The Hausdorff
//! distance is the maximum of all of them, and the chamfer distance is the sum of both means.

use crate::ErrorStats;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Samples points on triangles, evenly by area: `count` in all, from a low-discrepancy sequence (Roberts' R₃,
/// 2018), so that they are reproducible. Triangles without an area get none.
pub fn sample_surface(triangles: &[[Vec3; 3]], count: usize) -> Vec<Vec3> {
    let area = |[a, b, c]: &[Vec3; 3]| f64::from(0.5 * (*b - *a).cross(*c - *a).length());
    let mut ends = Vec::with_capacity(triangles.len());
    let mut total = 0.0;
    for triangle in triangles {
        total += area(triangle);
        ends.push(total);
    }
    if total <= 0.0 || !total.is_finite() {
        return Vec::new();
    }
    // The root of g⁴ = g + 1, the golden ratio's counterpart in three dimensions.
    const G: f64 = 1.220_744_084_605_759_5;
    let step = [1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G)];
    (0..count)
        .map(|i| {
            let [s, u, v] = step.map(|a| (0.5 + a * (i + 1) as f64).fract());
            let at = ends
                .partition_point(|&end| end <= s * total)
                .min(ends.len() - 1);
            let [a, b, c] = triangles[at];
            // Fold the square's other half over.
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            a + (b - a) * u as f32 + (c - a) * v as f32
        })
        .collect()
}

/// The distances between two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceDistance {
    /// From points of the first to the second.
    pub forward: ErrorStats,
    /// From points of the second to the first.
    pub backward: ErrorStats,
}

impl SurfaceDistance {
    /// Summarizes points of two surfaces, given functions that return the distance from a point to each surface.
    pub fn of(
        first: (&[Vec3], &dyn Fn(Vec3) -> f32),
        second: (&[Vec3], &dyn Fn(Vec3) -> f32),
    ) -> Self {
        let from = |points: &[Vec3], to: &dyn Fn(Vec3) -> f32| {
            ErrorStats::of(points.iter().map(|&p| f64::from(to(p))))
        };
        Self {
            forward: from(first.0, second.1),
            backward: from(second.0, first.1),
        }
    }

    /// Returns the Hausdorff distance.
    pub fn hausdorff(&self) -> f64 {
        self.forward.max.max(self.backward.max)
    }

    /// Returns the chamfer distance.
    pub fn chamfer(&self) -> f64 {
        self.forward.mean + self.backward.mean
    }
}
