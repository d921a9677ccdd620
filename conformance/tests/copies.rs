//! Tests the proof that the copy in a point's own cell is the nearest one, and what both devices then evaluate.

use crate::field::measure;
use argil_conformance::Wait;
use argil_conformance::{CaseRng, all_cases, gpu_field, points, rounding, shapes};
use argil_field::{FAR, Program, naive};
use argil_scene::{
    Brush, Extent, Extents, Modifier, Scene, Shape, evaluated_copies, nearest_is_own,
};
use glam::Vec3;

/// Returns the largest amount by which a copy beside a point's own is nearer, in multiples of rounding. The scene is what is
/// repeated along an axis.
fn worst_neighbor(scene: &Scene, axis: usize, spacing: f32, size: Vec3) -> f64 {
    let mut numbers = CaseRng::new(11);
    let mut worst = f64::NEG_INFINITY;
    for _ in 0..40 {
        let mut p = numbers.point(1.0) * (1.5 * size + 0.2);
        // In the own cell, sometimes at its border.
        p[axis] = match numbers.between(0.0, 1.0) {
            share if share < 0.2 => 0.499 * spacing,
            _ => numbers.between(-0.5, 0.5) * spacing,
        };
        let d = naive::distance(scene, p);
        for copy in [-2.0, -1.0, 1.0, 2.0] {
            let mut q = p;
            q[axis] -= copy * spacing;
            let gain = d - naive::distance(scene, q);
            worst = worst.max(gain / f64::from(rounding(q.to_array())));
        }
    }
    worst
}

fn extent_of(scene: &Scene) -> Extent {
    Extents::of(scene).content_bounds(Scene::ROOT)
}

fn along(axis: usize, spacing: f32) -> Modifier {
    let mut all = [0.0; 3];
    all[axis] = spacing;
    Modifier::Repeat {
        spacing: all,
        count: None,
    }
}

/// Holds for every shape, modifier, operator, structure and random scene of the tables. Where nothing is proven, other copies are
/// nearer often enough, so the comparison can fail.
#[test]
fn proven_copies_are_the_nearest() {
    let (mut proven, mut not_nearest) = (0, 0);
    for case in all_cases() {
        let content = extent_of(&case.scene);
        if !content.aabb.is_finite() || content.aabb.is_empty() {
            continue;
        }
        let size = content.aabb.min.abs().max(content.aabb.max.abs());
        for axis in 0..3 {
            for factor in [0.7, 2.0, 2.6] {
                let spacing = factor * size[axis];
                let is_own = nearest_is_own(&along(axis, spacing), &content)[axis];
                // Few points tell where nothing is claimed.
                if !is_own && factor > 1.0 {
                    continue;
                }
                let worst = worst_neighbor(&case.scene, axis, spacing, size);
                if is_own {
                    proven += 1;
                    let name = &case.name;
                    assert!(
                        worst <= 1.0,
                        "{name}, axis {axis}, spacing {spacing}: a neighbor is nearer by {worst} times the bound"
                    );
                } else {
                    not_nearest += usize::from(worst > 10.0);
                }
            }
        }
    }
    assert!(proven > 120, "only {proven} copies are proven");
    assert!(
        not_nearest > 50,
        "only {not_nearest} copies are not nearest"
    );
}

/// The same for copies around an axis.
#[test]
fn proven_sectors_are_the_nearest() {
    let (mut proven, mut refused) = (0, 0);
    for (name, shape) in shapes() {
        let bounds = shape.aabb();
        if !bounds.is_finite() {
            continue;
        }
        // Far enough from the axis for the sector.
        for (count, share) in [(3u32, 1.0f32), (8, 1.0), (8, 0.3)] {
            let half = std::f32::consts::PI / count as f32;
            let reach = bounds.min.abs().max(bounds.max.abs());
            let away = share * (reach.x + reach.z / half.tan()) * 1.01;
            let mut scene = Scene::new();
            let brush = Brush::new(shape.clone()).at([away, 0.0, 0.0]);
            scene.push(brush).expect("a brush");
            let around = Modifier::RadialRepeat { count };
            let content = extent_of(&scene);
            if !nearest_is_own(&around, &content)[0] {
                refused += 1;
                continue;
            }
            proven += 1;
            assert_eq!(evaluated_copies(&around, &content)[0], 1);
            let mut numbers = CaseRng::new(5);
            for _ in 0..100 {
                let angle = numbers.between(-1.0, 1.0) * half;
                let radius = numbers.between(0.0, 2.0) * (away + reach.x);
                let height = numbers.between(-1.5, 1.5) * (reach.y + 0.1);
                let at = |angle: f32| Vec3::new(radius * angle.cos(), height, radius * angle.sin());
                let d = naive::distance(&scene, at(angle));
                for copy in 1..count {
                    let q = at(angle + 2.0 * half * copy as f32);
                    let gain = d - naive::distance(&scene, q);
                    let bound = f64::from(rounding(q.to_array()));
                    assert!(gain <= bound, "{name}, {count} copies, at {q}: {gain}");
                }
            }
        }
    }
    assert!(
        proven > 15 && refused > 15,
        "{proven} proven, {refused} refused"
    );
}

