//! Scenes of each shape.

use crate::case::{SceneCase, one};
use argil_math::Aabb;
use argil_scene::{Brush, LoadedGrid, Path2, PathSegment, SampledGrid, Shape};
use glam::Vec3;
use std::sync::{Arc, LazyLock};

/// Returns a closed outline of lines and curves that is neither convex nor monotone.
pub fn vase() -> Path2 {
    let line = |to| PathSegment { control: None, to };
    let curve = |control, to| PathSegment {
        control: Some(control),
        to,
    };
    Path2 {
        start: [0.0, -0.6],
        segments: vec![
            line([0.35, -0.6]),
            curve([0.85, -0.2], [0.3, 0.25]),
            curve([0.15, 0.45], [0.45, 0.7]),
            line([0.3, 0.7]),
            curve([0.05, 0.4], [0.0, 0.35]),
        ],
    }
}

/// Returns a sampled ring with a gap, like a sampled mesh.
pub fn sampled() -> Shape {
    static GRID: LazyLock<Arc<SampledGrid>> = LazyLock::new(|| Arc::new(sampled_ring()));
    Shape::Mesh {
        path: "cut ring.obj".into(),
        resolution: 48,
        grid: LoadedGrid(Some(GRID.clone())),
    }
}

fn sampled_ring() -> SampledGrid {
    let measure = |points: &[Vec3], out: &mut [f32]| {
        for (p, out) in points.iter().zip(out) {
            let ring = glam::vec2(glam::vec2(p.x, p.z).length() - 0.5, p.y).length() - 0.2;
            *out = ring.max(p.x + 0.2 * p.y - 0.3);
        }
    };
    let solid = Aabb::new(Vec3::new(-0.7, -0.2, -0.7), Vec3::new(0.36, 0.2, 0.7));
    let cells = glam::uvec3(5, 3, 6);
    SampledGrid::sample(Vec3::new(-0.8, -0.4, -0.8), 0.27, cells, solid, &measure)
}

/// Returns ground with a step, a slope and a bump.
pub fn heights() -> Shape {
    let height = |i: u32, k: u32| match (i, k) {
        (0..3, _) => 0.2,
        (_, 5..) => 0.9 - 0.1 * i as f32,
        _ => 0.3 + 0.07 * ((3 * i + 5 * k) % 4) as f32,
    };
    let all: Vec<f32> = (0..63).map(|i| height(i % 9, i / 9)).collect();
    let grid = SampledGrid::from_heights([9, 7], &all).expect("heights from 0 to 1");
    Shape::Heightmap {
        path: "ground.png".into(),
        half_size: [0.8, 0.6],
        height: 0.5,
        base: 0.15,
        resolution: 16,
        grid: LoadedGrid(Some(Arc::new(grid))),
    }
}

/// Returns one example of each shape in the table, and special cases.
pub fn shapes() -> Vec<(String, Shape)> {
    [examples(), special_shapes()].concat()
}

/// Returns one example of each shape.
fn examples() -> Vec<(String, Shape)> {
    let named = |shape: Shape| (format!("{shape:?}"), shape);
    Shape::examples().into_iter().map(named).collect()
}

fn special_shapes() -> Vec<(String, Shape)> {
    let half_size = [0.5, 0.35, 0.4];
    let special = [
        ("sharp box", Shape::cuboid(half_size)),
        (
            "capsule of length 0",
            Shape::capsule([0.1; 3], [0.1; 3], 0.2),
        ),
        (
            "pointed capped cone",
            Shape::CappedCone {
                half_height: 0.5,
                bottom_radius: 0.0,
                top_radius: 0.4,
            },
        ),
        (
            "leaning plane",
            Shape::Plane {
                normal: [1.0, 2.0, -0.5],
                offset: 0.2,
            },
        ),
        (
            "flat pyramid",
            Shape::Pyramid {
                base: 1.2,
                height: 0.2,
            },
        ),
        (
            "cut sphere below",
            Shape::CutSphere {
                radius: 0.6,
                cut: -0.25,
            },
        ),
        (
            "cut hollow sphere below",
            Shape::CutHollowSphere {
                radius: 0.6,
                cut: -0.3,
                half_thickness: 0.05,
            },
        ),
        (
            "wide solid angle",
            Shape::SolidAngle {
                radius: 0.7,
                half_angle_degrees: 130.0,
            },
        ),
        (
            "rounder rims than edges",
            Shape::ExtrudedRoundedBox {
                half_size,
                corner_radii: [0.1, 0.3, 0.0, 0.2],
                rounding: [0.1, 0.05],
            },
        ),
        ("vase", Shape::Lathe { outline: vase() }),
        ("mesh", sampled()),
        ("heightmap", heights()),
    ];
    let named = |(name, shape): (&str, Shape)| (name.to_owned(), shape);
    special.into_iter().map(named).collect()
}

/// Returns each shape, transformed, and one of each without a transform.
pub fn shape_cases() -> Vec<SceneCase> {
    let placed = |(name, shape): (String, Shape)| {
        one(
            &name,
            Brush::new(shape)
                .rotated([0.3, 1.0, 0.2], 25.0)
                .at([0.1, -0.05, 0.07]),
        )
    };
    // Level cameras see a level plane edge-on: where rays end there is undefined.
    let is_plane = |shape: &Shape| matches!(shape, Shape::Plane { .. });
    let upright = examples().into_iter().filter(|(_, shape)| !is_plane(shape));
    shapes()
        .into_iter()
        .map(placed)
        .chain(upright.map(|(n, s)| one(&n, Brush::new(s))))
        .collect()
}
