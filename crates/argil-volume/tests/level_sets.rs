//! Level sets hold distances, at edges and corners too, where differences between samples tell no slope.

use argil_field::Program;
use argil_math::Control;
use argil_scene::{Brush, Modifier, Scene, Shape};
use argil_volume::{LevelSetBaker, LevelSetLayout, LevelSetLeaf};
use glam::{IVec3, Vec3};
use std::collections::BTreeSet;

/// Returns the leaves of a level set, and its layout.
fn level_set(
    brush: Brush,
    voxel_size: f32,
    is_corrected: bool,
) -> (Vec<LevelSetLeaf>, LevelSetLayout) {
    let mut scene = Scene::new();
    scene.push(brush).expect("a brush");
    let program = Program::lower(&scene).expect("a program");
    let layout = LevelSetLayout {
        voxel_size,
        half_width_voxels: 3.0,
        region: program.aabb(),
        is_cut: false,
        is_corrected,
    };
    let control = Control::default();
    let baker = LevelSetBaker::new(&program, layout, 4096, &control);
    let parts = baker.parts();
    let leaves = parts.flat_map(|part| baker.bake(part, false, &control));
    (leaves.collect(), layout)
}

/// Returns the largest error of every `step`th value in the band, in voxels.
fn error_of(
    (leaves, layout): &(Vec<LevelSetLeaf>, LevelSetLayout),
    step: usize,
    exact: impl Fn(Vec3) -> f32,
) -> f32 {
    let band = layout.half_width();
    let values = leaves.iter().flat_map(|leaf| {
        let origin = Vec3::from(leaf.origin.map(|c| c as f32));
        leaf.values.iter().enumerate().map(move |(i, &value)| {
            let inner = Vec3::from([i / 64, i / 8 % 8, i % 8].map(|c| c as f32));
            (layout.voxel_size * (origin + inner), value)
        })
    });
    let near = values.filter(|(_, value)| value.abs() < band);
    near.step_by(step)
        .map(|(p, value)| (value - exact(p)).abs() / layout.voxel_size)
        .fold(0.0, f32::max)
}

#[test]
fn distances_stay_exact_at_edges() {
    let half = Vec3::new(0.5, 0.4, 0.3);
    let of_box = |p: Vec3| {
        let way = p.abs() - half;
        way.max(Vec3::ZERO).length() + way.max_element().min(0.0)
    };
    let cuboid = level_set(Brush::new(Shape::cuboid(half.to_array())), 0.013, true);
    assert!(error_of(&cuboid, 1, of_box) < 1e-3);
    let of_cylinder = |p: Vec3| {
        let (x, y) = (p.x.hypot(p.z) - 0.3, p.y.abs() - 0.4);
        x.max(0.0).hypot(y.max(0.0)) + x.max(y).min(0.0)
    };
    let cylinder = level_set(Brush::new(Shape::cylinder(0.3, 0.4)), 0.013, true);
    assert!(error_of(&cylinder, 1, of_cylinder) < 1e-3);
}

/// A stretched sphere has bounds. The truth is the nearest of dense points of the surface.
#[test]
fn bounds_become_distances() {
    let radii = Vec3::new(0.6, 0.3, 0.3);
    let points: Vec<Vec3> = (0..100_000u32)
        .map(|i| {
            let z = (f64::from(i) + 0.5) / 50_000.0 - 1.0;
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            radii * Vec3::new((across * cos) as f32, (across * sin) as f32, z as f32)
        })
        .collect();
    let exact = |p: Vec3| {
        let inside = (p / radii).length() - 1.0;
        let nearest = points.iter().map(|q| q.distance_squared(p));
        nearest.fold(f32::MAX, f32::min).sqrt().copysign(inside)
    };
    let stretched = Brush::new(Shape::sphere(0.3)).with_modifier(Modifier::Stretch {
        by: [2.0, 1.0, 1.0],
    });
    assert!(error_of(&level_set(stretched.clone(), 0.013, true), 401, exact) < 0.2);
    assert!(error_of(&level_set(stretched, 0.013, false), 401, exact) > 0.5);
}

/// Signs are the field's, and no sample beside the surface lacks a leaf, however flat the field is.
#[test]
fn signs_are_those_of_the_field() {
    let brushes = [
        Brush::new(Shape::cuboid([0.06, 0.4, 0.2])).with_modifier(Modifier::Stretch {
            by: [10.0, 1.0, 1.0],
        }),
        Brush::new(Shape::Ellipsoid {
            radii: [0.5, 0.1, 0.5],
        }),
        Brush::new(Shape::cylinder(0.4, 0.1)).with_modifier(Modifier::Stretch {
            by: [1.0, 5.0, 1.0],
        }),
        Brush::new(Shape::cuboid([0.5, 0.4, 0.3])).with_modifier(Modifier::Twist {
            degrees_per_unit: 60.0,
        }),
    ];
    for (brush, voxel) in brushes
        .into_iter()
        .flat_map(|own| [0.02, 0.04].map(|voxel| (own.clone(), voxel)))
    {
        let mut scene = Scene::new();
        scene.push(brush.clone()).expect("a brush");
        let program = Program::lower(&scene).expect("a program");
        let (leaves, layout) = level_set(brush, voxel, true);
        let there: BTreeSet<[i32; 3]> = leaves.iter().map(|leaf| leaf.origin).collect();
        let field = |index: IVec3| program.distance(layout.voxel_size * index.as_vec3());
        for leaf in &leaves {
            for (i, &value) in leaf.values.iter().enumerate() {
                let inner = [i / 64, i / 8 % 8, i % 8].map(|c| c as i32);
                let index = IVec3::from(leaf.origin) + IVec3::from(inner);
                let right = field(index);
                assert!(
                    (value < 0.0) == (right < 0.0),
                    "{value} and {right} at {index}"
                );
            }
        }
        let [low, high] = [layout.region.min, layout.region.max];
        let low = (low / voxel).floor().as_ivec3() - 1;
        let size = (high / voxel).ceil().as_ivec3() + 2 - low;
        for i in 0..size.element_product() {
            let index = low + IVec3::new(i % size.x, i / size.x % size.y, i / size.x / size.y);
            let has_leaf = there.contains(&index.map(|c| c & -8).to_array());
            let is_beside = || {
                let own = field(index) < 0.0;
                let mut ways = IVec3::AXES.into_iter();
                ways.any(|way| (field(index + way) < 0.0) != own)
            };
            assert!(
                has_leaf || !is_beside(),
                "no leaf at {index}, voxel {voxel}"
            );
        }
    }
}