/// Returns solids for which one copy is proven to suffice, alone and repeated, from the tables of shapes and modifiers.
fn repeated() -> Vec<(String, [Scene; 2])> {
    let mut all = Vec::new();
    let mut add = |name: String, alone: &Scene, brush: Brush| {
        let mut scene = Scene::new();
        if scene.push(brush).is_ok() {
            all.push((name, [alone.snapshot(), scene]));
        }
    };
    let modifiers = Modifier::examples().into_iter().map(Some).chain([None]);
    for modifier in modifiers {
        for (name, shape) in shapes() {
            let mut brush = Brush::new(shape);
            if let Some(modifier) = &modifier {
                brush = brush.with_modifier(modifier.clone());
            }
            let mut scene = Scene::new();
            if scene.push(brush.clone()).is_err() {
                continue;
            }
            let content = extent_of(&scene);
            let size = content.aabb.min.abs().max(content.aabb.max.abs());
            if !size.is_finite() || content.aabb.is_empty() {
                continue;
            }
            for count in [None, Some([3, 2, 3])] {
                let spacing = (2.1 * size).to_array();
                let repeat = Modifier::Repeat { spacing, count };
                if nearest_is_own(&repeat, &content) == [true; 3] {
                    let kind = modifier.as_ref().map_or("none", |given| given.kind());
                    let name = format!("{name}, {kind}, {count:?}");
                    add(name, &scene, brush.clone().with_modifier(repeat));
                }
            }
        }
    }
    all
}

/// One copy gives the oracle's minimum over all of them, on both devices.
#[test]
fn one_copy_is_all_of_them_on_both_devices() {
    let mut field = gpu_field();
    let scenes = repeated();
    assert!(scenes.len() > 40, "only {} scenes", scenes.len());
    let mut differing = 0;
    for (name, [alone, scene]) in &scenes {
        let program = Program::lower(scene).expect("a program");
        assert_eq!(program.max_copies(), 1, "{name}");
        let points = points(40, 8);
        let on_cpu = measure(&program, &points);
        field.update(&program).expect("a program that fits");
        let on_gpu = field.evaluate(&points).wait().expect("answers");
        for ((p, d), answer) in points.iter().zip(&on_cpu).zip(&on_gpu) {
            let expected = naive::distance(scene, Vec3::from(*p));
            if expected > 0.1 * f64::from(FAR) {
                continue;
            }
            let bound = rounding(*p) * program.lipschitz();
            let error = (f64::from(*d) - expected).abs();
            assert!(
                error <= f64::from(bound),
                "{name} at {p:?}: {d}, the oracle {expected}"
            );
            let gap = (answer.distance[0] - d).abs();
            assert!(
                gap <= bound,
                "{name} at {p:?}: gpu {}, cpu {d}",
                answer.distance[0]
            );
            // Negative control: one solid alone is another field.
            differing += usize::from(naive::distance(alone, Vec3::from(*p)) > expected + 0.1);
        }
    }
    assert!(
        differing > 500,
        "only {differing} points are nearer to copies"
    );
}

/// A solid that is not even, or reaches beyond its cell, takes more copies.
#[test]
fn other_solids_take_more_copies() {
    let copies = |shape: Shape, spacing: f32| {
        let mut scene = Scene::new();
        scene.push(Brush::new(shape)).expect("a brush");
        let content = extent_of(&scene);
        evaluated_copies(&along(0, spacing), &content)[0]
    };
    assert_eq!(copies(Shape::sphere(0.5), 1.2), 1);
    assert_eq!(copies(Shape::sphere(0.5), 0.3), 1, "spheres rise");
    assert_eq!(
        copies(Shape::torus(0.4, 0.1), 1.1),
        1,
        "the ring is in its cell"
    );
    assert!(copies(Shape::torus(0.4, 0.1), 0.8) > 1, "rings overlap");
    let leaning = Shape::capsule([-0.3, -0.3, 0.0], [0.3, 0.3, 0.0], 0.1);
    assert!(copies(leaning, 2.0) > 1, "it leans");
    let upright = Shape::capsule([0.0, -0.3, 0.0], [0.0, 0.4, 0.0], 0.1);
    assert_eq!(copies(upright, 2.0), 1);
}
