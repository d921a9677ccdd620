//! Tests measures of depths, surfaces and stored distances with known answers.

use argil_metrics::surface::{SurfaceDistance, sample_surface};
use argil_metrics::{ErrorStats, depth};
use glam::Vec3;

/// Returns triangles of a sphere: a cube's faces, divided and projected.
fn sphere(radius: f32, cuts: usize) -> Vec<[Vec3; 3]> {
    let mut all = Vec::new();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let at = |i: usize, j: usize| {
            let [u, v] = [i, j].map(|k| 2.0 * k as f32 / cuts as f32 - 1.0);
            let mut p = Vec3::ZERO;
            p[axis] = sign;
            p[(axis + 1) % 3] = u * sign;
            p[(axis + 2) % 3] = v;
            radius * p.normalize()
        };
        for i in 0..cuts {
            for j in 0..cuts {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                all.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    all
}

#[test]
fn spheres_are_as_far_apart_as_their_radii() {
    let (small, large) = (sphere(1.0, 40), sphere(1.25, 40));
    let (small, large) = (sample_surface(&small, 5000), sample_surface(&large, 5000));
    assert_eq!(small.len(), 5000);
    let apart = SurfaceDistance::of(
        (&small, &|p: Vec3| p.length() - 1.0),
        (&large, &|p: Vec3| p.length() - 1.25),
    );
    assert!((apart.hausdorff() - 0.25).abs() < 0.002, "{apart:?}");
    assert!((apart.chamfer() - 0.5).abs() < 0.004, "{apart:?}");
    // One that is shifted: the greatest distance is the shift, the mean about half of it.
    let shift = Vec3::X * 0.1;
    let apart = SurfaceDistance::of(
        (&small, &|p: Vec3| p.length() - 1.0),
        (
            &small.iter().map(|&p| p + shift).collect::<Vec<_>>(),
            &|p: Vec3| (p - shift).length() - 1.0,
        ),
    );
    assert!((apart.hausdorff() - 0.1).abs() < 0.002, "{apart:?}");
    assert!((apart.chamfer() - 0.1).abs() < 0.004, "{apart:?}");
}

/// Sample points are uniform: each octant has the same number, and their mean is the center of the sphere.
#[test]
fn points_are_spread_by_area() {
    let points = sample_surface(&sphere(1.0, 30), 8000);
    let mut counts = [0; 8];
    for p in &points {
        let bits = [p.x, p.y, p.z].map(|c| usize::from(c > 0.0));
        counts[bits[0] + 2 * bits[1] + 4 * bits[2]] += 1;
    }
    assert!(counts.iter().all(|c| (960..1040).contains(c)), "{counts:?}");
    let middle = points.iter().sum::<Vec3>() / 8000.0;
    assert!(middle.length() < 0.01, "{middle}");
    // Triangles of very different sizes.
    let wide = [
        [Vec3::ZERO, Vec3::X, Vec3::Y],
        [Vec3::Z, Vec3::Z + 3.0 * Vec3::X, Vec3::Z + 3.0 * Vec3::Y],
    ];
    let low = sample_surface(&wide, 1000)
        .iter()
        .filter(|p| p.z == 0.0)
        .count();
    assert!((95..105).contains(&low), "{low}");
    assert!(sample_surface(&[[Vec3::X; 3]], 10).is_empty() && sample_surface(&[], 10).is_empty());
}

#[test]
fn depths_and_silhouettes() {
    let none = f32::INFINITY;
    let found = depth::compare(
        &[1.0, 2.0, none, 3.0, none],
        &[1.5, 1.0, 4.0, f32::NAN, none],
    );
    assert_eq!((found.missed, found.added, found.both.count), (1, 1, 2));
    assert_eq!((found.both.mean, found.both.max), (0.75, 1.0));
    assert!((found.both.rms - (0.625f64).sqrt()).abs() < 1e-12);
}

#[test]
fn errors_count_within_the_band() {
    let found = ErrorStats::within_band(&[0.1, -0.9, 1.0, 0.5], &[0.2, -0.9, 0.4, 2.0], 1.0);
    assert_eq!(found.count, 2);
    assert!((found.max - 0.1).abs() < 1e-6);
    // A number that is none is no agreement.
    assert_eq!(ErrorStats::of([0.0, f64::NAN]).max, f64::INFINITY);
    assert_eq!(ErrorStats::of([]), ErrorStats::default());
}
